"""Multipliers corrected on the characteristic matrix, each with the residual that is left.

With v and w the right and left null vectors of M(z), the generalised Rayleigh quotient moves z by
-(w* M v) / (w* M' v); each step squares the distance to the multiplier or better. What is left of M v, the rows of M
and v scaled to a largest entry of modulus 1, is the multiplier's residual: it belongs exactly to equations that differ
by so much.

Reference: Schreiber, Nonlinear Eigenvalue Problems (2008), section 4; Guettel, Tisseur, Acta Numerica 26 (2017).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation import scale_matrix
from pddecont.errors import ConvergenceError
from pddecont.stability.characteristic import Characteristic, Factors, factor_at

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
# A multiplier with a larger residual is none of the orbit's.
RESIDUAL = 1e-11
# A relative correction smaller than this is the last where its square is below rounding.
LAST_CORRECTION = 1e-8
MAX_CORRECTIONS = 12
# Rounding moves a multiplier of larger condition by more than this: it is one of several that (nearly) coincide, whose
# sum is well conditioned where they come from one map. They are left as they are.
CLUSTERED = 1e-9
# Multipliers nearer than this, relative to their size, may be one found twice; a count says whether one is too many.
SAME = 1e-8
ROUNDING = float(np.finfo(float).eps)


@dataclass(frozen=True, eq=False)
class Refined:
    """A multiplier with its residual, its vector X (n,), largest entry 1, and whether it is one of a cluster."""

    value: complex
    residual: float
    vector: Complex
    clustered: bool


def refine(characteristic: Characteristic, value: complex) -> Refined | None:
    """Return the multiplier near ``value``, None if there is none to be found. Real values stay real."""
    try:
        z = 1.0 / value
        for _ in range(MAX_CORRECTIONS):
            factors, at = _factor_near(characteristic, z)
            right, left = _find_null_vectors(factors, value.imag == 0.0)
            derivative = scale_matrix(characteristic.derivative(at), factors.rows, np.ones(characteristic.size))
            slope = np.vdot(left, derivative @ right) * at
            residual = float(np.max(np.abs(factors.matrix @ right)))
            condition = float(np.sum(np.abs(left))) / max(abs(slope), np.finfo(float).tiny)
            correction = -np.vdot(left, factors.matrix @ right) / slope if slope else np.inf
            if condition * ROUNDING > CLUSTERED and residual < RESIDUAL:
                return Refined(1.0 / z, residual, right, True)
            if not np.isfinite(correction) or abs(correction) > 1.0:
                return None
            z = at * (1.0 + correction)
            if abs(correction) < LAST_CORRECTION:
                # A step of inverse iteration moves the vector on with the multiplier. Beside another multiplier, as at
                # a fold, the next correction is not far below this one: then one more is made.
                found = _conclude(characteristic, z, _normalise(factors.solve(derivative @ right)))
                if found is not None:
                    return found
    except (ConvergenceError, ZeroDivisionError, OverflowError):
        return None
    return None


def _conclude(characteristic: Characteristic, z: complex, vector: Complex) -> Refined | None:
    matrix = characteristic.matrix(z)
    residual = float(np.max(np.abs(matrix @ vector) / characteristic.row_sizes(z)))
    return Refined(1.0 / z, residual, vector, False) if residual < RESIDUAL else None


def _factor_near(characteristic: Characteristic, z: complex) -> tuple[Factors, complex]:
    """Return the factors at ``z``, or a few roundings away where the matrix is singular there to the last bit."""
    for shift in (0.0, 8.0 * ROUNDING, 64.0 * ROUNDING):
        try:
            return factor_at(characteristic, z * (1.0 + shift)), z * (1.0 + shift)
        except ConvergenceError:
            continue
    raise ConvergenceError("the characteristic matrix is singular")


def _find_null_vectors(factors: Factors, real: bool) -> tuple[Complex, Complex]:
    """Return what M and its conjugate transpose shrink most, the largest entries 1, by inverse iteration for both."""
    n = factors.matrix.shape[0]
    rng = np.random.default_rng(1)
    right = rng.standard_normal(n) if real else rng.standard_normal(n) + 1j * rng.standard_normal(n)
    for _ in range(2):
        left = _normalise(factors.solve_adjoint(right))
        right = _normalise(factors.solve(left))
    return right, left


def _normalise(v: Complex) -> Complex:
    return np.asarray(v / v[np.argmax(np.abs(v))])


def find_vector(characteristic: Characteristic, multiplier: float) -> Array:
    """Return the vector of the real multiplier nearest to ``multiplier``, its largest entry 1.

    Raises
    ------
    ConvergenceError
        If the characteristic matrix is not defined there.
    """
    found = refine(characteristic, complex(multiplier))
    if found is not None:
        return np.asarray(found.vector.real)
    factors, _ = _factor_near(characteristic, complex(1.0 / multiplier))
    return np.asarray(_find_null_vectors(factors, True)[0].real)
