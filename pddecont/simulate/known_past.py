"""What a model reads of a past that is known as a function of time: of a history, or of a trajectory."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.model import TIME
from pddecont.simulate.past_plan import PRESENT, PastPlan, Turn, make_past_plan
from pddecont.simulate.trajectory import Trajectory

Array = NDArray[np.float64]
# Gauss points in each smooth part of an integral, and parts of a history, which is smooth all over.
POINTS, HISTORY_PARTS = 16, 8
# The states (n_states, n), or their derivatives of an order, at times (n,).
KnownPast: TypeAlias = Callable[[Array, int], Array]


def make_history_past(numeric: NumericModel, history: Sequence[sympy.Expr], p: Array) -> KnownPast:
    """Return the past that is a history, expressions in t and parameters."""

    def read(times: Array, order: int) -> Array:
        function = numeric.function([e.diff(TIME, order) if order else e for e in history])
        n = len(times)
        nothing = np.zeros((numeric.n_states, n)), np.zeros((len(numeric.model.read_symbols), n))
        return function.value(times, *nothing, p)

    return read


def make_constant_past(states: Array) -> KnownPast:
    """Return the past that is constant: ``states`` (n_states,)."""
    return lambda times, order: np.outer(states if order == 0 else np.zeros_like(states), np.ones(len(times)))


def make_trajectory_past(trajectory: Trajectory, history: KnownPast) -> KnownPast:
    """Return the past that is a trajectory from t = 0 on, and a history before."""

    def read(times: Array, order: int) -> Array:
        found = trajectory.differentiate(times, order).T
        before = times < 0.0
        if np.any(before):
            found[:, before] = history(times[before], order)
        return found

    return read


def read_values(
    numeric: NumericModel, plan: PastPlan, p: Array, times: Array, states: Array, past: KnownPast, edges: Array
) -> Array:
    """Return what is read at ``times`` (n,) by ``states`` (n_states, n), shape (n_reads, n).

    ``past`` is smooth between ``edges``, times in order.
    """
    model, n = numeric.model, len(times)
    constant = numeric.parameter_function(plan.constant).value(p) if plan.constant else np.zeros(0)
    reads, lags = np.zeros((len(model.read_symbols), n)), np.zeros((len(plan.varying), n))

    def find_lag(slot: int) -> Array:
        if slot == PRESENT:
            return np.zeros(n)
        return np.full(n, constant[slot]) if slot < len(constant) else lags[slot - len(constant)]

    for kind, i in plan.turns:
        if kind == Turn.LAG:
            lags[i] = numeric.function([plan.varying[i]]).value(times, states, reads, p)[0]
        elif kind == Turn.VALUE:
            lag, read = find_lag(plan.slots[i]), model.delayed[i]
            there = past(times - lag, read.derivative)[read.state]
            # At no lag at all a value is that of the states, whatever the past says.
            reads[i] = np.where((lag == 0.0) & (read.derivative == 0), states[read.state], there)
        else:
            low, high = find_lag(plan.low[i]), find_lag(plan.high[i])
            reads[len(model.delayed) + i] = [
                _integrate(numeric, i, p, t, a, b, past, edges) for t, a, b in zip(times, low, high, strict=True)
            ]
    return reads


def _integrate(
    numeric: NumericModel, number: int, p: Array, t: float, low: float, high: float, past: KnownPast, edges: Array
) -> float:
    """Return an integral over lags from ``low`` to ``high`` at one time, by Gauss's rule in each smooth part."""
    if not np.isfinite(low + high) or low == high:
        return 0.0 if low == high else np.nan
    nodes, weights = np.polynomial.legendre.leggauss(POINTS)
    begin, end = sorted((t - high, t - low))
    before = np.linspace(begin, min(end, edges[0]), HISTORY_PARTS + 1) if begin < edges[0] else np.array([begin])
    cuts = np.unique([*before, *edges[(edges > begin) & (edges < end)], end])
    width = np.diff(cuts)[:, None]
    there = (cuts[:-1, None] + width * 0.5 * (1.0 + nodes)).ravel()
    function = numeric.function([numeric.model.integrals[number].integrand])
    nothing = np.zeros((len(numeric.model.read_symbols), len(there)))
    values = function.value(t - there, past(there, 0), nothing, p)[0]
    total = float(np.sum((0.5 * width * weights).ravel() * values))
    return total if high >= low else -total


def read_along(
    numeric: NumericModel, p: Array, times: Array, states: Array, trajectory: Trajectory, history: Sequence[sympy.Expr]
) -> Array:
    """Return what is read at ``times`` (n,) with ``states`` (n_states, n) along a trajectory, shape (n_reads, n).

    Before t = 0 it has a ``history``.
    """
    past = make_trajectory_past(trajectory, make_history_past(numeric, history, p))
    edges = np.array([0.0, *trajectory.time[trajectory.time > 0.0]])
    return read_values(numeric, make_past_plan(numeric.model), p, times, states, past, edges)
