"""The leading Floquet multipliers of a periodic orbit, each corrected, all of them counted.

Those of an orbit that remembers no more than a period are eigenvalues of its map (``stability.eigenpairs``), where it
tells that none is missing. Of longer histories the eigenvalues of the map from one to the next
(``stability.candidates``) are first guesses. Each is corrected on the characteristic matrix (``stability.refinement``),
which drops what is none, and the argument principle counts those outside a circle (``stability.counting``): what the
list lacks is looked for and added, until list and count agree. An orbit without memory beside its states has no more
multipliers than these; where they lie too far apart for its map, a polynomial tells them (``stability.polynomial``).

An autonomous orbit without events has the multiplier 1 of its own flow; it is told from the others as the nearest to 1,
and its distance to 1 measures the error. An orbit with events starts at one, which takes the flow's direction out.

References: Lust, Int. J. Bif. Chaos 11 (2001); Szalai, Stepan, Hogan, SIAM J. Sci. Comput. 28 (2006).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation import refine_evenly
from pddecont.errors import ConvergenceError
from pddecont.orbit import Assembly, Orbit, transfer_orbit
from pddecont.stability.candidates import find_candidates, is_deep, is_mapped_whole
from pddecont.stability.characteristic import Characteristic, MapCharacteristic
from pddecont.stability.counting import Counter
from pddecont.stability.eigenpairs import find_all_outside
from pddecont.stability.essential import find_essential_radius
from pddecont.stability.monodromy import MonodromyOperator, linearise_period
from pddecont.stability.polynomial import find_all_of_states
from pddecont.stability.refinement import SAME, Refined, find_vector, refine

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
# Multipliers below this modulus are left out where nobody says how many are wanted, and all beyond so many.
SMALL = 1e-3
AT_MOST = 12
# So many more are looked for, so that those that are kept end where there is a gap.
MORE = 4
# Multipliers are counted outside a circle that is no larger than this: those near the unit circle count.
NEAR_UNIT = 0.95
# Moduli whose ratio is larger have a gap between them in which a circle finds room; else it lies so far below them all.
WIDE, BELOW = 1.0005, 0.7
# With a long history circles shrink by so much that its earliest part does by this factor, at most by half.
SHRINK = 0.1
# Where counts fail they are asked for on circles wider by this factor.
WIDER = 2.0
# Rounds of counting, finding what is missing, and counting again.
MAX_ROUNDS = 32
# A first guess as near as this to a multiplier, relative to its size, came from a method that knows how often it is
# there.
ACCURATE = 1e-4
# A multiplier outside the unit circle has a modulus above this: rounding may put one of a neutral orbit on either side.
OUTSIDE = 1.0 + 1e-12
# One inside it has a modulus below this.
INSIDE = 1.0 - 1e-12
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
    is ``trivial_error`` (NaN where there is none). ``residuals`` are those of ``values`` in the linearised equations.
    ``spurious`` is the largest modulus of those that belong to the mesh and not to the orbit (long delay lines have
    some; delayed rates have an essential spectrum): they are left out, with all that are no larger. ``counted``: the
    argument principle confirms that none outside the unit circle is missing.
    """

    values: Complex
    nontrivial: Complex
    trivial_error: float = float("nan")
    spurious: float = 0.0
    residuals: Array = field(default_factory=lambda: np.zeros(0))
    counted: bool = True

    @property
    def unreliable(self) -> bool:
        """Whether the orbit's multipliers are lost among those of the mesh, and say nothing of stability."""
        return self.spurious > UNRELIABLE

    @property
    def says_stability(self) -> bool:
        """Whether the multipliers tell if the orbit is stable: they are the orbit's own, and none is missing."""
        return self.counted and not self.unreliable

    @property
    def n_unstable(self) -> int:
        """Number of multipliers outside the unit circle, the trivial one left out."""
        return int(np.sum(np.abs(self.nontrivial) > OUTSIDE))

    @property
    def stable(self) -> bool | None:
        """Whether all but the trivial one lie inside the unit circle.

        None where none lies outside it, but one on it to rounding: the linearised motion does not tell then.
        """
        if self.n_unstable:
            return False
        return True if np.all(np.abs(self.nontrivial) < INSIDE) else None

    def leading(self, n: int | None) -> Multipliers:
        """Return the ``n`` leading ones (None: those beyond ``SMALL``, at most ``AT_MOST``).

        A conjugate pair is not torn apart, and none outside the unit circle is left out.
        """
        kept = self.values[: AT_MOST if n is None else n]
        size = len(kept) if n is not None else max(1, int(np.sum(np.abs(kept) >= SMALL)))
        size = min(len(self.values), max(size, int(np.sum(np.abs(self.values) > OUTSIDE))))
        if 0 < size < len(self.values) and self.values[size - 1].imag > 0.0:
            size += self.values[size] == np.conj(self.values[size - 1])
        kept = self.values[:size]
        nontrivial = kept if np.isnan(self.trivial_error) else remove_known(kept, 1.0)
        return replace(self, values=kept, nontrivial=nontrivial, residuals=self.residuals[:size])


