"""Why an integration came to a halt."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import NumericModel, find_non_finite
from pddecont.model import find_start_digits, list_surfaces_met
from pddecont.native.integrator import ADVANCED, LAST_EVENT, MODE, ZENO_TIME, Status, T
from pddecont.simulate.failure import FailureReason, MotionFailure
from pddecont.simulate.integrator import IntegratorState
from pddecont.simulate.part_tables import PartTables
from pddecont.simulate.start_modes import name_numbers

Array = NDArray[np.float64]
# How far ahead a part of the vector field without a value is looked for, relative to the time: from the spacing of
# numbers, 2^-52, by powers of 2 up to 2^-30, which is longer than any step that an integration ends with.
SHORTEST_AHEAD, LONGEST_AHEAD = -52, -30
# A delay that is so small where a motion ends has fallen to zero there: where is known to the tolerances.
NEARLY_ZERO = 1e-6


def diagnose_halt(
    numeric: NumericModel, tables: PartTables, state: IntegratorState, status: Status, p: Array, delayed_values: Array
) -> MotionFailure:
    """Return why an integration at parameters ``p`` came to a halt; ``delayed_values`` are those read last."""
    t = float(state.clock[T])
    if status == Status.REPELLED:
        return _diagnose_repulsion(numeric, tables, state, p, delayed_values)
    mode = list(tables.modes)[state.count[MODE]]
    if status in (Status.ZENO, Status.SLIDING):
        event = list(tables.events)[state.count[LAST_EVENT]]
        reason = FailureReason.ACCUMULATION if status == Status.ZENO else FailureReason.SLIDING
        return MotionFailure(reason, float(state.clock[ZENO_TIME]), event, mode)
    if status == Status.PAST_UNKNOWN:
        return MotionFailure(FailureReason.PAST_UNKNOWN, t, None, mode)
    if status == Status.ADVANCED:
        lag = tables.plan.varying[state.lag_count[ADVANCED]]
        y, xd = state.y[: numeric.n_states, None], delayed_values[:, None]
        value = float(numeric.function([lag]).value(np.array([t]), y, xd, p)[0, 0])
        falls = f"{lag} falls below zero" if abs(value) < NEARLY_ZERO else f"{lag} is {value:.6g}, below zero"
        return MotionFailure(FailureReason.ADVANCED, t, None, mode, falls)
    part = _find_undefined_part(numeric, mode, state, p, delayed_values)
    if part:
        return MotionFailure(FailureReason.UNDEFINED, t, None, mode, part)
    return MotionFailure(
        FailureReason.NOT_FINITE if status == Status.NOT_FINITE else FailureReason.STEP_TOO_SMALL, t, None, mode
    )


def _diagnose_repulsion(
    numeric: NumericModel, tables: PartTables, state: IntegratorState, p: Array, delayed_values: Array
) -> MotionFailure:
    """Return which surface a motion is on that both fields point away from."""
    model, t = numeric.model, float(state.clock[T])
    assert model.derived is not None, "only equations have surfaces that repel"
    derived, states = model.derived, state.y[: numeric.n_states]
    numbers = name_numbers(numeric, p, t, states, delayed_values)
    mode = None if state.count[MODE] < 0 else list(tables.modes)[state.count[MODE]]
    digits = find_start_digits(derived, numbers) if mode is None else derived.find_digits(mode)
    # Where both fields only begin to point away their rates are zero.
    found = max(list_surfaces_met(derived.surfaces, digits, numbers), key=lambda s: min(-s.below, s.above))
    named = dict(zip(model.states, states.tolist(), strict=True))
    return MotionFailure(FailureReason.REPELLED, t, found.switch.name, mode, found.describe(named))


def _find_undefined_part(
    numeric: NumericModel, mode: str, state: IntegratorState, p: Array, delayed_values: Array
) -> str:
    """Return which part of the vector field has no finite value here or a short way ahead; empty if there is none.

    Ways ahead are tried along the present slope, from rounding up, with the delayed values read last.
    """
    model, n, t = numeric.model, numeric.n_states, float(state.clock[T])
    y, xd = state.y[:n, None], delayed_values[:, None]
    named = [(f"{name}' of mode '{mode}'", f) for name, f in zip(model.states, model.modes[mode], strict=True)]
    slope = numeric.mode(mode).value(np.array([t]), y, xd, p)
    ahead = np.concatenate([[0.0], max(1.0, abs(t)) * 2.0 ** np.arange(SHORTEST_AHEAD, LONGEST_AHEAD + 1)])
    with np.errstate(all="ignore"):
        states = y + np.where(np.isfinite(slope), slope, 0.0) * ahead
    finite = np.all(np.isfinite(states), axis=0)
    states, times = states[:, finite], t + ahead[finite]
    if not len(times):
        return ""
    return find_non_finite(numeric, named, times, states, np.repeat(xd, len(times), axis=1), p)
