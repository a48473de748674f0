"""Which mesh an orbit gets: pieces between breaking points, and whether a mesh still holds and is fine enough."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation import (
    MAX_INTERVALS,
    BreakingTime,
    Density,
    Mesh,
    MeshRule,
    Piece,
    cut_pieces,
    equal_cuts,
    interval_density,
    share_intervals,
    transfer,
)
from pddecont.delay import MERGE, BreakingPoint, DiscontinuitySources, TrackedPoints, find_breaking_points
from pddecont.errors import ConvergenceError
from pddecont.orbit.error import estimate_interval_errors
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.preimages import PreimageSearch
from pddecont.orbit.problem import OrbitProblem
from pddecont.orbit.residual import group_by_mode

Array = NDArray[np.float64]
# Under this name a mesh knows whether no two of the breaking points that it was made for count as one.
DISTINCT = "breaking points are distinct"


@dataclass(frozen=True, eq=False)
class Pieces:
    """The smooth parts of an orbit, not yet cut, at ``theta``, which holds the ``breaking`` times too.

    ``distinct``: they are all known from sums of delays after events, no two of which count as one.
    """

    pieces: list[Piece]
    theta: Array
    breaking: tuple[BreakingTime, ...] = ()
    distinct: bool = False


def find_pieces(problem: OrbitProblem, theta: Array, degree: int, orbit: Orbit | None = None) -> Pieces:
    """Return the pieces that the mesh of an orbit has at ``theta``, in order of time.

    Breaking points behind delays that vary are found on ``orbit``, and left out without one. An orbit of the problem at
    ``theta`` has those of its mesh, as long as they are in their order.
    """
    own = orbit is not None and orbit.problem is problem and orbit.theta is theta and orbit.mesh.degree == degree
    if own and orbit is not None and keeps_its_order(orbit):
        return Pieces(list(orbit.mesh.pieces), theta, distinct=True)
    sources, n = _find_sources(problem), len(problem.signature)
    theta = theta[: n + len(problem.numeric.model.delays)]
    if orbit is None or sources.are_sums or not problem.signature.has_events:
        points = find_breaking_points(sources, theta, n, degree)
        return Pieces(_join(points.by_segment), theta, distinct=points.distinct)
    orbit = _unfold(orbit, theta)
    found = TrackedPoints(sources, theta, n, degree, PreimageSearch(orbit).find, find_fading(orbit, sources))
    times = found.list_breaking_times()
    return Pieces(_join(found.list_points()), np.concatenate([theta, found.breaking_times]), times)


def _find_sources(problem: OrbitProblem) -> DiscontinuitySources:
    """Return the sources of the breaking points that a problem's meshes have."""
    sources = problem.signature.discontinuity_sources
    return sources if problem.delay.tracks_breaking_points else replace(sources, delays=(), varying=(), gains={})


def breaking_times_vary(problem: OrbitProblem) -> bool:
    """Return whether a problem's meshes have breaking times that are found on an orbit alone."""
    return problem.signature.has_events and bool(_find_sources(problem).varying)


def _unfold(orbit: Orbit, theta: Array) -> Orbit:
    """Return an orbit whose breaking points have passed one another on a mesh of segments, where they are in order."""
    mesh, n = orbit.mesh, len(orbit.signature)
    if np.all(mesh.length @ orbit.theta > 0.0):
        return orbit
    ends = np.concatenate([np.tri(n + 1, n, -1), np.zeros((n + 1, len(theta) - n))], axis=1)
    cuts = equal_cuts(share_intervals(theta[:n], max(mesh.n_intervals, n)))
    bare = Mesh(mesh.degree, n, tuple(Piece(s, ends[s], ends[s + 1], cuts[s]) for s in range(n)), theta)
    values = transfer(mesh, orbit.theta, orbit.values, bare, theta)
    problem = replace(orbit.problem, mesh=bare, reference=None)
    return Orbit(problem, problem.unknowns.join(values, orbit.durations, orbit.start, orbit.free))


def _join(points: list[list[BreakingPoint]]) -> list[Piece]:
    whole = np.array([0.0, 1.0])
    return [
        Piece(s, np.array(a.coefficients, dtype=float), np.array(b.coefficients, dtype=float), whole)
        for s, inside in enumerate(points)
        for a, b in pairwise(inside)
    ]


