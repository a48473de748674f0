"""How many mesh intervals each piece gets, and where they lie.

With a fixed number the intervals go where pieces are longest. With a tolerance each piece is cut so that every interval
leaves the same error: an interval of length h with error e has the density (e / tol)^(1/(m+1)) / h, whose integral over
a piece is the number of intervals that it needs and whose equal shares are their ends.

Reference: Ascher, Mattheij, Russell, Numerical Solution of Boundary Value Problems for Ordinary Differential Equations
(1995), section 9.1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation.mesh import Mesh, Piece
from pddecont.native import compiled_assembly

Array = NDArray[np.float64]
Ints = NDArray[np.intp]
# The share of the tolerance that a new mesh aims at: estimates on the old one are rough.
SAFETY = 0.3
# Most intervals of a mesh; beyond it a tolerance counts as met.
MAX_INTERVALS = 5000
# Intervals of a first mesh: enough to see the orbit's shape.
FIRST_INTERVALS = 12
# By how much an interval may grow or shrink at once; a first mesh may be far too coarse to trust its estimate.
LEAST_CHANGE, MOST_CHANGE = 0.2, 8.0
# An estimated error below this is rounding.
LEAST_ERROR = 1e-18


@dataclass(frozen=True)
class MeshRule:
    """How meshes are made: polynomials of ``degree``, a number of ``intervals`` or an error ``tol``.

    The error is relative to the orbit's size.
    """

    degree: int
    intervals: int | None = None
    tol: float | None = None


@dataclass(frozen=True, eq=False)
class Density:
    """Intervals wanted in each unit of time: constant between ``edges`` (n + 1,), of height ``heights`` (n,)."""

    edges: Array
    heights: Array

    def cut(self, start: float, end: float) -> Array:
        """Return the cuts of a piece from ``start`` to ``end``, as fractions."""
        n, cuts = len(self.heights), np.empty(MAX_INTERVALS + 1)
        grid, totals = np.empty((2, n + 3))
        n_cuts = compiled_assembly.cut_piece(self.edges, self.heights, n, start, end, MAX_INTERVALS, grid, totals, cuts)
        return cuts[: n_cuts + 1].copy()


def has_wanted_intervals(mesh: Mesh, theta: Array, density: Density) -> bool:
    """Return whether each piece of a mesh has as many intervals as the ``density`` that was found on it asks for."""
    wanted = np.ceil(np.bincount(mesh.piece, density.heights * (mesh.length @ theta)))
    return np.array_equal(np.clip(wanted, 1, MAX_INTERVALS), np.bincount(mesh.piece))


def interval_density(mesh: Mesh, theta: Array, errors: Array, tol: float) -> Density:
    """Return the density of intervals that leaves the error ``tol``, from the ``errors`` (n_intervals,) on a mesh."""
    wanted = (np.maximum(errors, LEAST_ERROR) / (SAFETY * tol)) ** (1.0 / (mesh.degree + 1))
    lengths, start = mesh.length @ theta, mesh.start @ theta
    heights = np.clip(wanted, LEAST_CHANGE, MOST_CHANGE) / lengths
    return Density(np.append(start, start[-1] + lengths[-1]), heights)


def cut_pieces(pieces: Sequence[Piece], theta: Array, rule: MeshRule, density: Density | None = None) -> list[Piece]:
    """Return pieces cut into the intervals that ``rule`` asks for at ``theta``; a tolerance needs a ``density``."""
    starts = np.array([p.start for p in pieces])
    ends = np.array([p.end for p in pieces])
    lengths = (ends - starts) @ theta
    if rule.intervals is not None:
        cuts = equal_cuts(share_intervals(lengths, max(rule.intervals, len(pieces))))
    elif density is None:
        cuts = equal_cuts(share_intervals(lengths, max(FIRST_INTERVALS, len(pieces))))
    else:
        cuts = [density.cut(a, b) for a, b in zip(starts @ theta, ends @ theta, strict=True)]
    return [Piece(piece.segment, piece.start, piece.end, c) for piece, c in zip(pieces, cuts, strict=True)]


def share_intervals(lengths: Array, n_intervals: int) -> Ints:
    """Return how many of ``n_intervals`` each piece gets: one each, the rest where intervals are longest."""
    counts = np.ones(len(lengths), dtype=np.intp)
    for _ in range(n_intervals - len(lengths)):
        counts[np.argmax(lengths / counts)] += 1
    return counts


def equal_cuts(counts: Ints) -> list[Array]:
    """Return equally spaced cuts, one array a piece."""
    return [np.linspace(0.0, 1.0, n + 1) for n in counts]


def refine_evenly(mesh: Mesh) -> Mesh:
    """Return a mesh of the same pieces with one interval more in each."""

    def finer(cuts: Array) -> Array:
        return np.interp(np.linspace(0.0, 1.0, len(cuts) + 1), np.linspace(0.0, 1.0, len(cuts)), cuts)

    pieces = tuple(replace(piece, cuts=finer(piece.cuts)) for piece in mesh.pieces)
    return replace(mesh, pieces=pieces, reference_lags=None)
