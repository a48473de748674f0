"""The leading Floquet multipliers of a periodic orbit.

They are the eigenvalues of the map from one history to the next (``stability.period``): all of them for a small history, the
largest by Arnoldi's method for a large one. An autonomous orbit without events has the multiplier 1 of its own flow; it is told
from the others as the nearest to 1, and its distance to 1 measures the error. An orbit with events starts at one, which takes the
flow's direction out.

References: Lust, Int. J. Bif. Chaos 11 (2001); Szalai, Stepan, Hogan, SIAM J. Sci. Comput. 28 (2006).
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg
import scipy.sparse.linalg
from numpy.typing import NDArray

from pddecont.orbit.mesh import Mesh
from pddecont.orbit.meshing import on_mesh
from pddecont.orbit.problem import OrbitProblem
from pddecont.stability.period import LaggedBlocks, Period, linearise

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
SMALL = 1e-3
AT_MOST = 12
DENSE, DENSE_LINES = 160, 1200
NEAR_KNOWN = 0.02
TRIVIAL_ERROR = 1e-4
STAYS = 1e-4
LOST = 0.9
LOST_ADVICE = ("the multipliers are lost among those of this delay line's own stages, which are far shorter than mesh intervals: use more "
               "intervals, a lower 'n' or order, or the direct method")  # fmt: skip


@dataclass(frozen=True, eq=False)
class Multipliers:
    """Multipliers in order of falling modulus.

    ``values`` holds all of them; ``own`` leaves out the trivial one of an autonomous orbit, whose distance to 1 is ``trivial_error``
    (NaN where there is none). ``noise`` is the largest modulus of those that belong to the mesh and not to the orbit (long delay lines have
    some): they are left out, with all that are no larger.
    """

    values: Complex
    own: Complex
    trivial_error: float = float("nan")
    noise: float = 0.0

    @property
    def lost(self) -> bool:
        """Whether the multipliers say nothing of stability."""
        return self.noise > LOST

    @property
    def n_unstable(self) -> int:
        """Number of multipliers outside the unit circle, the trivial one left out."""
        return int(np.sum(np.abs(self.own) > 1.0))

    @property
    def stable(self) -> bool:
        """Whether all but the trivial one lie inside the unit circle."""
        return self.n_unstable == 0


def describe(m: Multipliers) -> str:
    """Return stability in words, with a warning where the trivial multiplier is far from 1."""
    leading = ", ".join(f"{v.real:.6g}" if v.imag == 0.0 else f"{v.real:.6g} {v.imag:+.6g}i" for v in m.own[:2])
    if m.lost:
        return f"WARNING: {LOST_ADVICE}"
    text = f"{'stable' if m.stable else f'unstable ({m.n_unstable} multipliers outside the unit circle)'}, leading {leading or 'none'}"
    if np.isfinite(m.trivial_error):
        text += f", trivial multiplier off by {m.trivial_error:.1e}"
        if m.trivial_error > TRIVIAL_ERROR:
            text += " (WARNING: refine 'mesh', the multipliers are no better than that)"
    return text


def multipliers(problem: OrbitProblem, x: Array, n: int | None = None) -> Multipliers:
    """Return the ``n`` leading multipliers of the orbit ``x`` (None: those of modulus above ``SMALL``, at most ``AT_MOST``)."""
    return multipliers_of(linearise(problem, x), problem, x, n)


def multipliers_of(period: Period, problem: OrbitProblem, x: Array, n: int | None) -> Multipliers:
    """Return the same from the orbit's linearised map."""
    wanted = AT_MOST if n is None else n
    values, noise = _leading(period, wanted), 0.0
    if period.couplings:
        # The stages of a long line are far shorter than mesh intervals, and collocation lets their own motions ring on. Such multipliers
        # belong to the mesh: on another one they are elsewhere.
        other = _leading(linearise(*on_mesh(*problem.with_free(x, ()), _with_one_more(problem.mesh))), 2 * wanted)
        stays = np.array([np.min(np.abs(other - v), initial=np.inf) < STAYS * max(1.0, abs(v)) for v in values], dtype=bool)
        noise = float(np.max(np.abs(values[~stays]), initial=0.0))
        values = values[stays & (np.abs(values) > noise)]
    values = _in_order(values)
    trivial = not problem.numeric.model.forced and not problem.segments[0].event
    kept = values[:wanted]
    if n is None:
        kept = kept[: max(1, int(np.sum(np.abs(kept) >= SMALL)))]
    if len(kept) and len(values) > len(kept) and abs(kept[-1].imag) > 0.0 and values[len(kept)] == np.conj(kept[-1]):
        kept = values[: len(kept) + 1]
    if not trivial:
        return Multipliers(kept, kept, noise=noise)
    return replace(_without_trivial(kept), noise=noise)


