"""Expressions along a trajectory, delayed values included."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.model import reads_generally
from pddecont.simulate import Trajectory, read_along

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
    if not signals:
        return np.empty((len(times), 0))
    model = numeric.model
    function, history = numeric.function(signals), numeric.function(past)
    out = np.empty((len(times), len(signals)))
    stage = np.searchsorted([t for t, _ in stages], times, side="right") - 1
    for k, (_, p) in enumerate(stages):
        here = stage == k
        if reads_generally(model):
            reads = read_along(numeric, p, times[here], states[here].T, trajectory, past)
            out[here] = function.value(times[here], states[here].T, reads, p).T
            continue
        t, tau = times[here], numeric.delays.value(p)
        xd = np.empty((len(model.delayed), len(t)))
        for row, read in enumerate(model.delayed):
            back = t - tau[read.delay]
            before = back < 0.0
            xd[row] = trajectory(back)[:, read.state]
            if np.any(before):
                n = int(np.sum(before))
                empty = np.zeros((len(model.states), n)), np.zeros((len(model.delayed), n))
                xd[row, before] = history.value(back[before], *empty, p)[read.state]
        out[here] = function.value(t, states[here].T, xd, p).T
    return out