def find_multipliers(orbit: Orbit, n: int | None = None) -> Multipliers:
    """Return the ``n`` leading multipliers of an orbit (None: those beyond ``SMALL``, at most ``AT_MOST``)."""
    return multipliers_of_map(linearise_period(orbit), orbit, n).leading(n)


def multipliers_of_map(monodromy: MonodromyOperator, orbit: Orbit, n: int | None) -> Multipliers:
    """Return all that were found on the way to the ``n`` leading ones, from the orbit's linearised map."""
    wanted, spurious = max(AT_MOST, n or 0), 0.0
    if monodromy.couplings:
        found, spurious, counted = _find_of_lines(monodromy, orbit, wanted)
    else:
        found, counted = _find_leading(monodromy, wanted, SMALL if n is None else 0.0)
    values = np.array([m.value for m in found], dtype=complex)
    residuals = np.array([m.residual for m in found], dtype=float)
    order = _order(values)
    values, residuals = values[order], residuals[order]
    essential = find_essential_radius(orbit)
    if essential > spurious:
        # Rates are read less exactly than values, and some meshes have multipliers of their own.
        own = (np.abs(values) > essential) & _stay(values, orbit, wanted)
        values, residuals, spurious = values[own], residuals[own], essential
    if not orbit.signature.needs_phase_reference:
        return Multipliers(values, values, spurious=spurious, residuals=residuals, counted=counted)
    error = float(np.min(np.abs(values - 1.0))) if len(values) else float("nan")
    return Multipliers(values, remove_known(values, 1.0), error, spurious, residuals, counted)


def _find_leading(monodromy: MonodromyOperator, wanted: int, least: float) -> tuple[list[Refined], bool]:
    """Return at least the ``wanted`` leading multipliers, and whether the count confirms those beyond ``SMALL``.

    First guesses of a modulus below ``least`` are left out.
    """
    if not monodromy.size:
        return [], True
    # Of an orbit that forgets all within a period one multiplier is shown: what is left of 0 is rounding.
    pairs = find_all_outside(monodromy, wanted + MORE, NEAR_UNIT, least)
    if pairs is not None:
        return pairs, True
    characteristic, candidates = monodromy.characteristic, find_candidates(monodromy, wanted + MORE)
    if monodromy.rank is not None and len(candidates):
        pairs = find_all_of_states(characteristic, monodromy.rank, candidates, SMALL, NEAR_UNIT)
        if pairs is not None:
            return pairs, True
    known = _add(characteristic, [], _upper_half(candidates[np.abs(candidates) >= least][: wanted + MORE]))
    known, counted = complete(characteristic, known, wanted, deep=is_deep(monodromy))
    if counted and not known:
        # The orbit forgets all within a period: what is left of a multiplier 0 is rounding.
        known = [
            Refined(v, abs(v), np.zeros(0, dtype=complex), True) for v in candidates[:1].tolist() if abs(v) < SMALL
        ]
    return known, counted


