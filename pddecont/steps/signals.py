"""Expressions along a trajectory, delayed values included."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.model.expression import parse
from pddecont.simulate.trajectory import Trajectory
from pddecont.steps.plan import Plan

Array = NDArray[np.float64]


def signal_values(plan: Plan, signals: Mapping[str, str | float], trajectory: Trajectory, times: Array, states: Array,
                  stages: Sequence[tuple[float, Array]], past: Sequence[sympy.Expr]) -> Array:  # fmt: skip
    """Return the signals at ``times`` along a trajectory, shape (n_times, n_signals).

    ``states`` (n_times, n_states) are those at the times; ``stages`` are pairs (time, parameters that hold from it on). Delayed values
    before the trajectory are those of ``past``, expressions in t.
    """
    numeric, model = plan.numeric, plan.model
    scope = model.scope("a signal", delayed=model.delayed_value)
    function = numeric.function([parse(text, scope) for text in signals.values()])
    history = numeric.function(past)
    out = np.empty((len(times), len(signals)))
    stage = np.searchsorted([t for t, _ in stages], times, side="right") - 1
    for k, (_, p) in enumerate(stages):
        here = stage == k
        t, tau = times[here], numeric.delays.value(p)
        xd = np.empty((len(model.delayed), len(t)))
        for row, (state, delay) in enumerate(model.delayed):
            back = t - tau[delay]
            before = back < 0.0
            xd[row] = trajectory(back)[:, state]
            if np.any(before):
                n = int(np.sum(before))
                empty = np.zeros((len(model.states), n)), np.zeros((len(model.delayed), n))
                xd[row, before] = history.value(back[before], *empty, p)[state]
        out[here] = function.value(t, states[here].T, xd, p).T
    return out
