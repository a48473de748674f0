"""What an exploration has to follow yet, and the steps that do so, as a run file would say them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from pddecont.exploration import Fingerprint, RecordedBranch, Survey, fingerprint_orbits
from pddecont.model import parse_document, write_formula
from pddecont.results import Step
from pddecont.runfile import Plan
from pddecont.steps.execution.explore_looks import Look
from pddecont.steps.explore import ExploreSettings

# Forcing periods that a motion is given to settle.
FORCING_PERIODS = 300
# Digits of numbers that are chosen here.
DIGITS = 6
# Points at which branches of orbits and of equilibria branch.
OF_ORBITS, OF_EQUILIBRIA = ("BP", "PD"), ("BP", "HB")
DOUBLING = "PD"
# What is recorded of a doubling at which a branch of doubled orbits ends.
HALVED = "halves_equal"
# By how many period doublings later a branch has its turn that leaves one which is unstable on both sides.
UNSTABLE_WAITS = 2


class LeadKind(StrEnum):
    """What a lead is."""

    ATTRACTOR = "attractor"
    EQUILIBRIUM = "equilibrium"
    SWITCH = "switch"
    SINGLE = "single"


@dataclass(frozen=True, eq=False)
class Lead:
    """Something to be followed: a point of a step, what it is, and how many period doublings lead to it.

    ``motion`` is what it is at ``value`` of the parameter that branches are in; ``label`` the kind of special point;
    ``is_stable`` whether what lies beside a special point is stable on one side.
    """

    kind: LeadKind
    step: str
    point: str
    motion: Fingerprint
    value: float
    depth: int = 0
    label: str = ""
    is_stable: bool = True

    @property
    def rank(self) -> int:
        """How late its turn comes: what is born unstable waits."""
        return self.depth + (0 if self.is_stable else UNSTABLE_WAITS)

    @property
    def origin(self) -> str:
        """The point in words of names: step and label."""
        return f"{self.step} {self.point}"


def list_own_states(plan: Plan) -> list[str]:
    """Return the states that the model's file names: clocks and the like that are added to them begin where they do."""
    own = parse_document(plan.model_text, "the model").data["states"]
    return [name for name in plan.model.states if name in own]