def _leading(period: Period, n: int) -> Complex:
    """Return at least ``n`` leading eigenvalues of the period map."""
    size = period.size
    if not size:
        return np.zeros(0, dtype=complex)
    if size <= max(DENSE_LINES if period.couplings else DENSE, n + 2):
        values = scipy.linalg.eigvals(period.matrix())
        return values[np.argsort(-np.abs(values), kind="stable")][: 2 * n + 2]
    return _arnoldi(scipy.sparse.linalg.LinearOperator((size, size), matvec=period.one, dtype=float), n)


def _with_one_more(mesh: Mesh) -> Mesh:
    """Return a mesh of the same pieces with one interval more in each."""
    def finer(cuts: Array) -> Array:
        return np.interp(np.linspace(0.0, 1.0, len(cuts) + 1), np.linspace(0.0, 1.0, len(cuts)), cuts)

    return replace(mesh, pieces=tuple(replace(piece, cuts=finer(piece.cuts)) for piece in mesh.pieces))


def _arnoldi(operator: scipy.sparse.linalg.LinearOperator, n: int) -> Complex:
    size = operator.shape[0]
    start = np.random.default_rng(1).standard_normal(size)
    n_vectors = min(size - 1, max(3 * n, 40))
    try:
        return scipy.sparse.linalg.eigs(operator, k=n, ncv=n_vectors, v0=start, tol=0.0, return_eigenvectors=False)
    except scipy.sparse.linalg.ArpackNoConvergence as exc:
        return exc.eigenvalues


def _in_order(values: Complex) -> Complex:
    """Return values by falling modulus; of a conjugate pair the upper one first."""
    values = values[np.lexsort((-values.imag, -values.real))]
    return values[np.argsort(-np.round(np.abs(values), 12), kind="stable")]


def _without_trivial(values: Complex) -> Multipliers:
    error = float(np.min(np.abs(values - 1.0))) if len(values) else float("nan")
    return Multipliers(values, without(values, 1.0), error)


def without(values: Complex, known: float) -> Complex:
    """Return multipliers without the one that is known to be ``known`` (1 or -1).

    Where another comes near it the two may come out of a defective matrix as a conjugate pair, or with errors of the order of the
    square root of rounding; their sum is well conditioned, so the other is what ``known`` leaves of it.
    """
    if not len(values):
        return values
    i = int(np.argmin(np.abs(values - known)))
    rest = np.delete(values, i)
    if len(rest):
        j = int(np.argmin(np.abs(rest - known)))
        if abs(rest[j] - known) < NEAR_KNOWN:
            rest[j] = (values[i] + rest[j]).real - known
    return _in_order(rest)


def eigenvector(problem: OrbitProblem, x: Array, multiplier: float) -> Array:
    """Return how the orbit's unknowns (no free parameters) change with the real multiplier nearest to ``multiplier``, largest entry 1."""
    period = linearise(problem, x)
    if period.size <= 4 * DENSE:
        values, vectors = scipy.linalg.eig(period.matrix())
    else:
        operator = scipy.sparse.linalg.LinearOperator((period.size, period.size), matvec=period.one, dtype=float)
        start = np.random.default_rng(1).standard_normal(period.size)
        values, vectors = scipy.sparse.linalg.eigs(operator, k=AT_MOST, v0=start, tol=0.0)
    history = vectors[:, np.argmin(np.abs(values - multiplier))].real
    change = period.step(history[:, None])[0][: period.problem.layout.size, 0]
    return change / change[np.argmax(np.abs(change))]


class Known:
    """Multipliers of orbits, each computed once while it is in use."""

    def __init__(self, n: int | None = None):
        self.n = n
        self._kept: deque[tuple[Array, Multipliers]] = deque(maxlen=32)
        self._blocks: LaggedBlocks | None = None

    def __call__(self, problem: OrbitProblem, x: Array) -> Multipliers:
        """Return the multipliers of the orbit ``x``."""
        for known, result in self._kept:
            if known is x:
                return result
        period = linearise(problem, x, self._blocks)
        self._blocks = period.blocks
        result = multipliers_of(period, problem, x, self.n)
        self._kept.append((x, result))
        return result
