"""A plan with one more step, which a step that plans others has thought of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from pddecont.errors import Problem, RunError
from pddecont.runfile.checker import Checker, Path
from pddecont.runfile.kinds import StepKind
from pddecont.runfile.plan import Plan
from pddecont.runfile.planner import StepPlanner
from pddecont.runfile.schema import make_run_types


def extend_plan(plan: Plan, kinds: Mapping[str, StepKind], step: Mapping[str, Any]) -> Plan:
    """Return a plan with a step after all others, given as a run file would: a mapping with ``name`` and its kind.

    Raises
    ------
    RunError
        With all that is wrong with it.
    """
    block_type, _ = make_run_types(list(kinds.values()))
    # A step is checked against those above it alone, and of them only where it starts matters.
    source = (step[next(kind for kind in kinds if kind in step)] or {}).get("from")
    above = source if isinstance(source, str) else source.get("step") if isinstance(source, Mapping) else None
    fields = [_drop_nulls(known.fields) for known in plan.steps if known.name in (above, step["name"])]
    run = block_type.model_validate({**_drop_nulls(plan.shared), "steps": [*fields, step]})

    def make_problem(path: Path, message: str, *, offset: int = 0, key: bool = False) -> Problem:
        return Problem(plan.source, 0, 0, f"step '{step['name']}': {message}")

    checker = Checker(plan.model, make_problem, plan.source)
    values = plan.name_values(plan.parameters)
    planner = StepPlanner(checker, run, kinds, plan.numeric, values, plan.monitors, plan.base)
    planned = planner.plan_step(len(run.steps) - 1)
    if checker.errors:
        raise RunError(checker.errors)
    return replace(plan, steps=(*plan.steps, planned))


def _drop_nulls(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Return what a step says without the keys that it leaves out."""
    return {key: value for key, value in fields.items() if value is not None}
