"""From an attractor of a sweep or basin step back to a motion, which goes on from its recorded state."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter

from pddecont.errors import Problem, ResultsError
from pddecont.results import Step
from pddecont.runfile import Checker, Delay, Path, Plan, Source, StepInput, make_step_type
from pddecont.simulate import (
    Attractor,
    MotionTask,
    Simulator,
    Trajectory,
    find_longest_lag,
    find_restart_time,
    read_time,
    record_trajectory,
    shift_time,
    unpack_motion,
)
from pddecont.steps.context import Context
from pddecont.steps.execution.attractor_rows import attractor_from_row
from pddecont.steps.registry import list_step_kinds
from pddecont.tables import describe_reason, list_effects_off

Array = NDArray[np.float64]
# Turns of an attractor that are integrated, and least in all: the second half of them shows its period twice.
TURNS, LEAST = 6, 8


def continue_attractor(context: Context, recorded: Step, source: Source) -> tuple[Trajectory, Array]:
    """Return some periods of a recorded attractor, computed as it was, and its parameters.

    Raises
    ------
    ResultsError
        If the row holds no attractor with a period, or its step was another run's and cannot be continued here.
    """
    plan = context.plan
    if source.point is None and source.index is None:
        labels = [x for x in recorded.labels if x]
        raise ResultsError(
            f"step '{source.step}' holds {len(labels)} attractors; say which: "
            f"{{step: {source.step}, point: {labels[0] if labels else 'A1'}}}"
        )
    row = recorded.row(source.point) if source.point else source.index or 0
    if row >= len(recorded):
        raise ResultsError(f"step '{source.step}' has {len(recorded)} rows, no index {row}")
    if not recorded.kind_of(row) or recorded.points["period"][row] <= 0:
        why = describe_reason(recorded.reason(row))
        raise ResultsError(
            f"{source.point or source.index} of step '{source.step}' has no period that was found"
            f"{f': {why}' if why else ''}; a periodic orbit cannot start from it"
        )
    attractor = attractor_from_row(recorded, row)
    if recorded.meta["model"] != plan.model.name or recorded.meta["parameters"] != list(plan.model.parameters):
        raise ResultsError(f"step '{source.step}' comes from another model, '{recorded.meta['model']}'")
    _check_effects(plan, recorded, source)
    longest = find_longest_lag(plan.numeric, attractor.p)
    duration = max(TURNS, LEAST / attractor.period) * attractor.turn + longest
    simulator = read_task(plan, recorded).make_simulator()
    return follow_attractor(simulator, attractor, duration, recorded.name), attractor.p


def follow_attractor(
    simulator: Simulator, attractor: Attractor, duration: float, name: str, *, after: float = 0.0
) -> Trajectory:
    """Return the motion of an attractor that step ``name`` recorded, from where it stood, for a time.

    It begins some time ``after`` that.

    Raises
    ------
    ResultsError
        If what is recorded is no motion of the model.
    """
    values = simulator.values(attractor.p)
    try:
        state = unpack_motion(simulator.reached, values, attractor.packed_state)
    except ValueError as exc:
        raise ResultsError(f"step '{name}': {exc}; the file is damaged or was made by a changed model") from exc
    state = shift_time(state, find_restart_time(simulator.numeric, attractor.p, attractor.p, read_time(state)))
    begin = read_time(state) + after
    return record_trajectory(simulator, attractor.p, state, begin + duration, keep_from=begin)


def _check_effects(plan: Plan, recorded: Step, source: Source) -> None:
    try:
        off = list_effects_off(recorded)
    except (ValueError, KeyError, TypeError, AttributeError) as exc:
        raise _damaged(recorded) from exc
    off_here = list(plan.model.left_out.effects)
    if off != off_here:
        here, there = (f"without {', '.join(names)}" if names else "with all effects" for names in (off_here, off))
        raise ResultsError(
            f"step '{source.step}' was computed {there}, this run is {here}; an orbit starts from attractors of the "
            "same effects"
        )


def read_task(plan: Plan, recorded: Step) -> MotionTask:
    """Return how motions of a recorded step were computed, from its settings."""
    kinds = list_step_kinds()
    try:
        settings = json.loads(recorded.meta["settings"])
        fields = {name: value for name, value in settings["step"].items() if value is not None}
        block: Any = TypeAdapter(make_step_type(list(kinds.values()))).validate_python(fields)
        delay: Delay = block.delay or Delay.model_validate(settings["delay"])
    except (ValueError, KeyError, TypeError, AttributeError) as exc:
        raise _damaged(recorded) from exc

    def make_problem(path: Path, message: str, *, offset: int = 0, key: bool = False) -> Problem:
        return Problem(recorded.name, 0, 0, message)

    checker = Checker(plan.model, make_problem, recorded.name)
    values = plan.name_values(plan.parameters)
    given = StepInput(checker, (), block.name, block.body, plan.numeric, values, delay, {})
    resolved = kinds[block.kind].resolve(given)
    if checker.errors:
        raise ResultsError(f"step '{recorded.name}': {checker.errors[0].message}; it was made by a changed model")
    settling = resolved.settling
    return MotionTask(plan.numeric, delay.make_method(), settling.method, settling.section, resolved.history)


def _damaged(recorded: Step) -> ResultsError:
    return ResultsError(f"the settings of step '{recorded.name}' cannot be read; the file is damaged")