def _find_of_lines(monodromy: MonodromyOperator, orbit: Orbit, wanted: int) -> tuple[list[Refined], float, bool]:
    """Return the leading multipliers of an orbit with delay lines, the largest spurious one, and whether all are there.

    The stages of a long line are far shorter than mesh intervals, and collocation lets their own motions ring on. Such
    multipliers belong to the mesh: on another one they are elsewhere. A map that is not too large has all its
    eigenvalues computed, so that there is nothing to count; of a larger one those outside a circle are counted.
    """
    values = find_candidates(monodromy, wanted)
    stays = _stay(values, orbit, wanted)
    spurious = float(np.max(np.abs(values[~stays]), initial=0.0))
    values = values[stays & (np.abs(values) > spurious)][: wanted + 1]
    if spurious > UNRELIABLE:
        return [Refined(v, float("nan"), np.zeros(0, dtype=complex), True) for v in values.tolist()], spurious, True
    upper = _upper_half(values)
    found = _add(monodromy.characteristic, [], upper)
    if is_mapped_whole(monodromy, wanted) and len(found) == len(upper) + np.sum(upper.imag > 0.0):
        return found, spurious, True
    radius = min(NEAR_UNIT, max(SMALL, BELOW * float(np.min(np.abs(values), initial=np.inf))))
    return found, spurious, _count(Counter(monodromy.characteristic), found, radius) == 0


def _stay(values: Complex, orbit: Orbit, wanted: int) -> NDArray[np.bool_]:
    """Return which multipliers are where they are on a finer mesh too; all, where too long a history tells none."""
    monodromy = linearise_period(transfer_orbit(orbit.with_free(()), refine_evenly(orbit.mesh)))
    other = find_candidates(monodromy, 2 * wanted)
    if not len(other) and is_deep(monodromy):
        return np.ones(len(values), dtype=bool)
    near = [np.min(np.abs(other - v), initial=np.inf) < STAYS * max(1.0, abs(v)) for v in values]
    return np.array(near, dtype=bool)


def complete(
    characteristic: Characteristic, known: list[Refined], wanted: int, *, deep: bool
) -> tuple[list[Refined], bool]:
    """Return a list of multipliers with those that a count shows to be missing, and whether the count agrees at last.

    The circle lies in the gap after the ``wanted`` leading ones. With too few of them it is as small as ``SMALL``, but
    made smaller step by step where nothing is known yet (``deep``). Where counts fail on a small circle they are asked
    for on a larger one, and what lies between the two is left out.
    """
    counter, sure = Counter(characteristic), known
    circles: list[float] = []
    shrink = max(0.5, SHRINK ** (1.0 / max(1, characteristic.depth)))
    radius = NEAR_UNIT / shrink
    for _ in range(MAX_ROUNDS):
        aim = _choose_radius(np.array([abs(m.value) for m in known]), wanted)
        radius = max(aim, shrink * radius) if deep else aim
        missing = _count(counter, known, radius)
        if missing == 0:
            # One that is listed and is none makes up for one that is lacking, but not on the circles between them. What
            # was counted there of the same list holds.
            if known is not sure and any(_count(counter, known, circle) != 0 for circle in circles):
                break
            circles, sure = [*circles, radius], known
            if radius == aim:
                return known, True
            continue
        found = len(known)
        if missing is not None and missing > 0:
            known = _add(characteristic, known, _find_missing(counter, known, radius))
        elif missing is not None:
            known = _drop_repeated(known)
        if len(known) == found:
            break
    while not circles and radius < NEAR_UNIT:
        # Farther out counts are easier, and fewer multipliers are left.
        radius = min(WIDER * radius, NEAR_UNIT)
        if _count(counter, known, radius) == 0:
            circles, sure = [radius], known
    return [m for m in sure if abs(m.value) > min(circles)] if circles else known, bool(circles)


