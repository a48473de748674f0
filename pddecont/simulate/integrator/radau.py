"""Radau IIA of order 5: implicit, for stiff contact, with its collocation polynomial of degree 3 as extension.

Delayed values lie in the past (no step is longer than the shortest delay), so that Newton's method needs the
derivatives in the states alone.

References: Hairer, Wanner, Solving Ordinary Differential Equations II (1996), sections IV.5 and IV.8; Guglielmi,
Hairer, Computing 67 (2001), for delay equations.
"""

from __future__ import annotations

import math

import numpy as np

from pddecont.simulate.integrator.buffers import N_COEFFICIENTS
from pddecont.simulate.integrator.calls import call, internal, offset
from pddecont.simulate.integrator.history import read_delayed
from pddecont.simulate.integrator.past_reads import find_lag, read_for_derivatives
from pddecont.simulate.integrator.rhs import evaluate_rhs
from pddecont.simulate.integrator.state import MODE

_R = math.sqrt(6.0)
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


@internal
def try_stiff_step(c, t, h):
    """Try a step; return its error relative to the tolerances (above 1: too large).

    The increments of the stages are left in rows 1 to 3 of ``c.stages``, the values at the end in the second row of
    ``c.trial``.
    """
    y, mode, stages, n = c.y, c.count[MODE], c.stages, c.n_full
    jacobian = _evaluate_jacobian(c, mode, t)
    if not np.all(np.isfinite(jacobian)):
        return math.inf
    matrix = np.eye(3 * n)
    for i in range(3):
        for j in range(3):
            matrix[i * n : (i + 1) * n, j * n : (j + 1) * n] -= h * A[i, j] * jacobian
    inverse = np.linalg.inv(matrix)
    allowed = np.empty(n)
    for i in range(n):
        allowed[i] = c.atol + c.rtol * abs(y[i])
    increments, residual = np.zeros(3 * n), np.empty(3 * n)
    last, converged = math.inf, False
    for iteration in range(MAX_ITERATIONS):
        for i in range(3):
            for k in range(n):
                c.trial[k] = y[k] + increments[i * n + k]
            evaluate_rhs(c, mode, t + C[i] * h, c.trial, offset(stages, (4 + i) * n))
        for i in range(3):
            for k in range(n):
                residual[i * n + k] = (
                    h * (A[i, 0] * stages[4 * n + k] + A[i, 1] * stages[5 * n + k] + A[i, 2] * stages[6 * n + k])
                    - increments[i * n + k]
                )
        change = inverse @ residual
        increments += change
        size = 0.0
        for i in range(3 * n):
            size += (change[i] / allowed[i % n]) ** 2
        size = math.sqrt(size / (3 * n))
        if not math.isfinite(size):
            return math.inf
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
        return math.inf
    for i in range(3 * n):
        stages[n + i] = increments[i]
    for k in range(n):
        c.trial[n + k] = y[k] + increments[2 * n + k]
    return _estimate_error(c, t, h, jacobian)


@internal
def _estimate_error(c, t, h, jacobian):
    """Return the error of the step just tried relative to the tolerances, from the embedded formula."""
    n, y, stages = c.n_full, c.y, c.stages
    matrix = np.eye(n) * (REAL / h) - jacobian
    explicit, right = np.empty(n), np.empty(n)
    for k in range(n):
        explicit[k] = (ERROR[0] * stages[n + k] + ERROR[1] * stages[2 * n + k] + ERROR[2] * stages[3 * n + k]) / h
        right[k] = stages[k] + explicit[k]
    error, size = _solve(c, matrix, right)
    if 1.0 < size < math.inf:
        # At a boundary layer the first estimate is far too large: Hairer and Wanner filter it once more, (IV.8.20).
        for k in range(n):
            c.trial[k] = y[k] + error[k]
        evaluate_rhs(c, c.count[MODE], t, c.trial, offset(stages, 7 * n))
        for k in range(n):
            right[k] = stages[7 * n + k] + explicit[k]
        _, size = _solve(c, matrix, right)
    return size


@internal
def _solve(c, matrix, right):
    """Return the solution of a linear system and its size relative to the tolerances, infinite where there is none."""
    if not np.all(np.isfinite(right)):
        return right, math.inf
    error = np.linalg.solve(matrix, right)
    return error, _measure_size(c, error)


@internal
def _measure_size(c, error):
    """Return the mean square size of an error relative to the tolerances."""
    total, n = 0.0, c.n_full
    for i in range(n):
        total += (error[i] / (c.atol + c.rtol * max(abs(c.y[i]), abs(c.trial[n + i])))) ** 2
    return math.sqrt(total / n) if math.isfinite(total) else math.inf


@internal
def _evaluate_jacobian(c, mode, t):
    """Return the derivatives of all slopes in all variables, shape (n_full, n_full).

    [df/dx (with delayed values that are not delayed)   df/dxd of the last stages]
    [chain in the states and stages that it reads       chain in itself          ]
    """
    n, m, full, y = c.n, c.n_pairs, c.n_full, c.y
    result = np.zeros((full, full))
    read_delayed(c, t, y, c.xd, 0)
    if c.is_general == 1:
        read_for_derivatives(c, t, y, c.xd)
    for i in range(n * (n + m)):
        c.jacobian[i] = 0.0
    call(c.field_jacobian[mode], c.field_case[mode], t, y, c.xd, c.p, c.jacobian)
    for i in range(n):
        for j in range(n):
            result[i, j] = c.jacobian[i * n + j]
        for j in range(m):
            slope = c.jacobian[n * n + i * m + j]
            if c.is_general == 1:
                if c.pair_delay[j] >= 0 and c.pair_derivative[j] == 0 and find_lag(c, c.pair_delay[j]) == 0.0:
                    result[i, c.pair_state[j]] += slope
            elif c.tau[c.pair_delay[j]] == 0.0:
                result[i, c.pair_state[j]] += slope
            elif c.chain_n > 0:
                result[i, n + (j * c.chain_n + c.chain_n - 1) * c.chain_order] += slope
    order = c.chain_order
    for i in range(m if c.chain_n > 0 else 0):
        delta = c.tau[c.pair_delay[i]] / c.chain_n
        if delta == 0.0:
            continue
        for stage in range(c.chain_n):
            base = n + (i * c.chain_n + stage) * order
            top = base + order - 1
            factorial = 1.0
            for k in range(1, order + 1):
                factorial *= k
            for k in range(order - 1):
                result[base + k, base + k + 1] = 1.0 / delta
            result[top, base - order if stage > 0 else c.pair_state[i]] += factorial / delta
            below = 1.0
            for k in range(order):
                if k > 0:
                    below *= k
                result[top, base + k] -= factorial / below / delta
    return result


@internal
def extend_stiff_step(c):
    """Write the collocation polynomial to ``c.extension`` in the form that all steps have: s, s(1 - s), s^2 (1 - s)."""
    out, stages = c.extension, c.stages
    n = c.n_full
    for k in range(n):
        q1, q2, q3 = 0.0, 0.0, 0.0
        for i in range(3):
            q1 += POWERS[0, i] * stages[(1 + i) * n + k]
            q2 += POWERS[1, i] * stages[(1 + i) * n + k]
            q3 += POWERS[2, i] * stages[(1 + i) * n + k]
        out[k] = q1 + q2 + q3
        out[n + k] = q1 - out[k]
        out[2 * n + k] = -q3
        for i in range(3, N_COEFFICIENTS):
            out[i * n + k] = 0.0
