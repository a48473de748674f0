"""Radau IIA of order 5: implicit, for stiff contact, with its collocation polynomial of degree 3 as extension.

Delayed values lie in the past (no step is longer than the shortest delay), so that Newton's method needs the
derivatives in the states alone.

References: Hairer, Wanner, Solving Ordinary Differential Equations II (1996), sections IV.5 and IV.8; Guglielmi,
Hairer, Computing 67 (2001), for delay equations.
"""

from __future__ import annotations

from math import inf, isfinite, sqrt

import numpy as np

from pddecont.native.arrays import Floats
from pddecont.native.calls import call, offset
from pddecont.native.integrator.calls import factorise, solve_factorised
from pddecont.native.integrator.core import Core
from pddecont.native.integrator.history import read_delayed
from pddecont.native.integrator.past_reads import find_lag, read_for_derivatives
from pddecont.native.integrator.places import MODE, N_COEFFICIENTS
from pddecont.native.integrator.rhs import evaluate_rhs

_R = sqrt(6.0)
# The method's coefficients, table IV.5.6.
C = np.array([(4.0 - _R) / 10.0, (4.0 + _R) / 10.0, 1.0])
A = np.array(
    [
        [(88.0 - 7.0 * _R) / 360.0, (296.0 - 169.0 * _R) / 1800.0, (-2.0 + 3.0 * _R) / 225.0],
        [(296.0 + 169.0 * _R) / 1800.0, (88.0 + 7.0 * _R) / 360.0, (-2.0 - 3.0 * _R) / 225.0],
        [(16.0 - _R) / 36.0, (16.0 + _R) / 36.0, 1.0 / 9.0],
    ]
)
# The error is that of an embedded formula whose matrix is the real factor of the method's own (section IV.8).
ERROR = np.array([-13.0 - 7.0 * _R, -13.0 + 7.0 * _R, -1.0]) / 3.0
REAL = 3.0 + 3.0 ** (2.0 / 3.0) - 3.0 ** (1.0 / 3.0)
# From the stages' increments to the powers s, s^2, s^3 of the collocation polynomial.
POWERS = np.ascontiguousarray(np.linalg.inv(C[:, None] ** np.arange(1, 4)))
# Newton's iterations in a step: section IV.8 recommends to allow many, 7 or 10.
MAX_ITERATIONS = 10
# The error that the iteration may leave, in tolerances: small beside the error of the step itself.
ITERATION_TOL = 1e-3


def try_stiff_step(c: Core, t: float, h: float) -> float:
    """Try a step; return its error relative to the tolerances (above 1: too large).

    The increments of the stages are left in rows 1 to 3 of ``c.stages``, the values at the end in the second row of
    ``c.trial``.
    """
    y, mode, stages, n = c.y, c.count[MODE], c.stages, c.n_full
    increments, change = c.increments, c.change
    _evaluate_jacobian(c, mode, t)
    if not _factorise_stages(c, h):
        return inf
    for i in range(3 * n):
        increments[i] = 0.0
    last, converged = inf, False
    for iteration in range(MAX_ITERATIONS):
        for i in range(3):
            for k in range(n):
                c.trial[k] = y[k] + increments[i * n + k]
            evaluate_rhs(c, mode, t + C[i] * h, c.trial, offset(stages, (4 + i) * n))
        for i in range(3):
            for k in range(n):
                change[i * n + k] = (
                    h * (A[i][0] * stages[4 * n + k] + A[i][1] * stages[5 * n + k] + A[i][2] * stages[6 * n + k])
                    - increments[i * n + k]
                )
        solve_factorised(c.matrix, c.pivots, 3 * n, change)
        size = 0.0
        for i in range(3 * n):
            increments[i] += change[i]
            size += (change[i] / (c.atol + c.rtol * abs(y[i % n]))) ** 2
        size = sqrt(size / (3 * n))
        if not isfinite(size):
            return inf
        rate = size / last if iteration > 0 else 0.0
        if size <= ITERATION_TOL or (iteration > 0 and rate < 1.0 and size * rate / (1.0 - rate) <= ITERATION_TOL):
            converged = True
            break
        if iteration > 1 and rate >= 1.0:
            # Where the increments are as small as their rounding they cannot shrink further: the step is good.
            converged = size <= 1.0
            break
        last = size
    if not converged:
        return inf
    for i in range(3 * n):
        stages[n + i] = increments[i]
    for k in range(n):
        c.trial[n + k] = y[k] + increments[2 * n + k]
    return _estimate_error(c, t, h)


def _factorise_stages(c: Core, h: float) -> bool:
    """Write the factors of 1 - h A (x) J to ``c.matrix``; return whether it has any."""
    n, matrix, jacobian = c.n_full, c.matrix, c.full_jacobian
    for i in range(n * n):
        if not isfinite(jacobian[i]):
            return False
    for i in range(3):
        for j in range(3):
            for k in range(n):
                for m in range(n):
                    place = (i * n + k) * 3 * n + j * n + m
                    matrix[place] = -h * A[i][j] * jacobian[k * n + m]
                    if i == j and k == m:
                        matrix[place] += 1.0
    return factorise(matrix, c.pivots, 3 * n)


