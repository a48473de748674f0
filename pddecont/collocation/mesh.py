"""Mesh intervals whose edges are affine in segment durations, delays and breaking times.

With theta = (T_1, ..., T_S, tau_1, ..., tau_K, b_1, ..., b_J) every edge is ``coefficients @ theta``, counted from the
start of the first segment. The b are breaking times that no sum of delays gives: those of delays that vary. A piece
lies between two neighbouring breaking points and is cut into intervals at fixed fractions, so the mesh moves with theta
and all its derivatives are the coefficients themselves.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation.basis import Basis, make_basis, weigh
from pddecont.memo import Found, Memo, cached_property
from pddecont.native import compiled_assembly

Array = NDArray[np.float64]
Ints = NDArray[np.intp]
# What a mesh works out of its pieces alone.
EDGES = (
    "piece",
    "segment",
    "piece_lengths",
    "start",
    "length",
    "n_intervals",
    "first_interval",
    "last_interval",
    "_every_interval",
    "breaking_interval",
)
# Layouts that meshes made one after another know.
KNOWN_LAYOUTS = 16


def find_inner_side(sigma: Array) -> Array:
    """Return on which side of points their interval, from 0 to 1, goes on: 1 at its start, -1 at its end, 0 inside."""
    return np.where(sigma <= 0.0, 1.0, np.where(sigma >= 1.0, -1.0, 0.0))


@dataclass(frozen=True, eq=False)
class MeshPoints:
    """Points by mesh interval and sigma in [0, 1]; both of shape (n_points,).

    ``weights`` (n_points, degree + 1) are those of the interval's base values, ``columns`` of the same shape its base
    points, where they are known beforehand.
    ``inward`` says, where a delayed value lies on an edge, from which side it is read: 1 for the interval after it, -1
    for the one before; by default a point reads from the side of its own interval.
    """

    interval: Ints
    sigma: Array
    weights: Array | None = None
    inward: Array | None = None
    columns: Ints | None = None

    def __len__(self) -> int:
        return len(self.sigma)

    @cached_property
    def side(self) -> Array:
        """From which side each point reads (n_points,): 1 after it, -1 before, 0 inside an interval, where both do."""
        return find_inner_side(self.sigma) if self.inward is None else self.inward

    def clipped(self) -> MeshPoints:
        """Return the points with sigma moved into [0, 1], where rounding or a wide reach took it beyond."""
        return replace(self, sigma=np.clip(self.sigma, 0.0, 1.0), weights=None)


@dataclass(frozen=True, eq=False)
class Piece:
    """A smooth part of a segment.

    ``start`` and ``end`` are integer coefficients of theta, shape (n_theta,); ``cuts`` the edges of its mesh intervals
    as increasing fractions from 0 to 1.
    """

    segment: int
    start: Array
    end: Array
    cuts: Array


@dataclass(frozen=True, eq=False)
class BreakingTime:
    """A breaking time b among the components of theta: what delay number ``delay`` reads there is a jump.

    With the delay's value tau there, b - tau = ``source`` @ theta, coefficients of shape (n_theta,); ``level`` is the
    derivative that jumps at b.
    """

    delay: int
    source: Array
    level: int


@dataclass(frozen=True, eq=False)
class Mesh(Memo):
    """The mesh intervals of one orbit, in order of time; ``n_theta`` = S + K + J.

    Base points are numbered through the orbit: ``degree`` a mesh interval and one more at the end of each segment,
    since neighbours inside a segment share the point between them and segments do not. ``reference_theta`` is the theta
    that the mesh was made for, where it matters which interval a delayed value is read from; ``reference_lags``
    (n_varying, n_equation_points) are the values that delays that vary had there. What is worked out of a mesh is kept
    for itself (:meth:`once`), for all of its pieces (:meth:`always`), or for all of its layout (:meth:`alike`).
    """

    degree: int
    n_segments: int
    pieces: tuple[Piece, ...]
    reference_theta: Array | None = None
    breaking: tuple[BreakingTime, ...] = ()
    reference_lags: Array | None = None
    _always: Memo = field(default_factory=Memo, init=False, repr=False)
    _layout: Memo = field(default_factory=Memo, init=False, repr=False)
    _layouts: dict[Hashable, Memo] = field(default_factory=dict, init=False, repr=False)

    def always(self, key: Hashable, find: Callable[[], Found]) -> Found:
        """Return what ``find`` finds, found once for all meshes of these pieces, wherever they read the past."""
        return self._always.once(key, find)

    def alike(self, key: Hashable, find: Callable[[], Found]) -> Found:
        """Return what ``find`` finds, found once for all meshes of this layout, wherever their intervals lie."""
        return self._layout.once(key, find)

    def anchor(self, theta: Array, lags: Array | None = None) -> Mesh:
        """Return the same mesh made for another ``theta``, where delays that vary have the values ``lags``.

        Delayed values are read from where they lie there.
        """
        anchored = replace(self, reference_theta=theta.copy(), reference_lags=lags)
        # Nothing that is worked out of the pieces alone has to be found again.
        own = anchored.__dict__
        kept = {"_always": self._always, "_layout": self._layout, "_layouts": self._layouts}
        own.update({name: value for name, value in self.__dict__.items() if name not in own}, **kept)
        return anchored

    def take_edges(self, other: Mesh) -> None:
        """Take over what has been worked out of the edges of another mesh of these pieces, whatever its degree."""
        known = other.__dict__
        self.__dict__.update({name: known[name] for name in EDGES if name in known})

    def take_layout(self, other: Mesh) -> None:
        """Take over what has been worked out of this layout for ``other`` or a mesh before it, if one of them has it.

        Points are numbered alike on meshes of one degree with as many intervals in each segment, and breaking times
        behind as many of them.
        """
        layouts, key = other._layouts, self._layout_key
        layouts.setdefault(other._layout_key, other._layout)
        # Those that were met last stand last.
        layouts[key] = layouts.pop(key, self._layout)
        while len(layouts) > KNOWN_LAYOUTS:
            del layouts[next(iter(layouts))]
        self.__dict__.update(_layout=layouts[key], _layouts=layouts)

    @property
    def _layout_key(self) -> Hashable:
        breaking = [(b.delay, b.level, b.source.tobytes()) for b in self.breaking]
        counts = np.bincount(self.segment, minlength=self.n_segments)
        return self.degree, counts.tobytes(), self.breaking_interval.tobytes(), tuple(breaking)

    def has_layout_of(self, other: Mesh) -> bool:
        """Return whether points are numbered alike on another mesh, from which the layout was taken over."""
        return self._layout is other._layout

    def has_base_points_of(self, other: Mesh) -> bool:
        """Return whether base values mean the same on another mesh, wherever delayed values are read."""
        return self.pieces is other.pieces and self.degree == other.degree

    @cached_property
    def basis(self) -> Basis:
        """The reference basis of this mesh's degree."""
        return make_basis(self.degree)

    @cached_property
    def piece(self) -> Ints:
        """Piece of each interval, shape (n_intervals,)."""
        return np.repeat(np.arange(len(self.pieces)), [len(p.cuts) - 1 for p in self.pieces])

    @cached_property
    def segment(self) -> Ints:
        """Segment of each interval, shape (n_intervals,)."""
        return np.array([p.segment for p in self.pieces], dtype=np.intp)[self.piece]

    @cached_property
    def piece_lengths(self) -> Array:
        """Coefficients of each piece's length, shape (n_pieces, n_theta)."""
        return np.array([p.end - p.start for p in self.pieces])

    @cached_property
    def start(self) -> Array:
        """Coefficients of each interval's left edge, shape (n_intervals, n_theta)."""
        cuts, starts = np.concatenate([p.cuts[:-1] for p in self.pieces]), np.array([p.start for p in self.pieces])
        return np.asarray(starts[self.piece] + cuts[:, None] * self.piece_lengths[self.piece])

    @cached_property
    def length(self) -> Array:
        """Coefficients of each interval's length, shape (n_intervals, n_theta)."""
        shares = np.concatenate([p.cuts[1:] - p.cuts[:-1] for p in self.pieces])
        return np.asarray(shares[:, None] * self.piece_lengths[self.piece])

    @cached_property
    def n_intervals(self) -> int:
        """Number of mesh intervals."""
        return len(self.segment)

    @cached_property
    def n_base(self) -> int:
        """Number of base points."""
        return self.degree * self.n_intervals + self.n_segments

    @cached_property
    def n_collocation(self) -> int:
        """Number of collocation points."""
        return self.degree * self.n_intervals

    @cached_property
    def base_index(self) -> Ints:
        """Base points of each interval, shape (n_intervals, degree + 1)."""
        first = self.degree * np.arange(self.n_intervals) + self.segment
        return first[:, None] + np.arange(self.degree + 1)

    @cached_property
    def first_base(self) -> Ints:
        """First base point of each segment, shape (n_segments,)."""
        result: Ints = self.base_index[self.first_interval, 0]
        return result

    @cached_property
    def last_base(self) -> Ints:
        """Last base point of each segment, shape (n_segments,)."""
        result: Ints = self.base_index[self.last_interval, -1]
        return result

    @cached_property
    def first_interval(self) -> Ints:
        """First interval of each segment, shape (n_segments,)."""
        return np.searchsorted(self.segment, np.arange(self.n_segments))

    @cached_property
    def last_interval(self) -> Ints:
        """Last interval of each segment, shape (n_segments,)."""
        return np.searchsorted(self.segment, np.arange(self.n_segments), side="right") - 1

    @cached_property
    def _every_interval(self) -> Ints:
        return np.arange(self.n_intervals)

    @property
    def n_breaking(self) -> int:
        """Number J of breaking times in theta, its last components."""
        return len(self.breaking)

    @property
    def reference_breaking(self) -> Array:
        """The breaking times that the mesh was made for, shape (J,)."""
        if not self.breaking:
            return np.zeros(0)
        assert self.reference_theta is not None, "a mesh with breaking times is made for a theta"
        return self.reference_theta[-self.n_breaking :]

    @cached_property
    def breaking_interval(self) -> Ints:
        """The interval that ends at each breaking time, shape (J,)."""
        if not self.breaking:
            return np.zeros(0, dtype=np.intp)
        last = np.cumsum([len(p.cuts) - 1 for p in self.pieces]) - 1
        ends = np.array([p.end for p in self.pieces])
        n_known = ends.shape[1] - self.n_breaking
        # The pieces that end at one breaking time, and at nothing else.
        pieces = np.flatnonzero((np.count_nonzero(ends, axis=1) == 1) & np.any(ends[:, n_known:] == 1.0, axis=1))
        numbers = np.argmax(ends[pieces, n_known:], axis=1)
        result = np.full(self.n_breaking, -1, dtype=np.intp)
        result[numbers[::-1]] = last[pieces[::-1]]
        return result

    @cached_property
    def equation_points(self) -> MeshPoints:
        """Where equations hold: the collocation points interval by interval, segments' ends, breaking times."""

        def find() -> MeshPoints:
            points, ends = self.grid(self.basis.nodes), np.ones(self.n_segments + self.n_breaking)
            weights = np.concatenate([self.local_weights(points), self.basis.lagrange(ends)])
            interval = np.concatenate([points.interval, self.last_interval, self.breaking_interval])
            sigma, columns = np.concatenate([points.sigma, ends]), self.base_index[interval]
            return MeshPoints(interval, sigma, weights, columns=columns)

        return self.alike("equation points", find)

    @cached_property
    def n_equation_points(self) -> int:
        """Number of equation points: collocation points, segment ends and breaking times."""
        return self.n_collocation + self.n_segments + self.n_breaking

    @cached_property
    def equation_times(self) -> Array:
        """Coefficients of the times of all equation points, shape (n_equation_points, n_theta)."""
        return self.times(self.equation_points)

    @property
    def base_points(self) -> MeshPoints:
        """The base points interval by interval; neighbours inside a segment each have the one between them."""
        return self.alike("base points", lambda: self.grid(self.basis.base))

    def grid(self, sigma: Array, intervals: Ints | None = None) -> MeshPoints:
        """Return the points at the same ``sigma`` (k,) of every interval, or of some ``intervals``."""
        chosen = self._every_interval if intervals is None else intervals
        columns = self.base_index if intervals is None else self.base_index[chosen]

        def spread(values: NDArray[Any], *shape: int) -> NDArray[Any]:
            """Return values for each point, point by point, of arrays (n, 1, ...) or (1, k, ...)."""
            result = np.empty((len(chosen), len(sigma), *shape), values.dtype)
            result[...] = values
            return result.reshape(-1, *shape)

        weights, m = self.basis.lagrange(sigma), columns.shape[1]
        return MeshPoints(
            spread(chosen[:, None]), spread(sigma), spread(weights, m), columns=spread(columns[:, None], m)
        )

    def times(self, points: MeshPoints) -> Array:
        """Return the coefficients of the times of ``points``, shape (n_points, n_theta)."""
        return self.start[points.interval] + points.sigma[:, None] * self.length[points.interval]

    def evaluate_edges(self, theta: Array) -> tuple[Array, Array]:
        """Return the intervals' starts and lengths at ``theta``, each (n_intervals,)."""
        key, found = theta.tobytes(), self._found.get("edges")
        if found is None or found[0] != key:
            found = self._found["edges"] = (key, self.start @ theta, self.length @ theta)
        return found[1], found[2]

    def evaluate_times(self, points: MeshPoints, theta: Array) -> Array:
        """Return the times of ``points`` at ``theta``, shape (n_points,)."""
        starts, lengths = self.evaluate_edges(theta)
        return np.asarray(starts[points.interval] + points.sigma * lengths[points.interval])

    def base_times(self, theta: Array) -> Array:
        """Return the times of the base points, shape (n_base,)."""
        times, (starts, lengths) = np.empty(self.n_base), self.evaluate_edges(theta)
        times[self.base_index] = starts[:, None] + self.basis.base * lengths[:, None]
        return times

    def period(self, theta: Array) -> float:
        """Return the sum of the segment durations."""
        return float(theta[: self.n_segments].sum())

    def locate(
        self, theta: Array, times: Array, *, choose_by: Array | None = None, segment: int | None = None
    ) -> tuple[MeshPoints, Ints]:
        """Return where ``times`` (n,) lie on the mesh at ``theta``, and how many periods later than there they are.

        An interval holds its left edge, and no point lies in an interval without length unless there is no other. sigma
        leaves [0, 1] where the interval is chosen by other times, or the time is outside ``segment``.

        Parameters
        ----------
        choose_by
            Times (n,) that choose the interval and the period, where rounding must not: a little inside.
        segment
            Choose among the intervals of this segment alone; its times are not wrapped by periods.
        """
        edges, lengths = self.evaluate_edges(theta)
        candidates, period = self._every_interval, self.period(theta)
        if segment is not None:
            inside, period = np.flatnonzero(self.segment == segment), 0.0
            # Where two breaking points meet exactly an interval has no length, and nothing to read.
            candidates = inside[lengths[inside] > 0.0] if np.any(lengths[inside] > 0.0) else inside[:1]
        at = np.asarray(times, dtype=np.float64, order="C")
        chooser = at if choose_by is None else np.asarray(choose_by, dtype=np.float64, order="C")
        interval, sigma, wraps = np.empty(len(at), dtype=np.intp), np.empty(len(at)), np.empty(len(at), dtype=np.intp)
        compiled_assembly.locate_times(
            at, chooser, len(at), edges, lengths, candidates, len(candidates), period, interval, sigma, wraps
        )
        return MeshPoints(interval, sigma), wraps

    def local_weights(self, points: MeshPoints) -> Array:
        """Return the weights of the interval's base values in the value at each point, shape (n_points, degree + 1)."""
        return self.basis.lagrange(points.sigma) if points.weights is None else points.weights

    def interpolate(self, values: Array, points: MeshPoints) -> Array:
        """Return the polynomials through base ``values`` (n_base, n) at ``points``, shape (n_points, n)."""
        columns = self.base_index[points.interval] if points.columns is None else points.columns
        return weigh(self.local_weights(points), columns, values)

    def interpolate_at_nodes(self, values: Array) -> Array:
        """Return the polynomials through base ``values`` (n_base, ...) at the collocation points.

        The result has shape (n_collocation, ...).
        """
        local = values[self.base_index]
        result: Array = np.einsum("ib,jb...->ji...", self.basis.values, local).reshape(-1, *values.shape[1:])
        return result
