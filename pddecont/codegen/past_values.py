"""What a model reads of the past of a motion that is known as a function of time."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen.numeric_model import NumericModel

Array = NDArray[np.float64]
# Times (n,) and the order of a derivative to the motion's states then, (n, n_states).
ReadStates: TypeAlias = Callable[[Array, int], Array]
# Gauss points between two edges of a motion.
N_NODES = 10


def read_past(numeric: NumericModel, t: Array, x: Array, p: Array, read: ReadStates, edges: Array) -> Array:
    """Return what is read of the past at times ``t``, shape (n_reads, n_times).

    ``x`` (n_states, n_times) are the states then. Between ``edges``, in order, the motion is smooth: integrals over the
    past are taken piece by piece.
    """
    model = numeric.model
    xd = np.zeros((len(model.read_symbols), len(t)))
    constant = numeric.delays.value(p)
    for k in range(len(constant) + len(model.varying)):
        number = k - len(constant)
        lag = np.full(len(t), constant[k]) if number < 0 else numeric.varying_delay(number).value(t, x, xd, p)[0]
        for (delay, order), rows in model.read_groups.items():
            if delay == k:
                xd[rows] = read(t - lag, order)[:, [model.delayed[i].state for i in rows]].T
    for number in range(len(model.integrals)):
        limits = numeric.limits(number).value(t, x, xd, p)
        xd[len(model.delayed) + number] = _integrate(numeric, number, t, limits, p, read, edges)
    return xd


def _integrate(
    numeric: NumericModel, number: int, t: Array, limits: Array, p: Array, read: ReadStates, edges: Array
) -> Array:
    """Return an integral over the lags between ``limits`` (2, n_times) at times ``t``, shape (n_times,)."""
    nodes, weights = np.polynomial.legendre.leggauss(N_NODES)
    nodes, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    integrand, result = numeric.integrand(number), np.zeros(len(t))
    for i, (now, low, high) in enumerate(zip(t, *limits, strict=True)):
        inside = edges[(edges > now - high) & (edges < now - low)]
        cuts = np.concatenate([[now - high], inside, [now - low]])
        width = np.diff(cuts)
        at = (cuts[:-1, None] + nodes * width[:, None]).ravel()
        nothing = np.zeros((len(numeric.model.read_symbols), len(at)))
        values = integrand.value(now - at, read(at, 0).T, nothing, p)[0].reshape(len(width), -1)
        result[i] = float(np.sum(values @ weights * width))
    return result
