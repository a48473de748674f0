"""Period doubling (PD): a multiplier is -1.

The eigenvector of -1 alternates from period to period, so the orbit taken twice plus and minus a little of it is a
first guess of the doubled orbit. The other way round, a branch of doubled orbits meets the single one where its two
halves become equal.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pddecont.bifurcation.branch_start import BranchStart, find_forward_tangent
from pddecont.bifurcation.extended_system import DefiningFunction, solve_special_orbit
from pddecont.bifurcation.kinds import OrbitTest, SpecialPointKind
from pddecont.bifurcation.settings import BranchSettings
from pddecont.collocation import MeshRule
from pddecont.continuation import BranchPoint, BranchState, CurvePoint, End, Scaling, TestFunction
from pddecont.errors import ConvergenceError
from pddecont.orbit import (
    Orbit,
    OrbitEvaluation,
    PeriodicOrbitSystem,
    SegmentSpan,
    resegment,
    sample_spans,
    solve_orbit,
)
from pddecont.reasons import Reason, make_reason
from pddecont.stability import MultiplierCache, Multipliers, find_eigenvector, remove_known

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
LABEL = "PD"
HALVES_EQUAL = "halves_equal"
# Halves that differ by less than this, relative to the orbit's size, are equal.
EQUAL = 1e-5
# Multipliers this near to -1 enter the defining function, so that it stays smooth when they meet.
NEAR = 0.3
# The cosine beyond which the differences of halves at two points count as opposite.
OPPOSITE = 0.8
# How many times the difference of the halves a single orbit may lie away, in scaled unknowns, and still be met.
FAR = 3.0


def measure_distance(m: Multipliers) -> float:
    """Return the distance to -1 of the real multiplier nearest to it, with the sign of the parity of those beyond."""
    real = m.nontrivial[m.nontrivial.imag == 0.0].real
    if not len(real):
        return float("nan")
    return float((-1.0) ** np.sum(real < -1.0) * np.min(np.abs(real + 1.0)))


@dataclass(frozen=True, eq=False)
class DoublingFunction:
    """The product of 1 + mu over the ``n`` multipliers nearest to -1."""

    multipliers: MultiplierCache
    n: int = 1
    kind: str = LABEL

    def evaluate(self, at: OrbitEvaluation) -> float:
        """Return the product at an orbit; NaN if it has no multipliers."""
        values = self.multipliers.find(at.orbit).nontrivial
        nearest = values[np.argsort(np.abs(values + 1.0))][: self.n]
        return float(np.prod(1.0 + nearest).real) if len(nearest) else float("nan")

    def update_at(self, at: OrbitEvaluation) -> DoublingFunction:
        """Return the same function over the multipliers that are near -1 at an orbit."""
        values = self.multipliers.find(at.orbit).nontrivial
        return replace(self, n=max(1, int(np.sum(np.abs(values + 1.0) < NEAR))))


def guess_doubled_orbit(orbit: Orbit, rule: MeshRule) -> tuple[Orbit, Array]:
    """Return an orbit taken twice, and the direction in its unknowns in which the doubled orbits leave it."""
    bare = orbit.with_free(())
    ends, period = bare.event_times, bare.period
    spans = [
        SegmentSpan(segment, k * period + ends[s], k * period + ends[s + 1])
        for k in (0, 1)
        for s, segment in enumerate(bare.signature.segments)
    ]
    if not bare.signature.has_events:
        spans = [SegmentSpan(bare.signature.segments[0], 0.0, 2 * period)]
    twice = resegment(bare, spans, rule, 2 * bare.problem.n_periods)
    change = Orbit(bare.problem, find_eigenvector(bare, -1.0))
    unknowns, mesh = twice.problem.unknowns, twice.mesh
    direction = np.zeros(unknowns.size)
    sign = np.where(mesh.base_times(twice.theta) < period * (1.0 - 1e-12), 1.0, -1.0)
    if len(spans) > 1:
        first_half = mesh.first_base[len(bare.durations)]
        sign = np.repeat([1.0, -1.0], [first_half, mesh.n_base - first_half])
        direction[unknowns.durations] = np.concatenate([change.durations, -change.durations])
    sampled = sample_spans(bare, change.values, spans, mesh, twice.theta)
    direction[unknowns.values] = (sign[:, None] * sampled).ravel()
    direction[unknowns.start] = change.start
    return twice, direction


def compare_halves(orbit: Orbit, scaling: Scaling) -> Array:
    """Return what differs between an orbit's two halves, relative to its size.

    It is zero on a single orbit taken twice, and empty if it cannot be one.
    """
    unknowns, signature = orbit.problem.unknowns, orbit.signature
    sizes, period = scaling.scale[unknowns.value_index[0]], scaling.scale[unknowns.durations.start]
    if signature.numeric.model.forced and orbit.problem.n_periods % 2:
        return np.zeros(0)
    if not signature.has_events:
        points, _ = orbit.mesh.locate(orbit.theta, orbit.period * np.array([0.0, 0.25, 0.5, 0.75]))
        z = orbit.mesh.interpolate(orbit.values, points)
        result: Array = ((z[:2] - z[2:]) / sizes).ravel()
        return result
    names, durations = signature.names, orbit.durations
    half = len(names) // 2
    if len(names) % 2 or names[:half] != names[half:]:
        return np.zeros(0)
    starts = orbit.values[orbit.mesh.first_base]
    times, states = (durations[:half] - durations[half:]) / period, (starts[:half] - starts[half:]) / sizes
    return np.concatenate([times, states.ravel()])


def has_equal_halves(orbit: Orbit, scaling: Scaling) -> bool:
    """Return whether an orbit is a single one taken twice."""
    difference = compare_halves(orbit, scaling)
    return len(difference) > 0 and float(np.max(np.abs(difference))) < EQUAL


def guess_halved_orbit(orbit: Orbit, rule: MeshRule) -> Orbit:
    """Return the mean of an orbit's two halves as an orbit of its own."""
    bare = orbit.with_free(())
    ends, segments, durations = bare.event_times, bare.signature.segments, bare.durations
    half = len(segments) // 2
    if not bare.signature.has_events:
        halves = [[SegmentSpan(segments[0], k * ends[-1] / 2, (k + 1) * ends[-1] / 2)] for k in (0, 1)]
    else:
        halves = [
            [SegmentSpan(segments[s], ends[s], ends[s + 1]) for s in range(k * half, (k + 1) * half)] for k in (0, 1)
        ]
    single = resegment(bare, halves[0], rule, max(1, bare.problem.n_periods // 2))
    unknowns, guess = single.problem.unknowns, single.x.copy()
    one, other = (sample_spans(bare, bare.values, spans, single.mesh, single.theta) for spans in halves)
    guess[unknowns.values] = 0.5 * (one + other).ravel()
    if bare.signature.has_events:
        guess[unknowns.durations] = 0.5 * (durations[:half] + durations[half:])
        # The second half begins half of all forcing periods later, but for what differs.
        guess[unknowns.start] = bare.start + 0.5 * (ends[half] - 0.5 * ends[-1])
    return Orbit(single.problem, guess).with_phase_reference()


def find_single_orbit(
    a: CurvePoint[OrbitEvaluation], b: CurvePoint[OrbitEvaluation], rule: MeshRule, multipliers: MultiplierCache
) -> CurvePoint[OrbitEvaluation] | None:
    """Return the single orbit with multiplier -1 onto which a branch of doubled orbits falls between ``a`` and ``b``.

    Return None if it does not: there all that differs between the halves of ``a`` differs the other way in ``b``, or no
    longer.
    """
    before = compare_halves(a.at.orbit, a.system.scaling)
    after = compare_halves(b.at.orbit, b.system.scaling)
    least = b if np.linalg.norm(after) < np.linalg.norm(before) else a
    fell = float(np.max(np.abs(after))) < EQUAL
    if not fell and before @ after > -OPPOSITE * np.linalg.norm(before) * np.linalg.norm(after):
        return None
    try:
        single = solve_orbit(guess_halved_orbit(least.at.orbit, rule), rule).at.orbit.with_free(a.at.orbit.problem.free)
        system = PeriodicOrbitSystem(single.problem, a.at.system.sizes, rule)
        special, solution = solve_special_orbit(system, single.x, DoublingFunction(multipliers))
    except ConvergenceError:
        return None
    index = special.mesh_independent_index
    moved = solution.x[index] - single.x[system.mesh_independent_index]
    if np.max(np.abs(moved) / special.scaling.scale[index]) > FAR * float(np.max(np.abs(before))) + EQUAL:
        return None
    found = solution.at.inner
    return CurvePoint(special.inner, found, solution, find_forward_tangent(special.inner, found))


def _branch_tests(at: OrbitEvaluation, settings: BranchSettings) -> list[OrbitTest]:
    """Return the test for a doubled orbit that falls onto the single one.

    What differs most between its halves changes sign.
    """
    difference = compare_halves(at.orbit, at.system.scaling)
    if not len(difference) or not np.any(difference):
        return []
    most = int(np.argmax(np.abs(difference)))

    def value(point: CurvePoint[OrbitEvaluation]) -> float:
        # Near the single orbit a step may land on it: no difference is left, and no sign of it can be trusted.
        if has_equal_halves(point.at.orbit, point.system.scaling):
            return 0.0
        return float(compare_halves(point.at.orbit, point.system.scaling)[most])

    def find_meeting(
        a: CurvePoint[OrbitEvaluation], b: CurvePoint[OrbitEvaluation]
    ) -> CurvePoint[OrbitEvaluation] | None:
        return find_single_orbit(a, b, settings.rule, settings.find_multipliers())

    return [TestFunction(LABEL, value, End.SPECIAL, make_reason(HALVES_EQUAL), find_meeting)]


def _define(at: OrbitEvaluation, settings: BranchSettings, reason: Reason) -> DefiningFunction:
    return DoublingFunction(settings.find_multipliers()).update_at(at)


def _switch(orbit: Orbit, tangent: Array, settings: BranchSettings) -> BranchStart:
    """Return the doubled orbits' branch; it goes on as its own mirror image, so one way is all of it."""
    # Taken twice the orbit has the multiplier +1, so it is solved for before, and again when the branch has left it.
    twice, direction = guess_doubled_orbit(solve_orbit(orbit, settings.rule).at.orbit, settings.rule)
    system, start = settings.make_system(twice)
    along = system.scaling.normalise(np.append(direction, np.zeros(len(settings.free))))
    return BranchStart(CurvePoint(system, system.at(start.x), None, along), one_way=True)


def _go_on(
    last: BranchPoint[OrbitEvaluation], before: BranchState[OrbitEvaluation], settings: BranchSettings
) -> CurvePoint[OrbitEvaluation]:
    """Return the single orbit onto which the branch fell, on the way that the parameter went."""
    forward = np.sign(before.tangent[before.point.at.orbit.problem.unknowns.free.start]) or 1.0
    point = last.state.point
    free = point.at.orbit.problem.unknowns.free.start
    return replace(point, direction=point.tangent * forward * np.sign(point.tangent[free]))


def _remove_critical(m: Multipliers) -> Complex:
    return remove_known(m.nontrivial, -1.0)


PERIOD_DOUBLING = SpecialPointKind(
    LABEL,
    "period doubling",
    on_branches=True,
    branch_tests=_branch_tests,
    define=_define,
    good_side=lambda _: 1.0,
    crossings=("FF", "R2", "PT"),
    remove_critical=_remove_critical,
    switch=_switch,
    go_on=_go_on,
)