def find_fading(orbit: Orbit, sources: DiscontinuitySources) -> dict[int, float]:
    """Return by how much jumps shrink, at most, where rates of each delay read them on an orbit."""
    problem, model, mesh = orbit.problem, orbit.numeric.model, orbit.mesh
    sizes = {k: 0.0 for k, gain in sources.gains.items() if gain < 1}
    if not sizes:
        return sizes
    # The mesh may read nothing any more of what it was made to read.
    reads = orbit.read(mesh.grid(mesh.basis.nodes))
    for mode, points in group_by_mode(problem):
        function = problem.numeric.mode(mode)
        d = function.derivatives(reads.t[points], reads.x[:, points], reads.xd[:, points], orbit.parameters)
        for q, slope in zip(function.structure().dxd[1], d.dxd, strict=True):
            read = model.delayed[q] if q < len(model.delayed) else None
            if read is not None and read.delay in sizes and read.derivative:
                sizes[read.delay] = max(sizes[read.delay], float(np.max(np.abs(slope), initial=0.0)))
    return sizes


def make_mesh(
    problem: OrbitProblem, theta: Array, rule: MeshRule, density: Density | None = None, orbit: Orbit | None = None
) -> Mesh:
    """Return the mesh of ``rule`` at ``theta``; ``density`` is where an earlier solution wants its intervals.

    ``orbit`` is where breaking points behind delays that vary are found.
    """
    found = find_pieces(problem, theta, rule.degree, orbit)
    pieces = cut_pieces(found.pieces, found.theta, rule, density)
    mesh = Mesh(rule.degree, len(problem.signature), tuple(pieces), found.theta.copy(), found.breaking)
    mesh.take_layout(problem.mesh)
    if problem.delay.tracks_breaking_points:
        # Of another mesh this is found where it is asked for: its pieces are those of another way.
        mesh.once(DISTINCT, lambda: found.distinct)
    return mesh


def find_density(orbit: Orbit, tol: float) -> Density:
    """Return the intervals that an orbit wants for the error ``tol``."""
    return interval_density(orbit.mesh, orbit.theta, estimate_interval_errors(orbit), tol)


def mesh_is_valid(orbit: Orbit) -> bool:
    """Return whether the mesh's breaking points are in their order at the orbit, and reads still in their intervals."""
    if orbit.numeric.model.varying:
        # What a mesh reads is known where it has the breaking points that depend on it.
        return keeps_its_pieces(orbit) and _reads_in_place(orbit)
    # Reads leave their intervals more often than breaking points their order, and are looked at in less time.
    return _reads_in_place(orbit) and keeps_its_pieces(orbit)


def keeps_its_pieces(orbit: Orbit) -> bool:
    """Return whether the mesh's breaking points are those of the orbit, in their order."""
    return orbit.once("keeps its pieces", lambda: _keeps_its_pieces(orbit))


def _keeps_its_pieces(orbit: Orbit) -> bool:
    mesh = orbit.mesh
    # A first mesh of delays that vary knows nothing of what they read.
    if orbit.numeric.model.varying and mesh.reference_lags is None:
        return False
    try:
        if _breaking_times_are_known(orbit) or keeps_its_order(orbit):
            return True
        now = find_pieces(orbit.problem, orbit.theta, mesh.degree, orbit)
    except ConvergenceError:
        return False
    if not _are_same(now.pieces, mesh.pieces):
        return False
    return all(np.array_equal(a.source, b.source) for a, b in zip(now.breaking, mesh.breaking, strict=True))


def _reads_in_place(orbit: Orbit) -> bool:
    """Return whether what equations read of the past is still in the intervals that they read."""
    try:
        varying = orbit.equation_reads.lags if orbit.numeric.model.varying else np.zeros((0, 0))
    except ConvergenceError:
        return False
    return orbit.problem.delay.mesh_is_valid(orbit.mesh, orbit.theta, orbit.problem.lags, varying)


def anchor_mesh(orbit: Orbit) -> Orbit:
    """Return an orbit on its own mesh, whose breaking points it keeps, reading the past where it lies now."""
    mesh = orbit.mesh.anchor(orbit.theta)
    if keeps_its_order(orbit):
        mesh.once(DISTINCT, lambda: True)
    return settle_reads(Orbit(replace(orbit.problem, mesh=mesh), orbit.x))


def _are_same(pieces: Sequence[Piece], others: Sequence[Piece]) -> bool:
    """Return whether two lists of pieces begin and end at the same times, their cuts left aside."""
    return len(pieces) == len(others) and all(
        a.segment == b.segment and np.array_equal(a.start, b.start) and np.array_equal(a.end, b.end)
        for a, b in zip(pieces, others, strict=True)
    )


