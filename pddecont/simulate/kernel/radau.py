"""Radau IIA of order 5: implicit, for stiff contact. Its own collocation polynomial of degree 3 is the continuous extension.

References: Hairer, Wanner, Solving Ordinary Differential Equations II (1996), sections IV.5 and IV.8; Guglielmi, Hairer, Computing 67
(2001), for delay equations. Delayed values lie in the past (no step is longer than the shortest delay), so that Newton's method
needs the derivatives in the states alone.
"""

from __future__ import annotations

import math

import numpy as np

from pddecont.simulate.kernel.calls import at, call, inner
from pddecont.simulate.kernel.past import read
from pddecont.simulate.kernel.slopes import slopes
from pddecont.simulate.kernel.tables import MODE, N_COEFFICIENTS

_R = math.sqrt(6.0)
C = np.array([(4.0 - _R) / 10.0, (4.0 + _R) / 10.0, 1.0])
A = np.array([[(88.0 - 7.0 * _R) / 360.0, (296.0 - 169.0 * _R) / 1800.0, (-2.0 + 3.0 * _R) / 225.0],
              [(296.0 + 169.0 * _R) / 1800.0, (88.0 + 7.0 * _R) / 360.0, (-2.0 - 3.0 * _R) / 225.0],
              [(16.0 - _R) / 36.0, (16.0 + _R) / 36.0, 1.0 / 9.0]])  # fmt: skip
# The error is that of an embedded formula whose matrix is the real factor of the method's own.
ERROR = np.array([-13.0 - 7.0 * _R, -13.0 + 7.0 * _R, -1.0]) / 3.0
REAL = 3.0 + 3.0 ** (2.0 / 3.0) - 3.0 ** (1.0 / 3.0)
# From the stages' increments to the powers s, s^2, s^3 of the collocation polynomial.
POWERS = np.ascontiguousarray(np.linalg.inv(C[:, None] ** np.arange(1, 4)))
MAX_ITERATIONS = 10
NEWTON = 1e-3


@inner
def stiff_step(c, t, h):
    """Try a step; return its error relative to the tolerances. The stages' increments are left in rows 1 to 3 of ``c.stages``."""
    y, mode, stages, n = c.y, c.count[MODE], c.stages, c.n_full
    jacobian = _jacobian(c, mode, t)
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
            slopes(c, mode, t + C[i] * h, c.trial, at(stages, (4 + i) * n))
        for i in range(3):
            for k in range(n):
                residual[i * n + k] = (h * (A[i, 0] * stages[4 * n + k] + A[i, 1] * stages[5 * n + k] + A[i, 2] * stages[6 * n + k])
                                       - increments[i * n + k])  # fmt: skip
        change = inverse @ residual
        increments += change
        size = 0.0
        for i in range(3 * n):
            size += (change[i] / allowed[i % n]) ** 2
        size = math.sqrt(size / (3 * n))
        if not math.isfinite(size):
            return math.inf
        rate = size / last if iteration > 0 else 0.0
        if size <= NEWTON or (iteration > 0 and rate < 1.0 and size * rate / (1.0 - rate) <= NEWTON):
            converged = True
            break
        if iteration > 1 and rate >= 1.0:
            # Rounding is all that is left where the increments are as small as it: the step then stands.
            converged = size <= 1.0
            break
        last = size
    if not converged:
        return math.inf
    for i in range(3 * n):
        stages[n + i] = increments[i]
    for k in range(n):
        c.trial[n + k] = y[k] + increments[2 * n + k]
    return _error(c, t, h, jacobian)


@inner
def _error(c, t, h, jacobian):
    n, y, stages = c.n_full, c.y, c.stages
    matrix = np.eye(n) * (REAL / h) - jacobian
    explicit, right = np.empty(n), np.empty(n)
    for k in range(n):
        explicit[k] = (ERROR[0] * stages[n + k] + ERROR[1] * stages[2 * n + k] + ERROR[2] * stages[3 * n + k]) / h
        right[k] = stages[k] + explicit[k]
    error, size = _solved(c, matrix, right)
    if 1.0 < size < math.inf:
        # At a boundary layer the first estimate is far too large: Hairer and Wanner filter it once more, (IV.8.20).
        for k in range(n):
            c.trial[k] = y[k] + error[k]
        slopes(c, c.count[MODE], t, c.trial, at(stages, 7 * n))
        for k in range(n):
            right[k] = stages[7 * n + k] + explicit[k]
        _, size = _solved(c, matrix, right)
    return size


@inner
def _solved(c, matrix, right):
    """Return the solution of a linear system and its size relative to the tolerances; infinite where ``right`` is not finite."""
    if not np.all(np.isfinite(right)):
        return right, math.inf
    error = np.linalg.solve(matrix, right)
    return error, _size(c, error)


@inner
def _size(c, error):
    total, n = 0.0, c.n_full
    for i in range(n):
        total += (error[i] / (c.atol + c.rtol * max(abs(c.y[i]), abs(c.trial[n + i])))) ** 2
    return math.sqrt(total / n) if math.isfinite(total) else math.inf


@inner
def _jacobian(c, mode, t):
    """Return the derivatives of all slopes in all variables: of states in states, and of a chain in itself and what it reads."""
    n, m, full, y = c.n, c.n_pairs, c.n_full, c.y
    result = np.zeros((full, full))
    read(c, t, y, c.xd, 0)
    for i in range(n * (n + m)):
        c.jacobian[i] = 0.0
    call(c.field_jacobian, mode, t, y, c.xd, c.p, c.jacobian)
    for i in range(n):
        for j in range(n):
            result[i, j] = c.jacobian[i * n + j]
        for j in range(m):
            slope = c.jacobian[n * n + i * m + j]
            if c.tau[c.pair_delay[j]] == 0.0:
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


@inner
def stiff_extension(c):
    """Write the collocation polynomial as coefficients of the form that all steps have: s, s(1 - s), s^2 (1 - s)."""
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
