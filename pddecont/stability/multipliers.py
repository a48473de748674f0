"""The leading Floquet multipliers of a periodic orbit.

They are the eigenvalues of the map from one history to the next (``stability.monodromy``): all of them for a small
history, the largest by Arnoldi's method for a large one. An autonomous orbit without events has the multiplier 1 of its
own flow; it is told from the others as the nearest to 1, and its distance to 1 measures the error. An orbit with events
starts at one, which takes the flow's direction out.

References: Lust, Int. J. Bif. Chaos 11 (2001); Szalai, Stepan, Hogan, SIAM J. Sci. Comput. 28 (2006).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.sparse.linalg
from numpy.typing import NDArray

from pddecont.collocation import refine_evenly
from pddecont.orbit import Assembly, Orbit, transfer_orbit
from pddecont.stability.monodromy import MonodromyOperator, linearise_period

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
# Multipliers below this modulus are left out where nobody says how many are wanted, and all beyond so many.
SMALL = 1e-3
AT_MOST = 12
# Histories up to this size are mapped whole; those with delay lines, whose own multipliers crowd, up to the second.
DENSE, DENSE_LINES = 160, 1200
# A multiplier this near to a known one comes out of a defective matrix together with it.
NEAR_KNOWN = 0.02
# A trivial multiplier farther from 1 than this says that the mesh is too coarse.
TRIVIAL_ERROR = 1e-4
# A multiplier that moves by more than this on another mesh belongs to the mesh.
STAYS = 1e-4
# Where multipliers of the mesh are larger than this, nothing is known of stability.
UNRELIABLE = 0.9


@dataclass(frozen=True, eq=False)
class Multipliers:
    """Multipliers in order of falling modulus.

    ``values`` holds all of them; ``nontrivial`` leaves out the trivial one of an autonomous orbit, whose distance to 1
    is ``trivial_error`` (NaN where there is none). ``spurious`` is the largest modulus of those that belong to the mesh
    and not to the orbit (long delay lines have some): they are left out, with all that are no larger.
    """

    values: Complex
    nontrivial: Complex
    trivial_error: float = float("nan")
    spurious: float = 0.0

    @property
    def unreliable(self) -> bool:
        """Whether the multipliers say nothing of stability."""
        return self.spurious > UNRELIABLE

    @property
    def n_unstable(self) -> int:
        """Number of multipliers outside the unit circle, the trivial one left out."""
        return int(np.sum(np.abs(self.nontrivial) > 1.0))

    @property
    def stable(self) -> bool:
        """Whether all but the trivial one lie inside the unit circle."""
        return self.n_unstable == 0


def find_multipliers(orbit: Orbit, n: int | None = None) -> Multipliers:
    """Return the ``n`` leading multipliers of an orbit (None: those beyond ``SMALL``, at most ``AT_MOST``)."""
    return multipliers_of_map(linearise_period(orbit), orbit, n)


def multipliers_of_map(monodromy: MonodromyOperator, orbit: Orbit, n: int | None) -> Multipliers:
    """Return the same from the orbit's linearised map."""
    wanted = AT_MOST if n is None else n
    values, spurious = _find_leading(monodromy, wanted), 0.0
    if monodromy.couplings:
        # The stages of a long line are far shorter than mesh intervals, and collocation lets their own motions ring on.
        # Such multipliers belong to the mesh: on another one they are elsewhere.
        fixed = orbit.with_free(())
        other = _find_leading(linearise_period(transfer_orbit(fixed, refine_evenly(orbit.mesh))), 2 * wanted)
        near = [np.min(np.abs(other - v), initial=np.inf) < STAYS * max(1.0, abs(v)) for v in values]
        stays = np.array(near, dtype=bool)
        spurious = float(np.max(np.abs(values[~stays]), initial=0.0))
        values = values[stays & (np.abs(values) > spurious)]
    values = _sort(values)
    kept = values[:wanted]
    if n is None:
        kept = kept[: max(1, int(np.sum(np.abs(kept) >= SMALL)))]
    cuts_pair = len(kept) and len(values) > len(kept) and abs(kept[-1].imag) > 0.0
    if cuts_pair and values[len(kept)] == np.conj(kept[-1]):
        kept = values[: len(kept) + 1]
    if not orbit.signature.needs_phase_reference:
        return Multipliers(kept, kept, spurious=spurious)
    error = float(np.min(np.abs(kept - 1.0))) if len(kept) else float("nan")
    return Multipliers(kept, remove_known(kept, 1.0), error, spurious)


