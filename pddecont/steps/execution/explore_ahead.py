"""Leads of an exploration that are followed elsewhere before their turn; what is not needed then is left.

Their steps get their names when their turn comes. Until then they have some that nothing else has.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, replace
from typing import Any

from pddecont.errors import RunError
from pddecont.exploration import are_as_long
from pddecont.results import Results, Step
from pddecont.runfile import Plan, PlannedStep, extend_plan
from pddecont.simulate import Elsewhere, Turnstile
from pddecont.steps.budget import Budget, OutOfTimeError
from pddecont.steps.context import Context
from pddecont.steps.execution.early import ComputedStep, StepTask, compute_step
from pddecont.steps.execution.explore_leads import Lead, LeadKind
from pddecont.steps.execution.renaming import rename
from pddecont.steps.registry import list_step_kinds

# Steps of a lead as a run file would say them.
Fields = Sequence[Mapping[str, Any]]


@dataclass(frozen=True, eq=False)
class LeadTask:
    """A lead to be followed: the step that it starts from, what is recorded of that, and the steps that follow it.

    ``file`` is what the results file says of itself; ``budget`` is what the lead may spend.
    """

    above: PlannedStep[Any]
    source: Step
    steps: Sequence[PlannedStep[Any]]
    file: Results
    budget: Budget


def choose_unlike(
    leads: Iterable[Lead], others: Iterable[Lead], are_alike: Callable[[Lead, Lead], bool], number: int
) -> list[Lead]:
    """Return the first so many leads that are not like others, nor like each other."""
    chosen, taken = list[Lead](), list(others)
    for lead in leads:
        if not any(are_alike(lead, other) for other in taken):
            chosen.append(lead)
            taken.append(lead)
        if len(chosen) == number:
            break
    return chosen


def may_be_one_branch(lead: Lead, other: Lead) -> bool:
    """Return whether two leads may well lie on one branch: motions as long as each other."""
    switches = LeadKind.SWITCH in (lead.kind, other.kind)
    return not switches and are_as_long(lead.motion.period, other.motion.period)


def may_be_one_curve(lead: Lead, other: Lead) -> bool:
    """Return whether two special points may well lie on one curve: of one kind, of motions as long as each other."""
    return lead.label == other.label and are_as_long(lead.motion.period, other.motion.period)


def plan_lead(context: Context, lead: Lead, steps: Fields) -> LeadTask:
    """Return the task of following a lead by steps, each of which starts from the one before."""
    plan, kinds, file = context.plan, list_step_kinds(), context.file
    assert file is not None and context.elsewhere is not None, "it is followed elsewhere, from what the file holds"
    for one in steps:
        plan = extend_plan(plan, kinds, one)
    planned = [plan.find_step(str(one["name"])) for one in steps]
    # Clocks of other machines tell another time.
    budget = Budget() if context.elsewhere.on_cluster else context.budget
    # A copy: nobody here changes it while it is sent.
    source = replace(file.step(lead.step))
    return LeadTask(plan.find_step(lead.step), source, planned, replace(file, names=(), steps={}), budget)


def compute_lead(plan: Plan, task: LeadTask) -> list[ComputedStep]:
    """Do the steps of a lead and keep a log of each; none after one that fails, or when the time is over."""
    known = {step.name for step in plan.steps}
    new = [step for step in (task.above, *task.steps) if step.name not in known]
    plan = replace(plan, steps=(*plan.steps, *new))
    done: list[ComputedStep] = []
    for step in task.steps:
        held = done[-1].log if done else task.source
        try:
            done.append(compute_step(plan, StepTask(step.name, task.file, held, {}, False, task.budget)))
        except OutOfTimeError:
            break
        if done[-1].error is not None:
            break
    return done


class LeadsAhead:
    """Leads that may be followed before their turn, those that are, and those that were."""

    def __init__(self, elsewhere: Elsewhere):
        self._elsewhere = elsewhere
        self._waiting: dict[Lead, LeadTask] = {}
        self._begun: dict[Lead, tuple[LeadTask, Future[list[ComputedStep]]]] = {}
        self._n_planned = 0
        self._turnstile = Turnstile(self._begin_all)

    @property
    def begun(self) -> list[Lead]:
        """Those that have begun and whose turn has not come."""
        with self._turnstile.lock:
            return list(self._begun)

    def offer(
        self,
        context: Context,
        prefix: str,
        here: Lead,
        leads: Iterable[Lead],
        are_alike: Callable[[Lead, Lead], bool],
        plan_steps: Callable[[Lead, str], Fields],
    ) -> None:
        """Say which leads may be begun while one is followed here, the first ones first; those that have begun go on.

        They are as many as there are places, and not alike. ``plan_steps`` returns the steps of a lead; it is given
        what their names begin with, after ``prefix`` a number that no other lead has.
        """
        chosen = choose_unlike(leads, (here, *self.begun), are_alike, self._elsewhere.slots.number)
        tasks = {}
        for lead in chosen:
            if lead in self._waiting:
                tasks[lead] = self._waiting[lead]
                continue
            self._n_planned += 1
            # What is wrong with a step is said in its turn.
            with contextlib.suppress(RunError):
                tasks[lead] = plan_lead(context, lead, plan_steps(lead, f"{prefix}lead_{self._n_planned}"))
        with self._turnstile.lock:
            self._waiting = {lead: task for lead, task in tasks.items() if lead not in self._begun}

    def begin(self) -> None:
        """Begin leads as far as somebody is free."""
        self._turnstile.begin()

    def _begin_all(self) -> None:
        for lead, task in list(self._waiting.items()):
            future = self._elsewhere.begin(compute_lead, task)
            if future is None:
                break
            self._begun[lead] = task, future
            del self._waiting[lead]

    def take(self, lead: Lead, steps: Fields) -> dict[str, ComputedStep]:
        """Return what was computed of the steps of a lead whose turn it is, by the names that they get."""
        names = [str(one["name"]) for one in steps]
        with self._turnstile.lock:
            self._waiting.pop(lead, None)
            begun = self._begun.pop(lead, None)
        computed = None if begun is None else self._elsewhere.wait(begun[1])
        if begun is None or computed is None:
            return {}
        renamed = {step.name: name for step, name in zip(begun[0].steps, names, strict=True)}
        return {name: rename(one, renamed) for name, one in zip(names, computed, strict=False)}

    def forget(self, lead: Lead) -> None:
        """Hear that a lead is not needed."""
        with self._turnstile.lock:
            self._waiting.pop(lead, None)
            begun = self._begun.pop(lead, None)
        if begun is not None:
            self._elsewhere.take_back(begun[1])

    def end(self) -> None:
        """Begin no more."""
        self._turnstile.end()


@contextlib.contextmanager
def follow_ahead(elsewhere: Elsewhere | None) -> Iterator[LeadsAhead | None]:
    """Yield what follows leads before their turn, if there are others to do so; none is begun after the context."""
    if elsewhere is None:
        yield None
        return
    ahead, before = LeadsAhead(elsewhere), elsewhere.slots.on_free

    def begin_all() -> None:
        before()
        ahead.begin()

    elsewhere.slots.on_free = begin_all
    try:
        yield ahead
    finally:
        ahead.end()
        elsewhere.slots.on_free = before
