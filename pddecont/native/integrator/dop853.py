"""DOP853: the explicit Runge-Kutta method of order 8(5,3) with its continuous extension of order 7.

An extension of order 7 is what a method of order 8 needs: a delayed value, and the end of a step that an event cuts,
then have local errors of h^8 each, and the global order is 8 (Bellen, Zennaro, Numerical Methods for Delay Differential
Equations, 2003; measured in tests/simulate/integrator/test_dop853.py).

References: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), sections II.5 and II.6. The
coefficients are those that scipy.integrate.DOP853 has.
"""

from __future__ import annotations

from math import inf, isfinite, sqrt

import numpy as np
import scipy.integrate

from pddecont.native.arrays import Floats
from pddecont.native.calls import offset
from pddecont.native.integrator.core import Core
from pddecont.native.integrator.history import interpolate_state
from pddecont.native.integrator.places import MODE
from pddecont.native.integrator.rhs import evaluate_rhs
from pddecont.native.integrator.ring import evaluate_extension_slope

_METHOD = scipy.integrate.DOP853
# Stages of the step; row 12 of the stages is the slope at its end, rows 13 to 15 belong to the extension.
N_STAGES, N_ALL_STAGES = 12, 16
# Where in a step the defect of the extension is taken, as parts of the step; chosen not symmetric to its middle.
DEFECT_AT = np.array([0.25, 0.6])
# How large a defect may be, in tolerances: over a step it grows to an error about a tenth as large (measured in
# tests/simulate/integrator/test_dop853.py).
ALLOWED_DEFECT = 10.0
# The coefficients of section II.5 in scipy's names: stages A, B, C with those of the extension below, the two error
# estimates E3 and E5, and the extension's D.
A = np.ascontiguousarray(
    np.vstack(
        [
            np.pad(_METHOD.A, ((0, 0), (0, N_ALL_STAGES - _METHOD.A.shape[1]))),
            np.zeros((1, N_ALL_STAGES)),
            np.pad(_METHOD.A_EXTRA, ((0, 0), (0, N_ALL_STAGES - _METHOD.A_EXTRA.shape[1]))),
        ]
    )
)
B = np.array(_METHOD.B)
C = np.concatenate([_METHOD.C, [1.0], _METHOD.C_EXTRA])
E3, E5 = np.array(_METHOD.E3), np.array(_METHOD.E5)
D = np.array(_METHOD.D)


def try_explicit_step(c: Core, t: float, h: float) -> float:
    """Try a step; return its error relative to the tolerances (above 1: too large).

    Row 0 of ``c.stages`` holds the slopes at ``t``. The values at the end are left in row 1 of ``c.trial``, the slopes
    there in row 12 of ``c.stages``.
    """
    y, stages, mode, n = c.y, c.stages, c.count[MODE], c.dimension
    new = offset(c.trial, n)
    _evaluate_stages(c, t, h, 1, N_STAGES)
    for i in range(n):
        total = 0.0
        for j in range(N_STAGES):
            total += B[j] * stages[j * n + i]
        new[i] = y[i] + h * total
    evaluate_rhs(c, mode, t + h, new, offset(stages, N_STAGES * n))
    return _estimate_error(c, new, h)


def _evaluate_stages(c: Core, t: float, h: float, first: int, end: int) -> None:
    """Write the slopes at the stages ``first`` to ``end`` - 1 to their rows of ``c.stages``."""
    stages, n = c.stages, c.dimension
    for stage in range(first, end):
        for i in range(n):
            total = 0.0
            for j in range(stage):
                total += A[stage][j] * stages[j * n + i]
            c.trial[i] = c.y[i] + h * total
        evaluate_rhs(c, c.count[MODE], t + C[stage] * h, c.trial, offset(stages, stage * n))


def _estimate_error(c: Core, new: Floats, h: float) -> float:
    """Return the error estimate of section II.10, relative to the tolerances.

    It is made of those of orders 5 and 3, in the mean square over the components. Those of a tangent are compared with
    its largest one.
    """
    y, stages, n = c.y, c.stages, c.dimension
    largest = 1e-300
    for i in range(c.n_full, n):
        largest = max(largest, abs(y[i]))
    sum3, sum5 = 0.0, 0.0
    for i in range(n):
        allowed = c.atol + c.rtol * max(abs(y[i]), abs(new[i])) if i < c.n_full else c.rtol * largest
        e3, e5 = 0.0, 0.0
        for j in range(N_STAGES + 1):
            e3 += E3[j] * stages[j * n + i]
            e5 += E5[j] * stages[j * n + i]
        sum3 += (e3 / allowed) ** 2
        sum5 += (e5 / allowed) ** 2
    if not isfinite(sum3 + sum5):
        return inf
    # Where sum5 is zero so is the error; sum3 may be so small that a hundredth of it is zero too.
    if sum5 == 0.0:
        return 0.0
    return abs(h) * sum5 / sqrt((sum5 + 0.01 * sum3) * n)


def extend_explicit_step(c: Core, t: float, h: float) -> None:
    """Write the coefficients of the continuous extension of the step just tried to ``c.extension``."""
    y, stages, n = c.y, c.stages, c.dimension
    new, out = offset(c.trial, n), c.extension
    _evaluate_stages(c, t, h, N_STAGES + 1, N_ALL_STAGES)
    for i in range(n):
        step = new[i] - y[i]
        out[i] = step
        out[n + i] = h * stages[i] - step
        out[2 * n + i] = 2.0 * step - h * (stages[N_STAGES * n + i] + stages[i])
        for row in range(4):
            total = 0.0
            for j in range(N_ALL_STAGES):
                total += D[row][j] * stages[j * n + i]
            out[(3 + row) * n + i] = h * total


def estimate_extension_error(c: Core, t: float, h: float) -> float:
    """Return how far the continuous extension is from solving the equation, relative to the tolerances.

    Its defect inside the step measures it. What delays read, and where events are found, is the extension, and where
    the solution bends within a step that can be much worse than the end of the step (Enright, J. Comput. Appl. Math.
    125, 2000).
    """
    y, n, largest = c.trial, c.dimension, 0.0
    for k in range(2):
        s = DEFECT_AT[k]
        interpolate_state(c, s, y, n)
        evaluate_rhs(c, c.count[MODE], t + s * h, y, c.slope)
        total = 0.0
        for i in range(c.n_full):
            allowed = c.atol + c.rtol * max(abs(c.y[i]), abs(c.trial[n + i]))
            total += ((h * c.slope[i] - evaluate_extension_slope(offset(c.extension, i), n, s)) / allowed) ** 2
        largest = max(largest, total)
    return sqrt(largest / c.n_full) / ALLOWED_DEFECT if isfinite(largest) else inf
