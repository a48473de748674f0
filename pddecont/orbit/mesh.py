"""Mesh intervals whose edges are affine in the segment durations and the delays.

With theta = (T_1, ..., T_S, tau_1, ..., tau_K) every edge is ``coefficients @ theta``, counted from the start of the first
segment. A piece lies between two neighbouring breaking points and is cut into intervals at fixed fractions, so the mesh
moves with theta and all its derivatives are the coefficients themselves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pddecont.orbit.basis import Basis, make_basis

Array = NDArray[np.float64]
Ints = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Places:
    """Points of an orbit by mesh interval and sigma in [0, 1]; both of shape (n_places,).

    ``weights`` (n_places, degree + 1) are those of the interval's base values, where they are known beforehand. ``inward`` says, where a
    delayed value lies on an edge, from which side it is read: 1 for the one after it, -1 for the one before; by default a place reads from
    the side of its own interval.
    """

    interval: Ints
    sigma: Array
    weights: Array | None = None
    inward: Array | None = None

    def __len__(self) -> int:
        return len(self.sigma)


@dataclass(frozen=True, eq=False)
class Piece:
    """A smooth part of a segment.

    ``start`` and ``end`` are integer coefficients of theta, shape (S + K,); ``cuts`` the edges of its mesh intervals as
    increasing fractions from 0 to 1.
    """

    segment: int
    start: Array
    end: Array
    cuts: Array


@dataclass(frozen=True, eq=False)
class Mesh:
    """The mesh intervals of one orbit, in order of time; ``n_theta`` = S + K.

    Base points are numbered through the orbit: ``degree`` a mesh interval and one more at the end of each segment, since
    neighbours inside a segment share the point between them and segments do not. ``anchor`` is the theta that the mesh was made
    for, where it matters which interval a delayed value is read from.
    """

    degree: int
    n_segments: int
    pieces: tuple[Piece, ...]
    anchor: Array | None = None

    @cached_property
    def basis(self) -> Basis:
        """The reference basis of this mesh's degree."""
        return make_basis(self.degree)

    @cached_property
    def segment(self) -> Ints:
        """Segment of each interval, shape (n_intervals,)."""
        return np.repeat([p.segment for p in self.pieces], [len(p.cuts) - 1 for p in self.pieces])

    @cached_property
    def start(self) -> Array:
        """Coefficients of each interval's left edge, shape (n_intervals, n_theta)."""
        return np.concatenate([p.start + np.outer(p.cuts[:-1], p.end - p.start) for p in self.pieces])

    @cached_property
    def length(self) -> Array:
        """Coefficients of each interval's length, shape (n_intervals, n_theta)."""
        return np.concatenate([np.outer(np.diff(p.cuts), p.end - p.start) for p in self.pieces])

    @cached_property
    def n_intervals(self) -> int:
        """Number of mesh intervals."""
        return len(self.segment)

    @cached_property
    def n_base(self) -> int:
        """Number of base points."""
        return self.degree * self.n_intervals + self.n_segments

    @cached_property
    def base_index(self) -> Ints:
        """Base points of each interval, shape (n_intervals, degree + 1)."""
        first = self.degree * np.arange(self.n_intervals) + self.segment
        return first[:, None] + np.arange(self.degree + 1)

    @cached_property
    def first_base(self) -> Ints:
        """First base point of each segment, shape (n_segments,)."""
        return self.base_index[np.searchsorted(self.segment, np.arange(self.n_segments)), 0]

    @cached_property
    def last_base(self) -> Ints:
        """Last base point of each segment, shape (n_segments,)."""
        return self.base_index[self.last_interval, -1]

    @cached_property
    def last_interval(self) -> Ints:
        """Last interval of each segment, shape (n_segments,)."""
        return np.searchsorted(self.segment, np.arange(self.n_segments), side="right") - 1

    @cached_property
    def sites(self) -> Places:
        """Where equations hold: the collocation points, interval by interval, then the segments' ends."""
        points, ends = self.grid(self.basis.nodes), np.ones(self.n_segments)
        assert points.weights is not None
        return Places(np.concatenate([points.interval, self.last_interval]), np.concatenate([points.sigma, ends]),
                      np.concatenate([points.weights, self.basis.lagrange(ends)]))  # fmt: skip

    def grid(self, sigma: Array, intervals: NDArray[np.intp] | None = None) -> Places:
        """Return the places at the same ``sigma`` (k,) of every interval, or of some ``intervals``."""
        there = np.arange(self.n_intervals) if intervals is None else intervals
        n = len(there)
        return Places(np.repeat(there, len(sigma)), np.tile(sigma, n), np.tile(self.basis.lagrange(sigma), (n, 1)))

    @cached_property
    def site_times(self) -> Array:
        """Coefficients of the times of all sites, shape (n_sites, n_theta)."""
        return self.times(self.sites)

    def times(self, places: Places) -> Array:
        """Return the coefficients of the times of ``places``, shape (n_places, n_theta)."""
        return self.start[places.interval] + places.sigma[:, None] * self.length[places.interval]

    def local_weights(self, places: Places) -> Array:
        """Return the weights of the interval's base values in the value at each place, shape (n_places, degree + 1)."""
        return self.basis.lagrange(places.sigma) if places.weights is None else places.weights

    def at(self, values: Array, places: Places) -> Array:
        """Return the polynomials through base ``values`` (n_base, n) at ``places``, shape (n_places, n)."""
        return np.matmul(self.local_weights(places)[:, None], values[self.base_index[places.interval]])[:, 0]

    @cached_property
    def n_collocation(self) -> int:
        """Number of collocation points."""
        return self.degree * self.n_intervals

    @cached_property
    def n_sites(self) -> int:
        """Number of sites: collocation points and segment ends."""
        return self.n_collocation + self.n_segments

    def base_times(self, theta: Array) -> Array:
        """Return the times of the base points, shape (n_base,)."""
        times = np.empty(self.n_base)
        times[self.base_index] = (self.start @ theta)[:, None] + self.basis.base * (self.length @ theta)[:, None]
        return times

    def at_nodes(self, values: Array) -> Array:
        """Return the polynomials through base ``values`` (n_base, ...) at the collocation points, (n_collocation, ...)."""
        local = values[self.base_index]
        return np.einsum("ib,jb...->ji...", self.basis.values, local).reshape(-1, *values.shape[1:])


def segment_pieces(n_segments: int, n_theta: int, cuts: Sequence[Array]) -> tuple[Piece, ...]:
    """Return one piece a segment, cut at the fractions in ``cuts``."""
    ends = np.zeros((n_segments + 1, n_theta))
    for s in range(n_segments):
        ends[s + 1, : s + 1] = 1.0
    return tuple(Piece(s, ends[s], ends[s + 1], np.asarray(c)) for s, c in enumerate(cuts))


def share_intervals(lengths: Array, n_intervals: int) -> Ints:
    """Return how many of ``n_intervals`` each piece gets: at least one each, the rest where intervals are longest."""
    counts = np.ones(len(lengths), dtype=np.intp)
    for _ in range(n_intervals - len(lengths)):
        counts[np.argmax(lengths / counts)] += 1
    return counts


def equal_cuts(counts: Ints) -> list[Array]:
    """Return equally spaced cuts, one array a piece."""
    return [np.linspace(0.0, 1.0, n + 1) for n in counts]
