"""Which mesh an orbit gets: pieces between breaking points, and whether a mesh still holds and is fine enough."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation import MAX_INTERVALS, Density, Mesh, MeshRule, Piece, cut_pieces, interval_density, transfer
from pddecont.delay import find_breaking_points
from pddecont.orbit.error import estimate_interval_errors
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.problem import OrbitProblem

Array = NDArray[np.float64]


def find_pieces(problem: OrbitProblem, theta: Array, degree: int) -> list[Piece]:
    """Return the pieces, not yet cut, that the mesh of an orbit has at ``theta``, in order of time."""
    sources = problem.signature.discontinuity_sources
    if not problem.delay.tracks_breaking_points:
        sources = replace(sources, delays=())
    points = find_breaking_points(sources, theta, len(problem.signature), degree)
    whole = np.array([0.0, 1.0])
    return [
        Piece(s, np.array(a.coefficients, dtype=float), np.array(b.coefficients, dtype=float), whole)
        for s, inside in enumerate(points)
        for a, b in pairwise(inside)
    ]


def make_mesh(problem: OrbitProblem, theta: Array, rule: MeshRule, density: Density | None = None) -> Mesh:
    """Return the mesh of ``rule`` at ``theta``; ``density`` is where an earlier solution wants its intervals."""
    pieces = cut_pieces(find_pieces(problem, theta, rule.degree), theta, rule, density)
    return Mesh(rule.degree, len(problem.signature), tuple(pieces), theta.copy())


def find_density(orbit: Orbit, tol: float) -> Density:
    """Return the intervals that an orbit wants for the error ``tol``."""
    return interval_density(orbit.mesh, orbit.theta, estimate_interval_errors(orbit), tol)


def mesh_is_valid(orbit: Orbit) -> bool:
    """Return whether the mesh's breaking points are in their order at the orbit, and reads still in their intervals."""
    mesh, theta = orbit.mesh, orbit.theta
    now = find_pieces(orbit.problem, theta, mesh.degree)
    if len(now) != len(mesh.pieces):
        return False
    for piece, own in zip(now, mesh.pieces, strict=True):
        same_ends = np.array_equal(piece.start, own.start) and np.array_equal(piece.end, own.end)
        if piece.segment != own.segment or not same_ends:
            return False
    return orbit.problem.delay.mesh_is_valid(mesh, theta, orbit.problem.lags)


def mesh_meets_tolerance(orbit: Orbit, rule: MeshRule) -> bool:
    """Return whether the mesh keeps the rule's tolerance (always, if the rule fixes the number of intervals)."""
    if rule.tol is None or orbit.mesh.n_intervals >= MAX_INTERVALS:
        return True
    return float(np.max(estimate_interval_errors(orbit))) <= rule.tol


def transfer_orbit(orbit: Orbit, mesh: Mesh) -> Orbit:
    """Return an orbit on another mesh, its own values as the reference of its phase."""
    return transfer_to(orbit, orbit.problem, mesh)


def transfer_to(orbit: Orbit, problem: OrbitProblem, mesh: Mesh) -> Orbit:
    """Return an orbit on another mesh as a guess of the same problem's at other parameters."""
    guess = Orbit(problem, orbit.x)
    moved = transfer(orbit.mesh, orbit.theta, orbit.values, mesh, guess.theta)
    new = replace(problem, mesh=mesh, reference=None if problem.reference is None else moved)
    return Orbit(new, new.unknowns.join(moved, orbit.durations, orbit.start, orbit.free))


def adapt_mesh(orbit: Orbit, rule: MeshRule) -> Orbit:
    """Return an orbit on the mesh of ``rule`` for it, as a guess."""
    density = None if rule.tol is None else find_density(orbit, rule.tol)
    return transfer_orbit(orbit, make_mesh(orbit.problem, orbit.theta, rule, density))
