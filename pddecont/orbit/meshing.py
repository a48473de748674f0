"""Which mesh an orbit gets: pieces between breaking points, and how many intervals in each.

With a fixed number the intervals go where pieces are longest. With a tolerance each piece is cut so that every interval leaves
the same error: an interval of length h with estimate e has the density (e / tol)^(1/(m+1)) / h, whose integral over a piece is
the number of intervals that it needs and whose equal shares are their ends.

Reference: Ascher, Mattheij, Russell (1995), section 9.1.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pddecont.delay.direct import Direct, anchored, locate
from pddecont.orbit.breaking import Edge, echoes, edges
from pddecont.orbit.error import interval_errors
from pddecont.orbit.mesh import Mesh, Piece, Places, equal_cuts, share_intervals
from pddecont.orbit.problem import OrbitProblem

Array = NDArray[np.float64]
SAFETY = 0.3
MAX_INTERVALS = 5000
BEYOND = 0.5


@dataclass(frozen=True)
class MeshRule:
    """How meshes are made: polynomials of ``degree``, ``intervals`` of them or an error ``tol`` relative to the orbit's size."""

    degree: int
    intervals: int | None = None
    tol: float | None = None


def pieces_at(problem: OrbitProblem, theta: Array, degree: int) -> list[tuple[int, Edge, Edge]]:
    """Return the pieces that the mesh of an orbit has at ``theta``: (segment, start, end), in order of time."""
    pattern = echoes(problem.numeric, problem.segments)
    if not (isinstance(problem.delay, Direct) and problem.delay.track):
        pattern = replace(pattern, delays=())
    return [(s, a, b) for s, points in enumerate(edges(pattern, theta, len(problem.segments), degree))
            for a, b in pairwise(points)]  # fmt: skip


def new_mesh(problem: OrbitProblem, theta: Array, rule: MeshRule, density: Density | None = None) -> Mesh:
    """Return the mesh of ``rule`` at ``theta``; ``density`` is where an earlier solution wants its intervals."""
    pieces = pieces_at(problem, theta, rule.degree)
    starts = np.array([a.coefficients for _, a, _ in pieces], dtype=float)
    ends = np.array([b.coefficients for _, _, b in pieces], dtype=float)
    lengths = (ends - starts) @ theta
    if rule.intervals is not None:
        cuts = equal_cuts(share_intervals(lengths, max(rule.intervals, len(pieces))))
    elif density is None:
        # First try: a piece gets intervals in proportion to its length, enough to see the orbit's shape.
        cuts = equal_cuts(share_intervals(lengths, max(12, len(pieces))))
    else:
        cuts = [density.cuts(a, b) for a, b in zip(starts @ theta, ends @ theta, strict=True)]
    made = tuple(Piece(s, a, b, c) for (s, _, _), a, b, c in zip(pieces, starts, ends, cuts, strict=True))
    return Mesh(rule.degree, len(problem.segments), made, theta.copy())


@dataclass(frozen=True, eq=False)
class Density:
    """Intervals wanted in each unit of time: constant between ``edges`` (n + 1,), of height ``heights`` (n,)."""

    edges: Array
    heights: Array

    def cuts(self, start: float, end: float) -> Array:
        """Return the cuts of a piece from ``start`` to ``end``, as fractions."""
        inside = (self.edges > start) & (self.edges < end)
        grid = np.concatenate([[start], self.edges[inside], [end]])
        middle = 0.5 * (grid[1:] + grid[:-1])
        heights = self.heights[np.clip(np.searchsorted(self.edges, middle) - 1, 0, len(self.heights) - 1)]
        total = np.concatenate([[0.0], np.cumsum(heights * np.diff(grid))])
        n = int(np.clip(np.ceil(total[-1]), 1, MAX_INTERVALS))
        if n == 1 or total[-1] == 0.0:
            return np.array([0.0, 1.0])
        cuts = (np.interp(np.linspace(0.0, total[-1], n + 1), total, grid) - start) / (end - start)
        cuts[0], cuts[-1] = 0.0, 1.0
        return cuts


def density_of(problem: OrbitProblem, x: Array, rule: MeshRule) -> Density:
    """Return the intervals that the orbit ``x`` wants for the rule's tolerance."""
    assert rule.tol is not None
    mesh = problem.mesh
    theta = problem.theta(x)
    h = mesh.length @ theta
    errors = np.maximum(interval_errors(problem, x), 1e-18)
    wanted = (errors / (SAFETY * rule.tol)) ** (1.0 / (mesh.degree + 1))
    # A first mesh may be far too coarse to trust its estimate: grow and shrink by limited factors.
    heights = np.clip(wanted, 0.2, 8.0) / h
    start = mesh.start @ theta
    return Density(np.append(start, start[-1] + h[-1]), heights)


