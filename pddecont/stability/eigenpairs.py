"""The multipliers of an orbit that remembers no more than a period: eigenvalues of its map, none of them missing.

They are those of a map that differs by rounding, as small residuals show. Of several that (nearly) coincide the sum
keeps all its digits, since they come from one map. Where rounding alone makes multipliers out of a map that shifts and
magnifies, their vectors are all but the same: such a list is refused.

What is left of the map M once their vectors are taken out tells whether the list is complete. If it had an eigenvalue
mu with the left vector w, a random history y would be |w M^k y| = |mu|^k |w y| or more after k periods, and |w y| is
below SMALL_PART |w| in one of 1000 cases only. Where some random histories all shrink to less than SMALL_PART r^k none
of a modulus of r or more is missing, but for one case in 10^12.

References: Dixon, SIAM J. Numer. Anal. 20 (1983), for norms from random vectors; Golub, Van Loan, Matrix Computations
(2013), section 5.4, for the directions that a map leads to.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

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
# A map onto no more than this part of its dimensions is looked at there: looking costs a tenth of its eigenvalues.
PAYS = 0.8
# What is this much smaller than the largest a map makes is nothing: well below rounding, which eigenvalues may magnify.
NOTHING = float(np.finfo(float).eps) / 8.0
# Of a map so large that this would hide more, nothing is left out.
HIDDEN = 1e-3
# Directions into which a map of more than this many is looked at first, and how often it leads there. No more than half
# of them are to belong to multipliers; those come with others down to a part of the least that is asked for, beside
# which what is left of the map shrinks fast.
FEW, MANY, TURNS, SPARE = 16, 50, 3, 8.0
# What a vector may leave of a map relative to its size: rounding. A larger map is looked at as a whole, whose small
# multipliers keep more digits.
EXACT, LARGE = 1e-14, 1e2


def find_all_outside(monodromy: MonodromyOperator, n: int, radius: float, least: float = 0.0) -> list[Refined] | None:
    """Return about ``n`` leading multipliers by falling modulus, with all outside |mu| = ``radius``.

    Those below ``least`` are left out, but one if there is no other. None where the orbit remembers more than a period,
    or where that none is missing cannot be told so.
    """
    if len(monodromy.kept) > 1 or (monodromy.size <= SHORT and not np.all(np.isfinite(monodromy.scaled_matrix))):
        return None

    def advance(histories: Array) -> Array:
        if monodromy.size <= SHORT:
            return np.asarray(monodromy.scaled_matrix @ histories)
        sizes = monodromy.history_sizes[:, None]
        return monodromy.step(histories * sizes)[1] / sizes

    values, vectors, complete = _find_leading(monodromy, n, least)
    if not (len(values) and np.all(np.isfinite(values))):
        return None
    kept = max(1, int(np.sum(np.abs(values) >= least)))
    values, vectors = values[:kept], vectors[:, :kept]
    residuals = _measure_residuals(values, vectors, advance)
    outside = np.abs(values) > radius
    if np.any(residuals > RESIDUAL) or not (
        _are_apart(vectors[:, outside])
        and ((complete and least <= radius) or _nothing_is_left(vectors[:, values.imag >= 0.0], advance, radius))
    ):
        return None
    return [Refined(complex(v), float(r), y, True) for v, r, y in zip(values, residuals, vectors.T, strict=True)]


def find_few(matrix: Array, least: float) -> tuple[Complex, Complex] | None:
    """Return all eigenvalues of modulus ``least`` or more by falling modulus, and their vectors as columns.

    Shapes (k,) and (size, k), of a ``matrix`` (size, size) that is finite. It is looked at where it leads some random
    histories again and again. None where that does not tell them to rounding, where there are none or too many, or
    where others may be missing.

    Reference: Golub, Van Loan, Matrix Computations (2013), section 7.3.2, for such iterations.
    """
    size = float(np.linalg.norm(matrix))
    if not size <= LARGE:
        return None
    images = matrix @ _draw_histories(len(matrix), FEW)
    for _ in range(TURNS):
        factors, scales, _, _ = lapack.dgeqrf(images)
        basis, _, _ = lapack.dorgqr(factors, scales)
        images = matrix @ basis
    values, inside = np.linalg.eig(basis.T @ images)
    leading = np.argsort(-np.abs(values), kind="stable")
    leading = leading[np.abs(values[leading]) >= least / SPARE]
    values, inside = values[leading].astype(complex), inside[:, leading].astype(complex)
    wanted = np.abs(values) >= least
    if not np.any(wanted) or len(values) > FEW // 2:
        return None
    vectors = basis @ inside
    left = np.linalg.norm(images @ inside - values * vectors, axis=0)
    if not np.all(left <= EXACT * size):
        return None
    if not _nothing_is_left(vectors[:, values.imag >= 0.0], lambda histories: matrix @ histories, least):
        return None
    return values[wanted], vectors[:, wanted]


def _find_leading(monodromy: MonodromyOperator, n: int, least: float) -> tuple[Complex, Complex, bool]:
    """Return leading eigenvalues by falling modulus, their vectors as columns, and whether no other reaches ``least``.

    They are about ``n``, or all that reach ``least``.
    """
    if monodromy.size > SHORT:
        return *find_eigenpairs(monodromy, n), False
    # Near grazing the map has large and small entries; with rows and columns of one size none of them is lost.
    balanced, _, _, sizes, _ = lapack.dgebal(monodromy.scaled_matrix, scale=1)
    few = find_few(balanced, least) if least > 0.0 and len(balanced) > MANY else None
    if few is not None:
        return few[0], sizes[:, None] * few[1], True
    basis, inside = find_inside(balanced)
    values, vectors = np.linalg.eig(inside)
    leading = np.argsort(-np.abs(values), kind="stable")[:n]
    return values[leading].astype(complex), sizes[:, None] * (basis @ vectors[:, leading].astype(complex)), False


def find_inside(matrix: Array) -> tuple[Array, Array]:
    """Return columns at right angles that span where a map leads, again and again, and what it is there.

    Shapes (size, k) and (k, k): the map times the columns is the columns times the small map, to rounding. Both have
    the same eigenvalues but for zeros, of which smooth motions make most: what they are is lost in the first period.
    """
    basis, inside = np.eye(len(matrix)), matrix
    while len(inside):
        factors, order, scales, _, _ = lapack.dgeqp3(inside)
        heights = np.abs(np.diag(factors))
        k = max(1, int(np.count_nonzero(heights > NOTHING * heights[0])))
        if k > PAYS * len(inside) or NOTHING * heights[0] > HIDDEN:
            break
        columns, _, _ = lapack.dorgqr(factors[:, :k], scales[:k])
        # The first columns are their own product with the identity.
        basis = columns if inside is matrix else basis @ columns
        inside = np.triu(factors[:k]) @ columns[order - 1]
    return basis, inside


def _measure_residuals(values: Complex, vectors: Complex, advance: Callable[[Array], Array]) -> Array:
    """Return what each multiplier and its vector leave of M y - mu y, relative to y or mu y, whichever is larger."""
    mapped = advance(vectors.real) + 1j * advance(vectors.imag)
    left = np.max(np.abs(mapped - values * vectors), axis=0)
    return np.asarray(left / np.maximum(1.0, np.abs(values)) / np.max(np.abs(vectors), axis=0))


def _are_apart(vectors: Complex) -> bool:
    """Return whether vectors are as far from dependent as those of a map with a double multiplier are, or farther."""
    if vectors.shape[1] < 2:
        return True
    return bool(np.linalg.svd(vectors / np.linalg.norm(vectors, axis=0), compute_uv=False)[-1] > APART)


def _nothing_is_left(vectors: Complex, advance: Callable[[Array], Array], radius: float) -> bool:
    """Return whether histories without what some vectors span shrink as they would without multipliers outside.

    Of a conjugate pair one vector does for both.
    """
    spanned, _ = np.linalg.qr(np.concatenate([vectors.real, vectors.imag[:, np.any(vectors.imag, axis=0)]], axis=1))

    def take_out(histories: Array) -> Array:
        return np.asarray(histories - spanned @ (spanned.T @ histories))

    histories = take_out(_draw_histories(len(vectors), HISTORIES))
    for _ in range(PERIODS):
        histories = take_out(advance(histories)) / radius
        largest = np.max(np.linalg.norm(histories, axis=0))
        if largest < SMALL_PART:
            return True
        if not np.isfinite(largest):
            return False
    return False


@cache
def _draw_histories(size: int, n: int) -> Array:
    """Return random histories, shape (size, n), the same each time."""
    return np.random.default_rng(2).standard_normal((size, n))
