"""Branch point (BP): two branches of orbits cross; a multiplier passes +1 and the branch does not turn.

The directions of both branches span the null space of the Jacobian, which is two-dimensional there. Reference: Allgower, Georg,
Introduction to Numerical Continuation Methods (2003), chapter 8.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg
import scipy.sparse as sp
from numpy.typing import NDArray

from pddecont.orbit.curve import Curve
from pddecont.stability.multipliers import Multipliers

Array = NDArray[np.float64]
KIND = "BP"
DIFFERENCE = 1e-3


def passing(m: Multipliers) -> float:
    """Return the distance to +1 of the real multiplier nearest to it, with the sign of the parity of those beyond."""
    real = m.own[m.own.imag == 0.0].real
    if not len(real):
        return float("nan")
    return float((-1.0) ** np.sum(real > 1.0) * np.min(np.abs(real - 1.0)))


def other_branch(curve: Curve, x: Array, tangent: Array) -> Array:
    """Return the unit direction of the branch that crosses at ``x`` the one with ``tangent``.

    With t the tangent, v the rest of the null space and w the left null vector, the equations' second derivative B gives it as
    2 (w B t v) v - (w B v v) t, since w B t t = 0. Reference: Keller, Lectures on Numerical Methods in Bifurcation Problems (1987), ch. 5.
    """
    metric = curve.metric()
    size = metric.size
    matrix = curve.jacobian(x)
    dense = (matrix.toarray() if sp.issparse(matrix) else matrix) * size
    rows = 1.0 / np.max(np.abs(dense), axis=1)
    left, _, right = scipy.linalg.svd(rows[:, None] * dense)
    null = right[-2:] * size
    along = np.array([metric.dot(v, tangent) for v in null])
    rest = metric.unit(null.T @ np.array([-along[1], along[0]]))
    w = left[:, -1] * rows

    def second(direction: Array) -> float:
        ends = sum(curve.residual(x + sign * DIFFERENCE * direction) for sign in (-1.0, 1.0))
        return float(w @ (ends - 2.0 * curve.residual(x))) / DIFFERENCE**2

    t = metric.unit(tangent)
    of_t, of_rest = second(t), second(rest)
    mixed = 0.5 * (second(t + rest) - of_t - of_rest)
    return metric.unit(2.0 * mixed * rest - of_rest * t)
