"""Extrema of an expression along an orbit, from the polynomials and not from samples."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from pddecont.codegen import ArrayFunction
from pddecont.collocation import make_basis
from pddecont.memo import cached_property
from pddecont.native import compiled_assembly
from pddecont.native.assembly import MAX_HALVINGS, TOGETHER, Curve
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.smooth_subintervals import find_smooth_subintervals

Array = NDArray[np.float64]
# A function that changes by more than this part of its largest modulus at a breaking point jumps there.
JUMP = 1e-6


@dataclass(frozen=True)
class Extremum:
    """A local extremum inside a segment; ``time`` counts from the orbit's start, ``is_max`` tells which kind."""

    segment: int
    interval: int
    sigma: float
    time: float
    value: float
    is_max: bool


@dataclass(frozen=True, eq=False)
class Profile:
    """A function along an orbit as one polynomial a mesh interval, or a part of one.

    ``values`` (n_intervals, degree + 1) are taken at the base points of the basis of ``degree``. The only segment of a
    ``closed`` orbit goes on into itself, so that an extremum may lie where it begins.
    """

    degree: int
    values: Array
    segment: NDArray[np.intp]
    start: Array
    h: Array
    closed: bool = False

    def ends(self, s: int) -> tuple[float, float]:
        """Return the values at the start and the end of segment ``s``."""
        inside = np.flatnonzero(self.segment == s)
        return float(self.values[inside[0], 0]), float(self.values[inside[-1], -1])

    def duration(self, s: int) -> float:
        """Return the duration of segment ``s``."""
        return float(np.sum(self.h[self.segment == s]))

    def start_slope(self, s: int) -> float:
        """Return the slope in time at the start of segment ``s``."""
        first = int(np.flatnonzero(self.segment == s)[0])
        return float(make_basis(self.degree).differentiate[0] @ self.values[first] / self.h[first])

    def end_slope(self, s: int) -> float:
        """Return the slope in time at the end of segment ``s``."""
        last = int(np.flatnonzero(self.segment == s)[-1])
        return float(make_basis(self.degree).differentiate[-1] @ self.values[last] / self.h[last])

    def inner_levels(self, s: int) -> list[float]:
        """Return the values inside segment ``s`` between which the function is monotone, in order of time.

        They are its extrema, and where a delayed value jumps the values on both sides.
        """
        found = [(e.time, 0.0, e.value) for e in self.extrema if e.segment == s]
        inside = np.flatnonzero(self.segment == s)
        largest = float(np.max(np.abs(self.values)))
        for j, following in pairwise(inside):
            before, after = float(self.values[j, -1]), float(self.values[following, 0])
            if abs(after - before) > JUMP * largest:
                time = float(self.start[following])
                found += [(time, -0.5, before), (time, 0.5, after)]
        return [value for _, _, value in sorted(found)]

    @cached_property
    def extrema(self) -> list[Extremum]:
        """All local extrema inside segments, in order of time."""
        n, degree = len(self.values), self.degree
        room = 2 * n * (degree + 1)
        interval, is_max, chosen = np.empty((3, room), dtype=np.int64)
        sigma, value = np.empty((2, room))
        curve, parts = self.make_curve(), np.empty((MAX_HALVINGS + 2, degree))
        halves = _make_halves(degree)
        n_turns = compiled_assembly.find_turns(curve, halves, parts[1:], parts[0], room, interval, sigma, is_max)
        n_chosen = compiled_assembly.choose_extrema(curve, n_turns, interval, sigma, is_max, value, chosen)
        kept = chosen[:n_chosen]
        found = (part[kept].tolist() for part in (interval, sigma, value, is_max))
        return [self._make_extremum(*one) for one in zip(*found, strict=True)]

    def _make_extremum(self, j: int, sigma: float, value: float, is_max: int) -> Extremum:
        time = float(self.start[j] + sigma * self.h[j])
        return Extremum(int(self.segment[j]), j, sigma, time, value, bool(is_max))

    def make_curve(self) -> Curve:
        """Return the function as compiled code takes it."""
        basis, values = make_basis(self.degree), np.ascontiguousarray(self.values)
        # Less a value, the slopes of a constant are zero to the last bit.
        series = (values - values[:, :1]) @ _make_slopes(self.degree)
        return Curve(
            len(values),
            self.degree,
            self.closed,
            self.segment,
            self.start,
            self.h,
            values.ravel(),
            series.ravel(),
            basis.base,
            basis.barycentric,
        )


def make_profile(
    orbit: Orbit, function: ArrayFunction, row: int = 0, segments: Collection[int] | None = None
) -> Profile:
    """Return expression ``row`` of ``function`` along an orbit, or along some of its segments.

    An expression that is linear in the states is a polynomial of the orbit's degree; any other is interpolated at twice
    that degree.
    """
    mesh, delays = orbit.mesh, function.uses_delayed
    degree = mesh.degree if function.linear[row] else 2 * mesh.degree
    wanted = tuple(range(mesh.n_segments) if segments is None else segments)
    chosen = mesh.alike(("intervals of", wanted), lambda: np.flatnonzero(np.isin(mesh.segment, wanted)))
    parts = find_smooth_subintervals(orbit, chosen, delays=delays)
    if delays:
        points = parts.grid(mesh, make_basis(degree).base)
    else:
        key = ("base points of", wanted, degree)
        points = mesh.alike(key, lambda: parts.grid(mesh, make_basis(degree).base))
    reads = orbit.read(points, delays=delays)
    values = function.value(reads.t, reads.x, reads.xd, orbit.parameters)[row].reshape(len(parts.interval), -1)
    h = reads.h[parts.interval]
    start = mesh.evaluate_edges(orbit.theta)[0][parts.interval] + parts.low * h
    closed = not orbit.signature.has_events
    return Profile(degree, values, mesh.segment[parts.interval], start, parts.share * h, closed)


@cache
def _make_slopes(degree: int) -> Array:
    """Return the matrix from values at base points to the Chebyshev coefficients of slopes (degree + 1, degree).

    They are those of slopes in sigma, over an interval that reaches TOGETHER beyond the mesh interval's ends.
    """
    places, basis = _chebyshev_points(degree), make_basis(degree)
    slopes = basis.lagrange(0.5 + (0.5 + TOGETHER) * places) @ basis.differentiate
    return np.ascontiguousarray(np.linalg.solve(chebyshev.chebvander(places, degree - 1), slopes).T)


@cache
def _make_halves(degree: int) -> Array:
    """Return what takes Chebyshev series of ``degree`` coefficients to those of each half, (2, degree, degree)."""
    places = _chebyshev_points(degree)
    whole = chebyshev.chebvander(places, degree - 1)
    halves = [chebyshev.chebvander(0.5 * (places + side), degree - 1) for side in (-1.0, 1.0)]
    return np.asarray(np.linalg.solve(whole, np.array(halves)))


def _chebyshev_points(n: int) -> Array:
    return np.asarray(np.cos(np.pi * (np.arange(n) + 0.5) / n))