def plan_sweep(
    plan: Plan, settings: ExploreSettings, survey: Survey, name: str, at: Mapping[str, Any], number: int, seed: int
) -> dict[str, Any]:
    """Return a sweep of so many motions, which begin in the box, over all parameters but those that are set ``at``."""
    body, own = settings.body, list_own_states(plan)
    names = list(plan.model.states)
    box = {name: [_round(survey.low[names.index(name)]), _round(survey.high[names.index(name)])] for name in own}
    box |= {name: list(limits) for name, limits in settings.box.items()}
    over = {key: list(limits) for key, limits in settings.over.items() if key not in at}
    # Of a Sobol sequence the product alone counts, but each range must have two ends.
    counts = [number] if len(over) == 1 else [-(-number // 2), 2]
    how: dict[str, Any] = {"rtol": body.rtol, "atol": body.atol, "method": body.method, "stick": dict(body.stick)}
    how |= {} if body.max_step is None else {"max_step": body.max_step}
    sweep: dict[str, Any] = {
        **how,
        "over": {key: [*limits, n] for (key, limits), n in zip(over.items(), counts, strict=True)},
        "initial": [{"history": "constant"}],
        "random": {"number": 1, "seed": seed, "box": box, "spread": "sobol"},
        "max_period": body.max_period,
        "transient": _choose_transient(plan, settings, survey),
    }
    sweep["section"] = _choose_section(plan, settings, survey)
    return {"name": name, "set": dict(at), "sweep": sweep}


def _choose_transient(plan: Plan, settings: ExploreSettings, survey: Survey) -> str | float:
    if settings.transient is not None:
        return settings.transient
    if plan.model.period is not None:
        return f"{FORCING_PERIODS}*({write_formula(plan.model.period)})"
    return _round(survey.transient)


def _choose_section(plan: Plan, settings: ExploreSettings, survey: Survey) -> dict[str, Any]:
    if settings.body.section is not None:
        return dict(settings.body.section.model_dump(exclude_none=True))
    if plan.model.forced:
        return {"phase": _round(survey.phase) % 1.0}
    if survey.event:
        return {"event": survey.event}
    terms = [f"({_round(c)})*{name}" for c, name in zip(survey.level[1:], settings.over, strict=False)]
    return {"zero": " - ".join([f"{plan.model.states[survey.state]} - ({_round(survey.level[0])})", *terms])}


def plan_edges(sweep: Mapping[str, Any], name: str, parameter: str, number: int) -> dict[str, Any]:
    """Return a sweep like another, of so many motions at each end of a parameter's range."""
    body = sweep["sweep"]
    over = {parameter: [*body["over"][parameter][:2], 2]}
    random = {**body["random"], "number": number, "spread": "same"}
    return {**sweep, "name": name, "sweep": {**body, "over": over, "random": random}}


def plan_search(
    plan: Plan, settings: ExploreSettings, survey: Survey, name: str, at: Mapping[str, Any]
) -> dict[str, Any]:
    """Return a search for all equilibria at some parameters, in a box twice as wide as that of the motions."""
    middle, half = 0.5 * (survey.low + survey.high), survey.high - survey.low
    box = {
        state: [_round(low), _round(high)]
        for state, low, high in zip(plan.model.states, middle - half, middle + half, strict=True)
    }
    return {"name": name, "set": dict(at), "equilibrium": {"search": box}}


def plan_branch(settings: ExploreSettings, lead: Lead, orbit: str, branch: str) -> list[dict[str, Any]]:
    """Return the steps that follow a lead: an orbit first, of an attractor, then the branch."""
    parameter, limits = next(iter(settings.over.items()))
    source = {"step": lead.step, "point": lead.point}
    follow: dict[str, Any] = {
        "free": [parameter],
        "range": {parameter: list(limits)},
        "step": settings.body.step.model_dump(),
        "max_points": settings.body.max_points,
    }
    if lead.kind == LeadKind.EQUILIBRIUM:
        return [{"name": branch, "continue": {"from": source, **follow}}]
    follow |= {"stability": True, "period_halving": "stop"}
    if lead.kind == LeadKind.SWITCH:
        return [{"name": branch, "continue": {"from": source, "branch": "switch", **follow}}]
    return [{"name": orbit, "orbit": {"from": source}}, {"name": branch, "continue": {"from": orbit, **follow}}]


def list_attractor_leads(looks: Sequence[Look], number: int) -> Iterator[Lead]:
    """Yield the periodic motions among looks; ``number`` is that of the parameter that branches are in."""
    for look in looks:
        if look.can_start_orbit and look.motion is not None:
            yield Lead(LeadKind.ATTRACTOR, look.sweep, look.point, look.motion, float(look.parameters[number]))


def list_equilibrium_leads(recorded: Step, number: int) -> Iterator[Lead]:
    """Yield the equilibria that a search found and that lie in their modes."""
    rows = np.flatnonzero(recorded.points["admissible"] != 0)
    for row, motion in zip(rows, fingerprint_orbits(recorded, rows), strict=True):
        value = float(recorded.points["parameters"][row, number])
        yield Lead(LeadKind.EQUILIBRIUM, recorded.name, recorded.labels[row], motion, value)


def list_switch_leads(branch: RecordedBranch, depth: int) -> Iterator[Lead]:
    """Yield the special points of a branch at which others leave it, in order along it."""
    step = branch.step
    wanted = OF_EQUILIBRIA if "roots" in step.format.orbits else OF_ORBITS
    stable = step.points["stable"][branch.rows] == 1
    for k, (row, motion) in enumerate(zip(branch.rows, branch.motions, strict=True)):
        kind, value = step.kind_of(int(row)), float(branch.parameter[k])
        if kind == DOUBLING and step.reason(int(row)).code == HALVED:
            # Here the branch fell onto the single orbit, which may not be known yet.
            yield Lead(LeadKind.SINGLE, step.name, step.labels[row], motion, value, depth)
        elif kind in wanted:
            beside = bool(stable[max(0, k - 1) : k + 2].any())
            deeper = depth + (kind == DOUBLING)
            yield Lead(LeadKind.SWITCH, step.name, step.labels[row], motion, value, deeper, kind, beside)


def _round(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