def _estimate_error(c: Core, t: float, h: float) -> float:
    """Return the error of the step just tried relative to the tolerances, from the embedded formula."""
    n, y, stages, matrix = c.n_full, c.y, c.stages, c.matrix
    explicit, error = c.increments, c.change
    for i in range(n * n):
        matrix[i] = -c.full_jacobian[i]
    for k in range(n):
        matrix[k * n + k] += REAL / h
    if not factorise(matrix, c.pivots, n):
        return inf
    for k in range(n):
        explicit[k] = (ERROR[0] * stages[n + k] + ERROR[1] * stages[2 * n + k] + ERROR[2] * stages[3 * n + k]) / h
        error[k] = stages[k] + explicit[k]
    solve_factorised(matrix, c.pivots, n, error)
    size = _measure_size(c, error)
    if 1.0 < size < inf:
        # At a boundary layer the first estimate is far too large: Hairer and Wanner filter it once more, (IV.8.20).
        for k in range(n):
            c.trial[k] = y[k] + error[k]
        evaluate_rhs(c, c.count[MODE], t, c.trial, offset(stages, 7 * n))
        for k in range(n):
            error[k] = stages[7 * n + k] + explicit[k]
        solve_factorised(matrix, c.pivots, n, error)
        size = _measure_size(c, error)
    return size


def _measure_size(c: Core, error: Floats) -> float:
    """Return the mean square size of an error relative to the tolerances, infinite where it is not finite."""
    total, n = 0.0, c.n_full
    for i in range(n):
        total += (error[i] / (c.atol + c.rtol * max(abs(c.y[i]), abs(c.trial[n + i])))) ** 2
    return sqrt(total / n) if isfinite(total) else inf


def _evaluate_jacobian(c: Core, mode: int, t: float) -> None:
    """Write the derivatives of all slopes in all variables to ``c.full_jacobian``, shape (n_full, n_full).

    [df/dx (with delayed values that are not delayed)   df/dxd of the last stages]
    [chain in the states and stages that it reads       chain in itself          ]
    """
    n, m, full, y, result = c.n, c.n_pairs, c.n_full, c.y, c.full_jacobian
    for i in range(full * full):
        result[i] = 0.0
    read_delayed(c, t, y, c.xd, 0)
    if c.is_general == 1:
        read_for_derivatives(c, t, y, c.xd)
    for i in range(n * (n + m)):
        c.jacobian[i] = 0.0
    call(c.field_jacobian[mode], c.field_case[mode], t, y, c.xd, c.p, c.jacobian)
    for i in range(n):
        for j in range(n):
            result[i * full + j] = c.jacobian[i * n + j]
        for j in range(m):
            slope = c.jacobian[n * n + i * m + j]
            if c.is_general == 1:
                if c.pair_delay[j] >= 0 and c.pair_derivative[j] == 0 and find_lag(c, c.pair_delay[j]) == 0.0:
                    result[i * full + c.pair_state[j]] += slope
            elif c.tau[c.pair_delay[j]] == 0.0:
                result[i * full + c.pair_state[j]] += slope
            elif c.chain_n > 0:
                result[i * full + n + (j * c.chain_n + c.chain_n - 1) * c.chain_order] += slope
    for i in range(m if c.chain_n > 0 else 0):
        _add_chain(c, i)


def _add_chain(c: Core, i: int) -> None:
    """Write the rows of the chain of delayed value ``i`` to ``c.full_jacobian``."""
    full, order, result = c.n_full, c.chain_order, c.full_jacobian
    delta = c.tau[c.pair_delay[i]] / c.chain_n
    if delta == 0.0:
        return
    for stage in range(c.chain_n):
        base = c.n + (i * c.chain_n + stage) * order
        top = (base + order - 1) * full
        factorial = 1.0
        for k in range(1, order + 1):
            factorial *= k
        for k in range(order - 1):
            result[(base + k) * full + base + k + 1] = 1.0 / delta
        result[top + (base - order if stage > 0 else c.pair_state[i])] += factorial / delta
        below = 1.0
        for k in range(order):
            if k > 0:
                below *= k
            result[top + base + k] -= factorial / below / delta


def extend_stiff_step(c: Core) -> None:
    """Write the collocation polynomial to ``c.extension`` in the form that all steps have: s, s(1 - s), s^2 (1 - s)."""
    out, stages = c.extension, c.stages
    n = c.n_full
    for k in range(n):
        q1, q2, q3 = 0.0, 0.0, 0.0
        for i in range(3):
            q1 += POWERS[0][i] * stages[(1 + i) * n + k]
            q2 += POWERS[1][i] * stages[(1 + i) * n + k]
            q3 += POWERS[2][i] * stages[(1 + i) * n + k]
        out[k] = q1 + q2 + q3
        out[n + k] = q1 - out[k]
        out[2 * n + k] = -q3
        for i in range(3, N_COEFFICIENTS):
            out[i * n + k] = 0.0
