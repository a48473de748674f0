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
from pddecont.simulate import Turnstile
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
    """Leads of an exploration that may be followed before their turn, those that are, and those that were.

    Where there are no others to compute there are none. Names of its steps begin with ``prefix``.
    """

    def __init__(self, context: Context, prefix: str):
        self._context, self._prefix = context, prefix
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
        here: Lead,
        leads: Iterable[Lead],
        are_alike: Callable[[Lead, Lead], bool],
        plan_steps: Callable[[Lead, str], Fields],
    ) -> None:
        """Say which leads may be begun while one is followed here, the first ones first; those that have begun go on.

        They are as many as there are places, and not alike. ``plan_steps`` returns the steps of a lead; it is given
        what their names begin with, in it a number that no other lead has.
        """
        if self._context.elsewhere is None:
            return
        tasks = {}
        for lead in choose_unlike(leads, (here, *self.begun), are_alike, self._context.elsewhere.slots.number):
            if lead in self._waiting:
                tasks[lead] = self._waiting[lead]
                continue
            self._n_planned += 1
            # What is wrong with a step is said in its turn.
            with contextlib.suppress(RunError):
                steps = plan_steps(lead, f"{self._prefix}lead_{self._n_planned}")
                tasks[lead] = plan_lead(self._context, lead, steps)
        with self._turnstile.lock:
            self._waiting = {lead: task for lead, task in tasks.items() if lead not in self._begun}

    @contextlib.contextmanager
    def begin_as_places_get_free(self) -> Iterator[None]:
        """Begin leads whenever somebody is free, until the context has ended."""
        elsewhere = self._context.elsewhere
        if elsewhere is None:
            yield
            return
        before = elsewhere.slots.on_free

        def begin() -> None:
            before()
            self._turnstile.begin()

        elsewhere.slots.on_free = begin
        try:
            yield
        finally:
            self._turnstile.end()
            elsewhere.slots.on_free = before

    def _begin_all(self) -> None:
        assert self._context.elsewhere is not None, "leads wait for others"
        for lead, task in list(self._waiting.items()):
            future = self._context.elsewhere.begin(compute_lead, task)
            if future is None:
                break
            self._begun[lead] = task, future
            del self._waiting[lead]

    def take(self, lead: Lead, steps: Fields) -> dict[str, ComputedStep]:
        """Return what was computed of the steps of a lead whose turn it is, by the names that they get."""
        begun = self._remove(lead)
        if begun is None or self._context.elsewhere is None:
            return {}
        names = [str(one["name"]) for one in steps]
        renamed = {step.name: name for step, name in zip(begun[0].steps, names, strict=True)}
        # Nothing, if whoever computed was lost; less than all, if a step failed or the time was over.
        computed = self._context.elsewhere.wait(begun[1]) or []
        return {name: rename(one, renamed) for name, one in zip(names, computed, strict=False)}

    def forget(self, lead: Lead) -> None:
        """Hear that a lead is not needed."""
        begun = self._remove(lead)
        if begun is not None and self._context.elsewhere is not None:
            self._context.elsewhere.take_back(begun[1])

    def _remove(self, lead: Lead) -> tuple[LeadTask, Future[list[ComputedStep]]] | None:
        with self._turnstile.lock:
            self._waiting.pop(lead, None)
            return self._begun.pop(lead, None)
