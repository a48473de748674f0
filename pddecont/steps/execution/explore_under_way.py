"""An exploration under way: it plans ordinary steps, sees to it that they are done, and knows what they found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ConvergenceError, RunError, SignatureError
from pddecont.exploration import RecordedBranch, Survey, Symmetry, fingerprint_orbits, read_branch
from pddecont.orbit import count_repetitions
from pddecont.reasons import make_reason
from pddecont.results import ORBIT, Step
from pddecont.runfile import Plan, Source, extend_plan
from pddecont.steps.budget import OutOfTimeError
from pddecont.steps.context import Context
from pddecont.steps.execution.early import ComputedStep, write_computed
from pddecont.steps.execution.explore_ahead import LeadsAhead, may_be_one_branch
from pddecont.steps.execution.explore_curves import Curve
from pddecont.steps.execution.explore_diagram import Diagram, Entry
from pddecont.steps.execution.explore_leads import (
    Lead,
    LeadKind,
    list_attractor_leads,
    list_equilibrium_leads,
    list_own_states,
    list_switch_leads,
    plan_branch,
    plan_edges,
    plan_search,
    plan_sweep,
)
from pddecont.steps.execution.explore_looks import Look, LookCode, look_at_sweep, name_irregular
from pddecont.steps.execution.explore_tori import (
    TorusLead,
    TorusPoint,
    covers,
    list_leads_of_motions,
    list_torus_leads,
    look_at_torus,
    plan_torus,
)
from pddecont.steps.execution.one_step import do_step
from pddecont.steps.execution.recorded_orbits import find_orbit
from pddecont.steps.explore import ExploreSettings
from pddecont.steps.registry import list_step_kinds

Array = NDArray[np.float64]
# Parameter values at which equilibria are looked for.
N_SEARCHES = 3
# Of the motions of the first sweep such a part once more start at either end of the range.
EDGE_PART = 2
# States up to which all equilibria in a box are looked for.
MOST_SEARCHED = 6


@dataclass(eq=False)
class Exploration:
    """An exploration under way.

    ``symmetries`` are the model's; ``leads`` are those that wait; ``prefix`` is that of its steps; ``own`` holds the
    parameters that its step sets, ``at`` those too and where branches are in a second parameter; ``ahead`` follows
    leads before their turn.
    """

    context: Context
    settings: ExploreSettings
    survey: Survey
    symmetries: tuple[Symmetry, ...]
    prefix: str
    own: dict[str, Any]
    at: dict[str, Any]
    ahead: LeadsAhead
    diagram: Diagram = field(default_factory=Diagram)
    leads: list[Lead] = field(default_factory=list)
    looks: list[Look] = field(default_factory=list)
    curves: list[Curve] = field(default_factory=list)
    curve_entries: list[Entry] = field(default_factory=list)
    plane: list[Look] = field(default_factory=list)
    tori: list[TorusPoint] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)
    n_begun: int = 0
    n_tori: int = 0

    @property
    def plan(self) -> Plan:
        """The plan so far."""
        return self.context.plan

    @property
    def parameter(self) -> str:
        """The parameter that branches are in."""
        return next(iter(self.settings.over))

    @property
    def number(self) -> int:
        """Its number."""
        return self.plan.numeric.parameter_index(self.parameter)

    @property
    def scale(self) -> Array:
        """How far motions of the model go (n_states,)."""
        return self.survey.high - self.survey.low

    @property
    def stopped(self) -> str:
        """What allows no further branch: "time", "max_branches", or nothing."""
        if self.context.budget.is_over:
            return "time"
        most = self.context.budget.max_branches or self.settings.body.max_branches
        return "max_branches" if self.n_begun >= most else ""

    def do(self, fields: Mapping[str, Any], computed: ComputedStep | None = None) -> Step:
        """Plan a step and do it, unless it was ``computed`` already; return what the file holds of it then."""
        name = str(fields["name"])
        assert self.context.file is not None, "a run has a file"
        self.context.plan = extend_plan(self.plan, list_step_kinds(), fields)
        step = self.plan.find_step(name)
        if computed is not None and name not in self.context.file.steps:
            write_computed(self.context, step, computed)
        else:
            if self.context.elsewhere is not None:
                self.context.elsewhere.slots.sit()
            do_step(self.context, step)
        return self.context.file.step(name)

    def try_to_do(self, fields: Mapping[str, Any], computed: ComputedStep | None = None) -> Step | None:
        """Do a step; None, and what went wrong noted, if it fails."""
        try:
            return self.do(fields, computed)
        except (ConvergenceError, SignatureError, RunError) as exc:
            self.failures.append(f"{fields['name']}: {exc}")
            self.context.reporter.note(str(exc))
            return None

    def search_equilibria(self) -> None:
        """Look for all equilibria at a few parameters, and note them as leads."""
        model = self.plan.model
        if model.forced or len(model.states) > MOST_SEARCHED:
            return
        low, high = self.settings.over[self.parameter]
        for k, value in enumerate(np.linspace(low, high, N_SEARCHES).tolist(), 1):
            self.context.budget.check()
            at = {**self.at, self.parameter: value}
            recorded = self.try_to_do(plan_search(self.plan, self.settings, self.survey, f"{self.prefix}rest_{k}", at))
            if recorded is not None:
                self.leads += list_equilibrium_leads(recorded, self.number)

    def explore(self) -> None:
        """Do all that there is to do in one parameter; raise OutOfTimeError where the time is over amid a sweep."""
        body = self.settings.body
        self.search_equilibria()
        sweep = self.sweep("sweep", body.starts, body.seed)
        self.sweep_edges(sweep)
        self.follow_all()
        if body.check and self.stopped != "time":
            self.sweep("check", body.check, body.seed + 1)
            self.follow_all()
        if self.stopped != "time":
            self.name_unexplained()
            self.follow_tori(sweep)
            self.follow_all()

    def sweep(self, name: str, number: int, seed: int) -> dict[str, Any]:
        """Let motions settle, look at them, and note the periodic ones as leads; return the step that did so."""
        fields = plan_sweep(self.plan, self.settings, self.survey, f"{self.prefix}{name}", self.at, number, seed)
        self._look_at(fields)
        return fields

    def sweep_edges(self, sweep: Mapping[str, Any]) -> None:
        """Do the same at both ends of the range, beyond which nothing is followed."""
        number = max(1, self.settings.body.starts // EDGE_PART)
        self._look_at(plan_edges(sweep, f"{self.prefix}edges", self.parameter, number))

    def _look_at(self, fields: Mapping[str, Any]) -> None:
        recorded = self.do(fields)
        looks = look_at_sweep(self.plan, recorded, self.survey)
        self.looks += looks
        self.leads += list_attractor_leads(looks, self.number)

    def follow_all(self) -> None:
        """Follow leads until there are none, of one rank in the order in which they were found."""
        while self.leads:
            lead = min(self.leads, key=lambda waiting: waiting.rank)
            self.leads.remove(lead)
            if self._is_known(lead):
                self.ahead.forget(lead)
                continue
            left = "depth" if lead.depth > self.settings.body.depth else self.stopped
            if left:
                self.diagram.entries.append(Entry(lead, make_reason("left", origin=lead.origin, why=left)))
            else:
                self._offer(lead)
                self._follow(lead)

    def _offer(self, lead: Lead) -> None:
        """Say which leads may be followed elsewhere while one is here."""
        later = sorted(self.leads, key=lambda waiting: waiting.rank)
        unknown = (one for one in later if one.depth <= self.settings.body.depth and not self._is_known(one))

        def plan_steps(one: Lead, name: str) -> list[dict[str, Any]]:
            return plan_branch(self.settings, one, f"{name}_orbit", f"{name}_branch")

        self.ahead.offer(lead, unknown, may_be_one_branch, plan_steps)

    def _is_known(self, lead: Lead) -> bool:
        """Return whether a lead leads to a branch that is there.

        An attractor that seems to lie where a branch is not stable may be another motion near to it.
        """
        if lead.kind != LeadKind.SWITCH:
            place = self.diagram.find(lead.motion, lead.value)
            return place is not None and (lead.kind != LeadKind.ATTRACTOR or place.is_stable is True)
        return self.diagram.find_joined(lead) is not None

    def _follow(self, lead: Lead) -> None:
        """Follow a lead, and note the leads from its branch."""
        self.n_begun += 1
        try:
            self._follow_as(lead, f"{self.prefix}branch_{self.n_begun}")
        except OutOfTimeError:
            self.diagram.entries.append(Entry(lead, make_reason("left", origin=lead.origin, why=self.stopped)))

    def _follow_as(self, lead: Lead, name: str) -> None:
        steps = plan_branch(self.settings, lead, f"{self.prefix}orbit_{self.n_begun}", name)
        computed = self.ahead.take(lead, steps)
        recorded = None
        for fields in steps:
            recorded = self.try_to_do(fields, computed.get(fields["name"]))
            same = None if recorded is None else self._find_branch_of(recorded)
            if recorded is not None and same is not None:
                self._leave_repeated(lead, name, [recorded.name], same)
                return
            why = self.failures[-1] if recorded is None else self._find_objection(recorded)
            if why:
                if recorded is not None:
                    self.context.drop_step(recorded.name)
                failed = make_reason("failed", step=name, origin=lead.origin, why=why)
                self.diagram.entries.append(Entry(lead, failed))
                return
        assert recorded is not None, "there is a step at least"
        branch = self.read_branch(recorded)
        same = self.diagram.find_repeated(branch)
        if same is not None:
            self._leave_repeated(lead, name, [str(fields["name"]) for fields in reversed(steps)], same)
            return
        followed = make_reason("followed", step=name, origin=lead.origin)
        self.diagram.entries.append(Entry(lead, followed, branch))
        self.leads += list_switch_leads(branch, lead.depth)

    def _leave_repeated(self, lead: Lead, name: str, done: list[str], same: str) -> None:
        """Take steps out of the file again that led to a branch that is there, and note which one it is."""
        for step in done:
            self.context.drop_step(step)
        self.diagram.entries.append(Entry(lead, make_reason("repeated", step=name, origin=lead.origin, same=same)))

    def read_branch(self, recorded: Step) -> RecordedBranch:
        """Return the branch that a step recorded."""
        low, high = self.settings.over[self.parameter]
        return read_branch(recorded, self.parameter, high - low, self.scale, self.symmetries)

    def _find_branch_of(self, recorded: Step) -> str | None:
        """Return the branch that the orbit of a step lies on; None if it lies on none, or the step is none."""
        if recorded.kind != ORBIT.kind:
            return None
        (motion,) = fingerprint_orbits(recorded, np.array([0]))
        known = self.diagram.find(motion, float(recorded.points["parameters"][0, self.number]))
        return None if known is None else known.branch

    def _find_objection(self, recorded: Step) -> str:
        """Return why the orbit of a step is not followed: it is another several times over."""
        if recorded.kind != ORBIT.kind:
            return ""
        source = Source.model_validate({"step": recorded.name})
        orbit = find_orbit(self.context, self.plan.find_step(recorded.name), source)
        n = count_repetitions(orbit)
        return f"its orbit is one of period {orbit.period / n:.10g}, {n} times over" if n > 1 else ""

    def follow_tori(self, sweep: Mapping[str, Any]) -> None:
        """Follow tori from where they are born, then those that motions were seen on where none was followed."""
        assert self.context.file is not None, "a run has a file"
        for branch in list(self.diagram.branches):
            for lead in list_torus_leads(branch, self.plan.model.states, self.scale):
                self._follow_torus(sweep, lead)
        limits = self.settings.over[self.parameter]
        for lead in list_leads_of_motions(self.looks, self.plan, self.number, limits, self.context.file.step):
            if not covers(self.tori, lead, self.number, limits):
                self._follow_torus(sweep, lead)

    def _follow_torus(self, sweep: Mapping[str, Any], lead: TorusLead) -> None:
        """Follow a torus, and note what it locks to as leads."""
        if self.stopped:
            return
        self.n_tori += 1
        name = f"{self.prefix}torus_{self.n_tori}"
        recorded = self.try_to_do(plan_torus(sweep, lead, self.parameter, name, list_own_states(self.plan)))
        if recorded is not None:
            looks = look_at_sweep(self.plan, recorded, self.survey)
            points = [look_at_torus(self.plan, recorded, look, lead.origin, self.survey) for look in looks]
            self.tori += points
            locked = list_attractor_leads([point.look for point in points], self.number)
            # What fell back onto an orbit that is there, stable or not, is no new one.
            self.leads += [one for one in locked if self.diagram.find(one.motion, one.value) is None]

    def name_unexplained(self) -> None:
        """Find out what motions without period are that lie on no branch."""
        assert self.context.file is not None, "a run has a file"
        for k, look in enumerate(self.looks):
            if look.code == LookCode.IRREGULAR:
                self.context.budget.check()
                self.looks[k] = name_irregular(self.plan, self.context.file.step(look.sweep), look, self.survey)
