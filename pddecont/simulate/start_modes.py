"""The modes in which motions start, read from their states: of models given by their equations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.model import ABOVE, BELOW, TIME, DerivedModes, find_start_mode

Array = NDArray[np.float64]
# Starts at which a function is smaller than this part of the largest one are looked at one by one: it may be zero.
NEAR = 1e-9


def read_start_modes(numeric: NumericModel, p: Array, t: float, states: Array, delayed: Array) -> list[str]:
    """Return the modes of motions that start at ``t``.

    ``states`` (n, n_states) and ``delayed`` values (n, n_delayed) are those at the start.

    Raises
    ------
    PddecontError
        If both fields point away from a surface on which a motion starts.
    """
    model, derived = numeric.model, numeric.model.derived
    if derived is None:
        return [model.initial_mode] * len(states)
    known = {TIME: t} | dict(zip(model.parameter_symbols, p.tolist(), strict=True))
    doubtful, digits = _read_digits(numeric, derived, p, t, states, delayed)
    modes = []
    for row, xd, slow, own in zip(states.tolist(), delayed.tolist(), doubtful, digits.T.tolist(), strict=True):
        if slow:
            numbers = known | dict(zip((*model.state_symbols, *model.delayed_symbols), [*row, *xd], strict=True))
            modes.append(find_start_mode(derived, numbers))
        else:
            modes.append(derived.find_mode(tuple(own)))
    return modes


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
