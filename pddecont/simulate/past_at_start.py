"""What a model reads of the past where motions start: of the history before the start, or of constant states."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.model import TIME
from pddecont.simulate.past_plan import PRESENT, PastPlan, Turn

Array = NDArray[np.float64]
# Integrals over the history decide in which mode a motion starts and nothing else: parts and Gauss points in each.
PARTS, POINTS = 8, 20


def read_past_at_start(
    numeric: NumericModel,
    plan: PastPlan,
    p: Array,
    t: float,
    states: Array,
    tau: Array,
    history: Sequence[sympy.Expr] | None,
) -> Array:
    """Return what is read at ``t`` by motions that start there with ``states`` (n, n_states), shape (n, n_reads).

    ``tau`` are the constant lags of the plan; ``history`` are expressions in t and parameters, or None where the past
    of each motion is its own states.
    """
    model, n = numeric.model, len(states)
    x, times = np.ascontiguousarray(states.T), np.full(n, t)
    reads, lags = np.zeros((len(model.read_symbols), n)), np.zeros((len(plan.varying), n))

    def find_lag(slot: int) -> Array:
        if slot == PRESENT:
            return np.zeros(n)
        return np.full(n, tau[slot]) if slot < len(plan.constant) else lags[slot - len(plan.constant)]

    for kind, i in plan.turns:
        if kind == Turn.LAG:
            lags[i] = numeric.function([plan.varying[i]]).value(times, x, reads, p)[0]
        elif kind == Turn.VALUE:
            there, read = t - find_lag(plan.slots[i]), model.delayed[i]
            past = _evaluate_past(numeric, p, there, x, history, read.derivative)[read.state]
            # At the start itself a motion is where it starts, whatever the history says.
            reads[i] = np.where((there == t) & (read.derivative == 0), x[read.state], past)
        else:
            low, high = find_lag(plan.low[i]), find_lag(plan.high[i])
            reads[len(model.delayed) + i] = _integrate(numeric, p, t, low, high, i, x, history)
    return np.ascontiguousarray(reads.T)


def _evaluate_past(
    numeric: NumericModel, p: Array, times: Array, x: Array, history: Sequence[sympy.Expr] | None, order: int
) -> Array:
    """Return the states of the history, or their derivatives, shape (n_states, n)."""
    if history is None:
        return x if order == 0 else np.zeros_like(x)
    function = numeric.function([e.diff(TIME, order) if order else e for e in history])
    n = len(times)
    return function.value(times, np.zeros_like(x), np.zeros((len(numeric.model.read_symbols), n)), p)


def _integrate(
    numeric: NumericModel,
    p: Array,
    t: float,
    low: Array,
    high: Array,
    number: int,
    x: Array,
    history: Sequence[sympy.Expr] | None,
) -> Array:
    """Return an integral over the history by Gauss's rule in equal parts, shape (n,)."""
    nodes, weights = np.polynomial.legendre.leggauss(POINTS)
    function, width = numeric.function([numeric.model.integrals[number].integrand]), (high - low) / PARTS
    total = np.zeros(len(low))
    for part in range(PARTS):
        for node, weight in zip(nodes, weights, strict=True):
            lag = low + width * (part + 0.5 * (1.0 + node))
            past = _evaluate_past(numeric, p, t - lag, x, history, 0)
            nothing = np.zeros((len(numeric.model.read_symbols), len(low)))
            total += 0.5 * weight * width * function.value(lag, past, nothing, p)[0]
    return total