def _choose_radius(moduli: Array, wanted: int) -> float:
    """Return the radius of a circle in the widest gap soon after the leading multipliers."""
    if len(moduli) < wanted:
        return SMALL
    ends = np.sort(moduli)[::-1][wanted - 1 : wanted + 2 * MORE]
    if ends[0] < WIDE * ends[-1]:
        ends = np.append(ends, BELOW * ends[-1])
    gap = int(np.argmax(ends[:-1] / ends[1:]))
    return float(np.clip(np.sqrt(ends[gap] * ends[gap + 1]), SMALL, NEAR_UNIT))


def _list_values(known: Iterable[Refined]) -> Complex:
    return np.array([m.value for m in known], dtype=complex)


def _count(counter: Counter, known: list[Refined], radius: float) -> int | None:
    try:
        return counter.count_missing(_list_values(known), radius)
    except ConvergenceError:
        return None


def _find_missing(counter: Counter, known: list[Refined], radius: float) -> Complex:
    try:
        return counter.find_missing(_list_values(known), radius)
    except ConvergenceError:
        return np.zeros(0, dtype=complex)


def _upper_half(values: Complex) -> Complex:
    return values[values.imag >= 0.0]


def _add(characteristic: Characteristic, known: list[Refined], candidates: Complex) -> list[Refined]:
    """Return ``known`` with the multipliers near ``candidates`` (upper half plane) that are not among them yet."""
    result = list(known)
    for value in candidates.tolist():
        found = refine(characteristic, value)
        # A guess from afar may lead to one that is listed; one that lay there from the start is another one like it.
        came_from_afar = found is None or abs(found.value - value) > ACCURATE * abs(value)
        if found is None or (came_from_afar and any(_are_same(found, other) for other in result)):
            continue
        result.append(found)
        if found.value.imag != 0.0:
            result.append(replace(found, value=found.value.conjugate()))
    return result


def _drop_repeated(known: list[Refined]) -> list[Refined]:
    """Return a list without one that is in it twice, and its conjugate."""
    for i, m in enumerate(known):
        if any(_are_same(m, other) for other in known[:i]):
            gone = i
            if m.value.imag:
                gone = next(k for k, other in enumerate(known) if other.value == m.value.conjugate())
            return [other for k, other in enumerate(known) if k not in (i, gone)]
    return known


def _are_same(a: Refined, b: Refined) -> bool:
    return abs(a.value - b.value) < SAME * abs(a.value)


def _order(values: Complex) -> NDArray[np.intp]:
    """Return the order by falling modulus; of a conjugate pair the upper one comes first."""
    first = np.lexsort((-values.imag, -values.real))
    return np.asarray(first[np.argsort(-np.round(np.abs(values[first]), 12), kind="stable")])


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
    return np.asarray(rest[_order(rest)])


def find_eigenvector(orbit: Orbit, multiplier: float) -> Array:
    """Return how an orbit's unknowns (no free parameters) change with the real multiplier nearest to ``multiplier``.

    The largest entry is 1.
    """
    monodromy = linearise_period(orbit)
    vector = find_vector(monodromy.characteristic, multiplier)
    if isinstance(monodromy.characteristic, MapCharacteristic):
        change = monodromy.step((vector * monodromy.history_sizes)[:, None])[0][:, 0]
    else:
        change = vector * monodromy.sizes
    change = change[: monodromy.problem.unknowns.size]
    return np.asarray(change / change[np.argmax(np.abs(change))])


class MultiplierCache:
    """Multipliers of orbits, found once for each; the places of a map's entries are kept from one orbit to the next.

    As many are found whatever the number ``n`` of those that are shown, down to ``AT_MOST``.
    """

    def __init__(self, n: int | None = None):
        self.n = n
        self._places: Assembly | None = None

    def find(self, orbit: Orbit) -> Multipliers:
        """Return the multipliers of an orbit."""

        def find() -> Multipliers:
            monodromy = linearise_period(orbit, self._places)
            self._places = monodromy.assembly
            found = multipliers_of_map(monodromy, orbit, self.n)
            return found.leading(None if self.n is None else max(self.n, AT_MOST))

        return orbit.once(("multipliers", self.n), find)
