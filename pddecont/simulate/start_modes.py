"""The modes in which motions start, read from their states: of models given by their equations."""

from __future__ import annotations

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.model import ABOVE, BELOW, TIME, DerivedModes, UndecidedSlidingError, find_start_mode

Array = NDArray[np.float64]
# Starts at which a function is smaller than this part of the largest one are looked at one by one: it may be zero.
NEAR = 1e-9


def read_start_modes(numeric: NumericModel, p: Array, t: float, states: Array, delayed: Array) -> list[str | None]:
    """Return the modes of motions that start at ``t``; None where both fields point away from a surface.

    ``states`` (n, n_states) and the values read of the past, ``delayed`` (n, n_reads), are those at the start.
    """
    model, derived = numeric.model, numeric.model.derived
    if derived is None:
        return [model.initial_mode] * len(states)
    doubtful, digits = _read_digits(numeric, derived, p, t, states, delayed)
    modes: list[str | None] = []
    for row, xd, slow, own in zip(states, delayed, doubtful, digits.T.tolist(), strict=True):
        modes.append(read_mode(numeric, p, t, row, xd) if slow else derived.find_mode(tuple(own)))
    return modes


def read_mode(
    numeric: NumericModel, p: Array, t: float, states: Array, delayed: Array, before: str | None = None
) -> str | None:
    """Return the mode of a motion at ``t``; None where both fields point away from a surface that it is on.

    ``states`` (n_states,) and the values read of the past, ``delayed`` (n_reads,), are those at
    ``t``; relays with memory are between their thresholds what they were in the mode ``before``.
    """
    derived = numeric.model.derived
    if derived is None:
        return before or numeric.model.initial_mode
    try:
        return find_start_mode(derived, name_numbers(numeric, p, t, states, delayed), before)
    except UndecidedSlidingError:
        return None


def name_numbers(numeric: NumericModel, p: Array, t: float, states: Array, delayed: Array) -> dict[sympy.Symbol, float]:
    """Return the numbers of the model's symbols: time, parameters, states and delayed values."""
    model = numeric.model
    symbols = (*model.parameter_symbols, *model.state_symbols, *model.read_symbols)
    return {TIME: t} | dict(zip(symbols, [*p.tolist(), *states.tolist(), *delayed.tolist()], strict=True))


def _read_digits(
    numeric: NumericModel, derived: DerivedModes, p: Array, t: float, states: Array, delayed: Array
) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
    """Return for which starts signs do not say all, and the digits of the others (n_switches, n)."""
    switches, n = derived.equations.switches, len(states)
    symbols = {s.digit for s in switches}
    if n == 1 or any(s.remembers or s.argument.free_symbols & symbols for s in switches):
        return np.ones(n, bool), np.zeros((len(switches), n), np.int64)
    function = numeric.function([s.argument for s in switches])
    u = function.value(np.full(n, t), np.ascontiguousarray(states.T), np.ascontiguousarray(delayed.T), p)
    near = np.abs(u) <= NEAR * np.max(np.abs(u), axis=1, initial=0.0, keepdims=True)
    digits = np.where(u > 0.0, ABOVE, BELOW).astype(np.int64)
    for k, switch in enumerate(switches):
        if switch.contact is not None:
            near[k], digits[k] = False, switch.free
    return np.any(near, axis=0), digits