def keeps_its_order(orbit: Orbit) -> bool:
    """Return whether an orbit's breaking points, sums of delays after events, are the mesh's edges in their order.

    Where all of them are edges, none of two that count as one, and their order is still that of the mesh, none has
    passed an event, and there are no others. False says that they have to be found to know.
    """
    return orbit.once("keeps its order", lambda: _keeps_its_order(orbit))


def _keeps_its_order(orbit: Orbit) -> bool:
    mesh, sources, theta = orbit.mesh, orbit.signature.discontinuity_sources, orbit.theta
    made_for, n = mesh.reference_theta, mesh.n_segments
    if made_for is None or not sources.are_sums or not orbit.problem.delay.tracks_breaking_points:
        return False

    def are_distinct() -> bool:
        found = find_pieces(orbit.problem, made_for, mesh.degree)
        return found.distinct and _are_same(found.pieces, mesh.pieces)

    if not mesh.once(DISTINCT, are_distinct):
        return False
    near, delays = MERGE * orbit.period, n + np.array(sources.delays, dtype=np.intp)
    as_before = (theta[delays] > near) == (made_for[delays] > MERGE * np.sum(made_for[:n]))
    return bool(np.all(mesh.piece_lengths @ theta > near) and np.all(as_before))


def _breaking_times_are_known(orbit: Orbit) -> bool:
    """Return whether an orbit with delays that vary has its mesh edges in order, and no breaking time beside them.

    False says that they have to be found to know.
    """
    mesh, sources = orbit.mesh, orbit.signature.discontinuity_sources
    if not sources.varying or not mesh.breaking or sources.delays or min(sources.gains.values(), default=1) < 1:
        return False
    if not np.all(mesh.length @ orbit.theta > 0.0):
        return False
    edges = np.array([piece.start @ orbit.theta for piece in mesh.pieces] + [orbit.period])
    search = PreimageSearch(orbit)
    reached = [b.level for b in mesh.breaking]
    moments = [*zip(sources.jumps, orbit.event_times[1:], strict=True), *zip(reached, orbit.breaking, strict=True)]
    early = np.array([time for level, time in moments if level < mesh.degree])
    return not any(search.crosses_anew(k, early, edges) for k in sources.varying)


def mesh_meets_tolerance(orbit: Orbit, tol: float | None) -> bool:
    """Return whether the mesh's intervals keep a tolerance (always, where there is none)."""
    if tol is None or orbit.mesh.n_intervals >= MAX_INTERVALS:
        return True
    return float(np.max(estimate_interval_errors(orbit))) <= tol


def transfer_orbit(orbit: Orbit, mesh: Mesh) -> Orbit:
    """Return an orbit on another mesh, its own values as the reference of its phase."""
    return transfer_to(orbit, orbit.problem, mesh)


def transfer_to(orbit: Orbit, problem: OrbitProblem, mesh: Mesh) -> Orbit:
    """Return an orbit on another mesh as a guess of the same problem's at other parameters."""
    theta = _find_theta(orbit if problem is orbit.problem else Orbit(problem, orbit.x), mesh)
    moved = transfer(orbit.mesh, orbit.theta, orbit.values, mesh, theta)
    new = replace(problem, mesh=mesh, reference=None if problem.reference is None else moved)
    return settle_reads(Orbit(new, new.unknowns.join(moved, orbit.durations, orbit.start, orbit.free)))


def _find_theta(guess: Orbit, mesh: Mesh) -> Array:
    """Return theta of a guess with the breaking times of another mesh."""
    known = guess.mesh.n_segments + len(guess.numeric.model.delays)
    return np.concatenate([guess.theta[:known], mesh.reference_breaking])


def settle_reads(orbit: Orbit) -> Orbit:
    """Return an orbit whose mesh knows what delays that vary read there, where it does not yet."""
    mesh = orbit.mesh
    if not orbit.numeric.model.varying or mesh.reference_lags is not None:
        return orbit
    assert mesh.reference_theta is not None, "a mesh that reads the past is made for a theta"
    settled = mesh.anchor(mesh.reference_theta, orbit.read(mesh.equation_points, integrals=False).lags)
    return Orbit(replace(orbit.problem, mesh=settled), orbit.x)


def adapt_mesh(orbit: Orbit, rule: MeshRule) -> Orbit:
    """Return an orbit on the mesh of ``rule`` for it, as a guess."""
    density = None if rule.tol is None else find_density(orbit, rule.tol)
    return transfer_orbit(orbit, make_mesh(orbit.problem, orbit.theta, rule, density, orbit))
