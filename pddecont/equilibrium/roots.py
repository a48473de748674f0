"""Characteristic roots of an equilibrium: those farthest to the right, each to rounding, the unstable ones counted.

Eigenvalues of a discretised equation (``generator``) and points next to the imaginary axis are first guesses. Each is
corrected by Newton's method on Delta(lambda) q = 0, so that the discretisation leaves no error. A count by the argument
principle (``counting``) says whether a root to the right of the imaginary axis is lacking; then it is looked for with a
finer discretisation.

References: Breda, Maset, Vermiglio, SIAM J. Sci. Comput. 27 (2005); Engelborghs, Roose, SIAM J. Numer. Anal. 40 (2002).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg
from numpy.typing import NDArray

from pddecont.equilibrium.arnoldi import Guesses, find_around, find_rightmost
from pddecont.equilibrium.characteristic import CharacteristicMatrix, find_norm
from pddecont.equilibrium.counting import count_missing
from pddecont.equilibrium.generator import Generator
from pddecont.equilibrium.history import make_history
from pddecont.memo import cached_property

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
# Roots that are found, if not more are unstable.
N_ROOTS = 12
# Beside all unstable ones so many stable ones are found, which may cross the axis next.
NEXT = 8
# Points of the past: so many, and more for each radian that the fastest mode turns in the longest delay, up to many.
FEW_POINTS, PER_RADIAN, MANY_POINTS = 16, 0.7, 160
# Discretisations of more equations are not made whole.
WHOLE = 900
# How often roots that are lacking are looked for.
ROUNDS = 4
# Places around which more roots of a large matrix are looked for, at most.
STATIONS = 12
# Points along the axis from which roots are looked for, at most.
MOST_SPREAD = 4000
MAX_ITERATIONS = 30
# Roots that decay by more than exp(-DAMPED) in the longest delay are none that anybody asks for.
DAMPED = 200.0
# A guess that moves farther than this, relative to its size, is none; one that moves less than CLOSE was next to it.
NEAR, CLOSE = 0.3, 1e-3
# Roots nearer to the real axis than this part of the bound are real; below SMALL of it they are near zero.
REAL, SMALL = 1e-9, 1e-3
# Roots nearer than this part of the bound are one unless both were guessed: rounding moves double ones by its root.
SAME = 1e-7
# Newton's method stops at steps of this size, relative to the root.
STEP = 1e-13
# A root lies on the imaginary axis whose real part is smaller than this part of the largest that is kept.
ON_AXIS = 1e-12


@dataclass(frozen=True, eq=False)
class Roots:
    """Characteristic roots by descending real part, both of each conjugate pair.

    ``values`` and ``residuals`` |Delta q| / (|Delta| |q|) have shape (n_roots,), ``vectors`` q (n_roots, n_states).
    ``n_missing`` is the number of unstable ones that a count says are lacking; None where it could not be made.
    ``neutral_radius`` says how strong terms are that read rates of the past (``neutral``).
    """

    values: Complex
    residuals: Array
    vectors: Complex = field(repr=False)
    n_missing: int | None = 0
    neutral_radius: float = 0.0

    @cached_property
    def n_unstable(self) -> int:
        """Number of roots with positive real part."""
        return int(np.sum(self.values.real > self._rounding)) + (self.n_missing or 0)

    @property
    def counted(self) -> bool:
        """Whether a count confirms that no unstable root is lacking."""
        return self.n_missing == 0

    @property
    def stable(self) -> bool | None:
        """Whether all roots lie to the left of the imaginary axis.

        None where none lies to the right of it, but one on it or the count confirms it not: the linear equation does
        not tell then.
        """
        if self.n_unstable and self.counted:
            return False
        on_axis = np.any(np.abs(self.values.real) <= self._rounding)
        return True if self.counted and not on_axis else None

    @property
    def _rounding(self) -> float:
        """Real parts that are no larger are zero."""
        return ON_AXIS * float(np.max(np.abs(self.values), initial=0.0))


def find_roots(matrix: CharacteristicMatrix, n_roots: int = N_ROOTS) -> Roots:
    """Return the characteristic roots farthest to the right: ``n_roots`` or more, all unstable ones and some beside."""
    scale = _find_scale(matrix)
    turns = min(matrix.height, scale) * matrix.longest
    generator, found = _find_resolved(matrix, scale, n_roots)
    for _ in range(ROUNDS):
        values, vectors = _with_conjugates(*found)
        count = count_missing(matrix, values)
        if not len(count.places):
            break
        guesses = [_at_points(matrix, count.places)]
        if generator.size <= WHOLE:
            heights = np.linspace(0.0, scale, int(min(FEW_POINTS + PER_RADIAN * turns, MOST_SPREAD)))
            guesses.append(_at_points(matrix, np.concatenate([1j * heights, heights + 0.0j])))
        else:
            guesses += [find_around(generator, z)[1] for z in count.places[:STATIONS].tolist()]
        found = _gather(matrix, _join(guesses), found, scale)
    kept = max(n_roots, int(np.sum(values.real > 0.0)) + NEXT)
    if kept < len(values) and values[kept - 1].imag > 0.0:
        kept += 1
    values, vectors = values[:kept], vectors[:kept]
    residuals = np.array([_measure_residual(matrix, z, q) for z, q in zip(values.tolist(), vectors, strict=True)])
    return Roots(values, residuals, vectors, count.number, matrix.neutral_radius)


def _find_scale(matrix: CharacteristicMatrix) -> float:
    """Return the size of unstable roots: their bound, or where there is none the sizes of all terms."""
    if np.isfinite(matrix.bound):
        return max(matrix.bound, float(np.finfo(float).tiny))
    return sum(find_norm(m) for m in (matrix.unit, matrix.present, *matrix.delayed, *matrix.list_sizes()))


def _find_resolved(matrix: CharacteristicMatrix, scale: float, n_roots: int) -> tuple[Generator, Guesses]:
    """Return a discretised equation that resolves the roots that are kept, and the roots to which it leads."""
    longest = matrix.longest
    n_points = int(FEW_POINTS + min(PER_RADIAN * min(matrix.height, scale) * longest, MANY_POINTS))
    while True:
        generator = _make_generator(matrix, n_points)
        found = _gather(matrix, _guess(generator, n_roots), None, scale)
        values, _ = _with_conjugates(*found)
        farthest = float(np.max(np.abs(values[:n_roots]), initial=0.0))
        needed = int(FEW_POINTS + PER_RADIAN * farthest * longest)
        made = len(generator.history.g)
        if (
            needed <= n_points
            or made < n_points
            or n_points >= MANY_POINTS + FEW_POINTS
            or matrix.method.stages is not None
        ):
            return generator, found
        n_points = min(needed, MANY_POINTS + FEW_POINTS)


def _make_generator(matrix: CharacteristicMatrix, n_points: int) -> Generator:
    """Return the discretised equation, with fewer points where it would become too large to be made whole."""
    whole = Generator(matrix, make_history(matrix, 1))
    most = int((WHOLE - matrix.n) / max(len(whole.read), 1))
    return Generator(matrix, make_history(matrix, min(n_points, max(FEW_POINTS, most))))


def _guess(generator: Generator, n_roots: int) -> Guesses:
    """Return eigenvalues of the discretised equation in the upper half-plane, the rightmost ones."""
    matrix = generator.matrix
    longest = matrix.longest
    if generator.size > WHOLE:
        guesses = find_rightmost(generator, n_roots, _find_scale(matrix))
    else:
        values = np.linalg.eigvals(generator.make_whole()).astype(complex)
        guesses = values, np.zeros((len(values), 0), dtype=complex)
    values, vectors = guesses
    order = np.argsort(-values.real)
    order = order[(values[order].imag >= 0.0) & (values[order].real * longest > -DAMPED)]
    order = order[: int(np.sum(values[order].real > 0.0)) + 2 * n_roots]
    return _at_points(matrix, values[order]) if generator.size <= WHOLE else (values[order], vectors[order])


def _at_points(matrix: CharacteristicMatrix, values: Complex) -> Guesses:
    """Return guesses with the vectors that the characteristic matrix is smallest for."""
    return values, matrix.find_null_vectors(values)


def _join(guesses: list[Guesses]) -> Guesses:
    return np.concatenate([values for values, _ in guesses]), np.concatenate([vectors for _, vectors in guesses])


def _gather(matrix: CharacteristicMatrix, guesses: Guesses, known: Guesses | None, scale: float) -> Guesses:
    """Return the roots in the upper half-plane to which guesses lead (n_roots,), and their vectors (n_roots, n).

    Those that are ``known`` come first. Where none are, a root to which several guesses lead that were next to it is as
    many roots.
    """
    found: list[complex] = [] if known is None else [z for z in known[0].tolist() if z.imag >= 0.0]
    vectors: list[Complex] = [] if known is None else list(known[1][known[0].imag >= 0.0])
    values, q, moved, started = _correct(matrix, guesses, scale)
    values = np.where(values.imag < 0.0, np.conj(values), values)
    values = np.where(np.abs(values.imag) < REAL * scale, values.real, values)
    for z, vector, away, start in zip(values.tolist(), q, moved.tolist(), started.tolist(), strict=True):
        is_guess = known is None and away < CLOSE
        if is_guess or not any(abs(z - other) <= SAME * scale for other in found):
            # A pair that meets on the real axis is a double root.
            times = 2 if is_guess and start.imag > 0.0 and z.imag == 0.0 else 1
            found += [complex(z)] * times
            vectors += [vector] * times
    return np.array(found, dtype=complex), np.array(vectors, dtype=complex).reshape(-1, matrix.n)


def _correct(matrix: CharacteristicMatrix, given: Guesses, scale: float) -> tuple[Complex, Complex, Array, Complex]:
    """Return the roots to which guesses lead, their vectors (n_roots, n), how far the guesses were, and the guesses."""
    guesses, q = given[0].astype(complex), given[1].copy()
    values = guesses.copy()
    active, settled = np.ones(len(values), dtype=bool), np.zeros(len(values), dtype=bool)
    for _ in range(MAX_ITERATIONS):
        here = np.flatnonzero(active)
        if not len(here):
            break
        step, q[here] = _find_steps(matrix, values[here], q[here])
        values[here] += step
        size = np.abs(step) / (np.abs(values[here]) + SMALL * scale)
        active[here] = np.isfinite(size) & (size > STEP)
        # A double root is approached by half of the way at a time.
        settled[here] = np.isfinite(size) & (size < np.sqrt(STEP))
    moved = np.abs(values - guesses) / (np.abs(guesses) + SMALL * scale)
    good = settled & (moved < NEAR)
    return values[good], q[good], moved[good], guesses[good]


def _find_steps(matrix: CharacteristicMatrix, roots: Complex, q: Complex) -> tuple[Complex, Complex]:
    """Return a Newton step of each root for Delta q = 0 with |q| = 1, and the vectors after it."""
    n, c = matrix.n, np.conj(q)
    steps, after = np.zeros(len(roots), dtype=complex), q.copy()
    if matrix.is_sparse:
        for k, root in enumerate(roots.tolist()):
            delta, slope = matrix.at(root)
            bordered = sp.bmat([[delta, (slope @ q[k])[:, None]], [c[k][None], None]], format="csc")
            solved = scipy.sparse.linalg.splu(bordered).solve(np.append(np.zeros(n), 1.0 + 0.0j))
            steps[k], after[k] = solved[n], solved[:n] / np.linalg.norm(solved[:n])
        return steps, after
    delta, slope = matrix.at_many(roots)
    bordered = np.zeros((len(roots), n + 1, n + 1), dtype=complex)
    bordered[:, :n, :n], bordered[:, :n, n], bordered[:, n, :n] = delta, np.einsum("kij,kj->ki", slope, q), c
    right = np.zeros((len(roots), n + 1, 1), dtype=complex)
    right[:, n] = 1.0
    with np.errstate(all="ignore"):
        try:
            solved = np.linalg.solve(bordered, right)[:, :, 0]
        except np.linalg.LinAlgError:
            solved = np.array(
                [np.linalg.lstsq(b, r, rcond=None)[0][:, 0] for b, r in zip(bordered, right, strict=True)]
            )
        vectors = solved[:, :n]
        return solved[:, n], vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def _with_conjugates(values: Complex, vectors: Complex) -> tuple[Complex, Complex]:
    """Return roots with the conjugates of those off the real axis, by descending real part."""
    off = values.imag > 0.0
    both = np.concatenate([values, np.conj(values[off])])
    all_vectors = np.concatenate([vectors, np.conj(vectors[off])])
    # Pairs stay together, the upper root first.
    order = np.lexsort((-both.imag, -np.abs(both.imag), -both.real))
    return both[order], all_vectors[order]


def _measure_residual(matrix: CharacteristicMatrix, root: complex, q: Complex) -> float:
    """Return |Delta q| relative to the sum of its terms, in the largest rows."""
    delta, terms = matrix.at(root)[0], abs(root) * matrix.unit + abs(matrix.present)
    for through, (factor, _) in zip(matrix.delayed, matrix.list_factors(root), strict=True):
        terms = terms + float(abs(factor)) * abs(through)
    # The size of an integral is at most that on the axis times the largest exponential.
    for sizes in matrix.list_sizes():
        terms = terms + float(np.exp(max(0.0, -root.real * matrix.longest))) * sizes
    return float(np.max(np.abs(delta @ q)) / max(float(np.max(terms @ np.abs(q))), float(np.finfo(float).tiny)))
