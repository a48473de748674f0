"""The steps of a run one after another, with what is computed of them elsewhere before their turn."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import replace
from typing import Any

from pddecont.bifurcation import has_registered_kinds
from pddecont.runfile import Plan, PlannedStep
from pddecont.simulate import open_elsewhere
from pddecont.steps.context import Context
from pddecont.steps.execution.early import compute_early, write_computed
from pddecont.steps.execution.one_step import do_step
from pddecont.steps.kind import Sharing, StepKind
from pddecont.steps.registry import has_registered_step_kinds, list_step_kinds


def do_steps(context: Context, steps: Sequence[PlannedStep[Any]]) -> None:
    """Do steps in order: each is written when its turn comes, wherever it was computed."""
    if not has_many_workers(context):
        for step in steps:
            do_step(context, step)
        return
    with open_elsewhere(context.workers, context.plan) as elsewhere:
        slots = elsewhere.slots
        here = replace(context, elsewhere=elsewhere, workers=replace(context.workers, slots=slots))
        if any(kind.sharing == Sharing.EARLY for step in steps for kind in list_kinds(step.kind)):
            elsewhere.prepare(load_kinds)
        with compute_early(here, steps, elsewhere) as early:
            for step in steps:
                computed = early.take(step)
                if computed is not None:
                    write_computed(here, step, computed)
                else:
                    slots.sit()
                    with slots.hold(slots.number - 1) if is_alone(step) else nullcontext():
                        early.begin()
                        do_step(here, step)
                early.put(step)


def has_many_workers(context: Context) -> bool:
    """Return whether there are others to compute.

    Kinds that others made known are known in this process alone: with them all is computed here.
    """
    if has_registered_kinds() or has_registered_step_kinds():
        return False
    return context.workers.number > 1 or context.workers.scheduler is not None


def load_kinds(plan: Plan, _: None) -> None:
    """Import what does the steps of a run."""
    for step in plan.steps:
        for kind in list_kinds(step.kind):
            kind.load()


def list_kinds(name: str) -> list[StepKind[Any, Any]]:
    """Return a kind of step and those of the steps that it plans."""
    kinds = list_step_kinds()
    return [kinds[one] for one in (name, *kinds[name].plans)]


def is_alone(step: PlannedStep[Any]) -> bool:
    """Return whether nothing else is computed while a step is."""
    return list_step_kinds()[step.kind].sharing == Sharing.ALONE
