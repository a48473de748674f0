"""Expressions along a trajectory, delayed values included."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.codegen import NumericModel, read_past
from pddecont.model import TIME
from pddecont.simulate import Trajectory

Array = NDArray[np.float64]


def evaluate_signals(
    numeric: NumericModel,
    signals: Sequence[sympy.Expr],
    trajectory: Trajectory,
    times: Array,
    states: Array,
    stages: Sequence[tuple[float, Array]],
    past: Sequence[sympy.Expr],
) -> Array:
    """Return the signals at ``times`` along a trajectory, shape (n_times, n_signals).

    ``states`` (n_times, n_states) are those at the times; ``stages`` are pairs (time, parameters that hold from it on).
    Delayed values before the trajectory are those of ``past``, expressions in t.
    """
    model = numeric.model
    function = numeric.function(signals)
    histories = [numeric.function([e.diff(TIME, k) if k else e for e in past]) for k in range(3)]
    out = np.empty((len(times), len(signals)))
    stage = np.searchsorted([t for t, _ in stages], times, side="right") - 1
    for k, (_, p) in enumerate(stages):
        here = stage == k

        def read(t: Array, order: int, p: Array = p) -> Array:
            found, before = trajectory(t) if order == 0 else trajectory.rate(t, order), t < 0.0
            if np.any(before):
                n = int(np.sum(before))
                empty = np.zeros((len(model.states), n)), np.zeros((len(model.read_symbols), n))
                found[before] = histories[order].value(t[before], *empty, p).T
            return found

        t = times[here]
        xd = read_past(numeric, t, states[here].T, p, read, np.append(trajectory.time, trajectory.t_end))
        out[here] = function.value(t, states[here].T, xd, p).T
    return out