def fits(problem: OrbitProblem, x: Array) -> bool:
    """Whether the mesh's breaking points are in the order that they have at ``x``, and reads still in their intervals."""
    mesh = problem.mesh
    theta = problem.theta(x)
    now = pieces_at(problem, theta, mesh.degree)
    if len(now) != len(mesh.pieces):
        return False
    for (s, a, b), piece in zip(now, mesh.pieces, strict=True):
        if s != piece.segment or not np.array_equal(a.coefficients, piece.start) or not np.array_equal(b.coefficients, piece.end):
            return False
    return not isinstance(problem.delay, Direct) or _reads_stay(problem, theta)


def _reads_stay(problem: OrbitProblem, theta: Array) -> bool:
    """Whether every delayed value is still read from the piece in which it lies at ``theta``, near the interval it was found in.

    Collocation points of a mesh that does not track breaking points may pass an edge; a segment's end never may, since a state
    may jump there.
    """
    mesh = problem.mesh
    if mesh.anchor is None:
        return True
    assert isinstance(problem.delay, Direct)
    piece = np.repeat(np.arange(len(mesh.pieces)), [len(p.cuts) - 1 for p in mesh.pieces])
    held = slice(0 if problem.delay.track else mesh.n_collocation, None)
    lengths, starts = mesh.length @ theta, mesh.start @ theta
    for k in range(len(theta) - mesh.n_segments):
        where = anchored(mesh, mesh.n_segments + k)
        sigma = (where.times @ theta - starts[where.interval]) / lengths[where.interval]
        if np.any(sigma < -BEYOND) or np.any(sigma > 1.0 + BEYOND):
            return False
        now = locate(mesh, theta, mesh.n_segments + k, mesh.sites)
        if np.any(piece[now.interval[held]] != piece[where.interval[held]]) or np.any(now.wraps[held] != where.wraps[held]):
            return False
    return True


def good_enough(problem: OrbitProblem, x: Array, rule: MeshRule) -> bool:
    """Whether the mesh keeps the rule's tolerance at ``x`` (always, if the rule fixes the number of intervals)."""
    if rule.tol is None or problem.mesh.n_intervals >= MAX_INTERVALS:
        return True
    return float(np.max(interval_errors(problem, x))) <= rule.tol


def transfer(old: Mesh, old_theta: Array, values: Array, new: Mesh, new_theta: Array) -> Array:
    """Return base values (n_base, n) of ``old`` at the base points of ``new``.

    A base point reads the old polynomials at the same fraction of its segment, so the two may differ in their durations.
    """
    times, edges_, lengths = new.base_times(new_theta), old.start @ old_theta, old.length @ old_theta
    n = new.n_segments
    old_ends = np.concatenate([[0.0], np.cumsum(old_theta[:n])])
    new_ends = np.concatenate([[0.0], np.cumsum(new_theta[:n])])
    result = np.empty((new.n_base, values.shape[1]))
    for s in range(n):
        # Where two breaking points meet exactly an interval has no length, and nothing to read.
        inside = np.flatnonzero((old.segment == s) & (lengths > 0.0))
        rows = np.arange(new.first_base[s], new.last_base[s] + 1)
        if not len(inside):
            result[rows] = values[old.first_base[s]]
            continue
        at = old_ends[s] + (times[rows] - new_ends[s]) * (old_theta[s] / new_theta[s])
        interval = inside[np.clip(np.searchsorted(edges_[inside], at, side="right") - 1, 0, len(inside) - 1)]
        # An interval that two meeting breaking points leave no length is read at its start.
        sigma = np.divide(at - edges_[interval], lengths[interval], out=np.zeros(len(at)), where=lengths[interval] > 0.0)
        sigma = np.clip(sigma, 0.0, 1.0)
        result[rows] = old.at(values, Places(interval, sigma))
    return result


def on_mesh(problem: OrbitProblem, x: Array, mesh: Mesh) -> tuple[OrbitProblem, Array]:
    """Return the orbit ``x`` on another mesh, its own values as the reference of its phase."""
    return moved_to(problem, x, problem.theta(x), mesh)


def moved_to(problem: OrbitProblem, x: Array, old_theta: Array, mesh: Mesh) -> tuple[OrbitProblem, Array]:
    """Return the same for an orbit whose present mesh holds at ``old_theta``: before its parameters were changed."""
    values, durations, start, free = problem.layout.split(x)
    moved = transfer(problem.mesh, old_theta, values, mesh, problem.theta(x))
    new = replace(problem, mesh=mesh, reference=None if problem.reference is None else moved)
    return new, new.layout.join(moved, durations, start, free)


def remeshed(problem: OrbitProblem, x: Array, rule: MeshRule) -> tuple[OrbitProblem, Array]:
    """Return the orbit ``x`` on the mesh of ``rule`` for it, as a guess."""
    theta = problem.theta(x)
    density = None if rule.tol is None else density_of(problem, x, rule)
    return on_mesh(problem, x, new_mesh(problem, theta, rule, density))
