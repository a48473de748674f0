"""The multipliers of an orbit that remembers no more than a period: eigenvalues of its map, none of them missing.

They are those of a map that differs by rounding, as small residuals show. Of several that (nearly) coincide the sum
keeps all its digits, since they come from one map. Where rounding alone makes multipliers out of a map that shifts and
magnifies, their vectors are all but the same: such a list is refused.

What is left of the map M once their vectors are taken out tells whether the list is complete. If it had an eigenvalue
mu with the left vector w, a random history y would be |w M^k y| = |mu|^k |w y| or more after k periods, and |w y| is
below SMALL_PART |w| in one of 1000 cases only. Where some random histories all shrink to less than SMALL_PART r^k none
of a modulus of r or more is missing, but for one case in 10^12.

Reference: Dixon, SIAM J. Numer. Anal. 20 (1983), for norms from random vectors.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from pddecont.stability.candidates import find_eigenpairs
from pddecont.stability.monodromy import MonodromyOperator
from pddecont.stability.refinement import RESIDUAL, Refined

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
# Histories up to this size are mapped whole.
SHORT = 160
# Vectors of a double multiplier, torn apart by rounding, are about its root apart.
APART = 1e-10
# Random histories, the part of one that may lie along any vector, and periods in which they must have shrunk.
HISTORIES, SMALL_PART, PERIODS = 4, 1e-3, 64


def find_all_outside(monodromy: MonodromyOperator, n: int, radius: float) -> list[Refined] | None:
    """Return about ``n`` leading multipliers by falling modulus, with all outside |mu| = ``radius``.

    None where the orbit remembers more than a period, or where that none is missing cannot be told so.
    """
    if len(monodromy.kept) > 1 or (monodromy.size <= SHORT and not np.all(np.isfinite(monodromy.scaled_matrix))):
        return None
    sizes = monodromy.history_sizes[:, None]

    def advance(histories: Array) -> Array:
        if monodromy.size <= SHORT:
            return np.asarray(monodromy.scaled_matrix @ histories)
        return monodromy.step(histories * sizes)[1] / sizes

    values, vectors = _find_leading(monodromy, n)
    if not (len(values) and np.all(np.isfinite(values))):
        return None
    residuals = _measure_residuals(values, vectors, advance)
    outside = np.abs(values) > radius
    if np.any(residuals > RESIDUAL) or not (
        _are_apart(vectors[:, outside]) and _nothing_is_left(vectors, advance, radius)
    ):
        return None
    return [Refined(complex(v), float(r), y, True) for v, r, y in zip(values, residuals, vectors.T, strict=True)]


def _find_leading(monodromy: MonodromyOperator, n: int) -> tuple[Complex, Complex]:
    """Return leading eigenvalues by falling modulus, and their vectors as columns."""
    if monodromy.size > SHORT:
        return find_eigenpairs(monodromy, n)
    values, vectors = scipy.linalg.eig(monodromy.scaled_matrix)
    leading = np.argsort(-np.abs(values), kind="stable")[:n]
    return values[leading], vectors[:, leading]


def _measure_residuals(values: Complex, vectors: Complex, advance: Callable[[Array], Array]) -> Array:
    """Return what each multiplier and its vector leave of M y - mu y, relative to y or mu y, whichever is larger."""
    mapped = advance(vectors.real) + 1j * advance(vectors.imag)
    left = np.max(np.abs(mapped - values * vectors), axis=0)
    return np.asarray(left / np.maximum(1.0, np.abs(values)) / np.max(np.abs(vectors), axis=0))


def _are_apart(vectors: Complex) -> bool:
    """Return whether vectors are as far from dependent as those of a map with a double multiplier are, or farther."""
    lengths = np.linalg.norm(vectors, axis=0)
    return vectors.shape[1] < 2 or bool(np.linalg.svd(vectors / lengths, compute_uv=False)[-1] > APART)


def _nothing_is_left(vectors: Complex, advance: Callable[[Array], Array], radius: float) -> bool:
    """Return whether histories without what some vectors span shrink as they would without multipliers outside."""
    spanned, _ = np.linalg.qr(np.concatenate([vectors.real, vectors.imag], axis=1))

    def take_out(histories: Array) -> Array:
        return np.asarray(histories - spanned @ (spanned.T @ histories))

    histories = take_out(np.random.default_rng(2).standard_normal((len(vectors), HISTORIES)))
    for _ in range(PERIODS):
        histories = take_out(advance(histories)) / radius
        largest = np.max(np.linalg.norm(histories, axis=0))
        if largest < SMALL_PART:
            return True
        if not np.isfinite(largest):
            return False
    return False