def _find_leading(monodromy: MonodromyOperator, n: int) -> Complex:
    """Return at least ``n`` leading eigenvalues of a map."""
    size = monodromy.size
    if not size:
        return np.zeros(0, dtype=complex)
    if size <= max(DENSE_LINES if monodromy.couplings else DENSE, n + 2):
        values = scipy.linalg.eigvals(monodromy.to_matrix())
        return np.asarray(values[np.argsort(-np.abs(values), kind="stable")][: 2 * n + 2])
    # Arnoldi's method wants room for several times as many vectors as values.
    n_vectors = min(size - 1, max(3 * n, 40))
    operator, start = _as_operator(monodromy), _start(size)
    try:
        values = scipy.sparse.linalg.eigs(operator, k=n, ncv=n_vectors, v0=start, tol=0.0, return_eigenvectors=False)
    except scipy.sparse.linalg.ArpackNoConvergence as exc:
        values = exc.eigenvalues
    return np.asarray(values)


def _as_operator(monodromy: MonodromyOperator) -> scipy.sparse.linalg.LinearOperator:
    size = monodromy.size
    return scipy.sparse.linalg.LinearOperator((size, size), matvec=monodromy.apply, dtype=float)


def _start(size: int) -> Array:
    """Return the vector that Arnoldi's method starts from: any, but the same each time."""
    return np.random.default_rng(1).standard_normal(size)


def _sort(values: Complex) -> Complex:
    """Return values by falling modulus; of a conjugate pair the upper one first."""
    values = values[np.lexsort((-values.imag, -values.real))]
    return np.asarray(values[np.argsort(-np.round(np.abs(values), 12), kind="stable")])


def remove_known(values: Complex, known: float) -> Complex:
    """Return multipliers without the one that is known to be ``known`` (1 or -1).

    Where another comes near it the two may come out of a defective matrix as a conjugate pair, or with errors of the
    order of the square root of rounding; their sum is well conditioned, so the other is what ``known`` leaves of it.
    """
    if not len(values):
        return values
    i = int(np.argmin(np.abs(values - known)))
    rest = np.delete(values, i)
    if len(rest):
        j = int(np.argmin(np.abs(rest - known)))
        if abs(rest[j] - known) < NEAR_KNOWN:
            rest[j] = (values[i] + rest[j]).real - known
    return _sort(rest)


def find_eigenvector(orbit: Orbit, multiplier: float) -> Array:
    """Return how an orbit's unknowns (no free parameters) change with the real multiplier nearest to ``multiplier``.

    The largest entry is 1.
    """
    monodromy = linearise_period(orbit)
    if monodromy.size <= 4 * DENSE:
        values, vectors = scipy.linalg.eig(monodromy.to_matrix())
    else:
        start = _start(monodromy.size)
        values, vectors = scipy.sparse.linalg.eigs(_as_operator(monodromy), k=AT_MOST, v0=start, tol=0.0)
    history = vectors[:, np.argmin(np.abs(values - multiplier))].real
    change = monodromy.step(history[:, None])[0][: monodromy.problem.unknowns.size, 0]
    return np.asarray(change / change[np.argmax(np.abs(change))])


class MultiplierCache:
    """Multipliers of orbits, found once for each; the places of a map's entries are kept from one orbit to the next."""

    def __init__(self, n: int | None = None):
        self.n = n
        self._assembly: Assembly | None = None

    def find(self, orbit: Orbit) -> Multipliers:
        """Return the multipliers of an orbit."""

        def find() -> Multipliers:
            monodromy = linearise_period(orbit, self._assembly)
            self._assembly = monodromy.assembly
            return multipliers_of_map(monodromy, orbit, self.n)

        return orbit.once(("multipliers", self.n), find)
