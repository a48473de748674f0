"""Extrema of an expression along an orbit, from the polynomials and not from samples."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import pairwise

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from pddecont.codegen import ArrayFunction
from pddecont.collocation import make_basis
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.smooth_subintervals import find_smooth_subintervals

Array = NDArray[np.float64]
# Candidates nearer than this, relative to their interval, are one extremum or lie at a segment's end.
TOGETHER = 1e-6
# A function that changes by more than this part of its largest modulus at a breaking point jumps there.
JUMP = 1e-6
# How far beside an extremum its slopes are compared, relative to its interval.
ASIDE = 1e-5
# A root of the slope whose imaginary part is below this is real.
REAL = 1e-7
# Coefficients below this part of the largest are rounding.
ROUNDING = 1e-15
# By how much the first coefficient of a slope must outweigh the rest for it to have no zero, against rounding.
OUTWEIGH = 1.0 + 1e-6
# Parts of an interval in which a slope's zeros are first looked for so.
PARTS = 8


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

    def slope_beside(self, e: Extremum, away: float) -> float:
        """Return the slope at a time ``away`` from an extremum, if need be in another interval of its segment."""
        j, at = e.interval, e.sigma + away / self.h[e.interval]
        n = len(self.h)
        while not 0.0 <= at <= 1.0 and (self.closed or 0 <= j + np.sign(away) < n):
            other = int(j + np.sign(away)) % n
            if self.segment[other] != self.segment[j]:
                break
            at = ((at - 1.0) * self.h[j] if away > 0.0 else self.h[other] + at * self.h[j]) / self.h[other]
            j = other
        basis = make_basis(self.degree)
        return float(basis.lagrange(np.array(at)) @ basis.differentiate @ self.values[j] / self.h[j])

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
        return _merge(list(_find_candidates(self)), self)


def make_profile(
    orbit: Orbit, function: ArrayFunction, row: int = 0, segments: Collection[int] | None = None
) -> Profile:
    """Return expression ``row`` of ``function`` along an orbit, or along some of its segments.

    An expression that is linear in the states is a polynomial of the orbit's degree; any other is interpolated at twice
    that degree.
    """
    mesh = orbit.mesh
    degree = mesh.degree if function.linear[row] else 2 * mesh.degree
    chosen = np.arange(mesh.n_intervals) if segments is None else np.flatnonzero(np.isin(mesh.segment, list(segments)))
    parts = find_smooth_subintervals(orbit, chosen, delays=function.uses_delayed)
    reads = orbit.read(parts.grid(mesh, make_basis(degree).base), delays=function.uses_delayed)
    values = function.value(reads.t, reads.x, reads.xd, orbit.parameters)[row].reshape(len(parts.interval), -1)
    h = reads.h[parts.interval]
    start = (mesh.start @ orbit.theta)[parts.interval] + parts.low * h
    closed = not orbit.signature.has_events
    return Profile(degree, values, mesh.segment[parts.interval], start, parts.share * h, closed)


def _find_candidates(profile: Profile) -> Iterator[Extremum]:
    """Yield roots of the slope on each interval, a little beyond its ends too, and edges where it changes sign."""
    slopes = profile.values @ make_basis(profile.degree).differentiate.T
    series = slopes @ _to_chebyshev(profile.degree).T
    parts = (series @ _to_parts(profile.degree).T).reshape(len(series), PARTS, -1)
    may_turn = np.any(np.abs(parts[:, :, 0]) <= OUTWEIGH * np.sum(np.abs(parts[:, :, 1:]), axis=2), axis=1)
    n = len(profile.values)
    for j, values in enumerate(profile.values):
        if may_turn[j]:
            yield from _find_inside(profile, j, values, series[j])
        if j + 1 == n and not profile.closed:
            continue
        following = (j + 1) % n
        if profile.segment[following] == profile.segment[j] and slopes[j, -1] * slopes[following, 0] <= 0.0:
            yield _make(profile, j, 1.0, float(values[-1]), bool(slopes[j, -1] > 0.0))


def _find_inside(profile: Profile, j: int, values: Array, slope: Array) -> Iterator[Extremum]:
    """Yield the extrema strictly inside interval ``j``; ``slope`` holds the Chebyshev coefficients of the derivative.

    Reference: Trefethen, Approximation Theory and Approximation Practice (2013), chapter 18 (colleague matrices).
    """
    largest = np.max(np.abs(slope), initial=0.0)
    if largest == 0.0 or not np.isfinite(largest):
        return
    series = chebyshev.chebtrim(slope, ROUNDING * largest)
    if len(series) < 2:
        return
    roots = 0.5 + 0.5 * chebyshev.chebroots(series)
    near = (roots.real > -TOGETHER) & (roots.real < 1.0 + TOGETHER)
    bends = chebyshev.chebder(series)
    for root in np.sort(roots.real[(np.abs(roots.imag) < REAL) & near]):
        sigma = min(max(float(root), 0.0), 1.0)
        bend = 2.0 * chebyshev.chebval(2.0 * sigma - 1.0, bends)
        if bend != 0.0:
            sigma = min(max(sigma - float(chebyshev.chebval(2.0 * sigma - 1.0, series) / bend), 0.0), 1.0)
        value = float(make_basis(profile.degree).lagrange(np.array(sigma)) @ values)
        yield _make(profile, j, sigma, value, bool(bend < 0))


@cache
def _to_chebyshev(degree: int) -> Array:
    """Return the matrix from values at the base points to Chebyshev coefficients."""
    return np.asarray(np.linalg.inv(chebyshev.chebvander(2.0 * make_basis(degree).base - 1.0, degree)))


@cache
def _to_parts(degree: int) -> Array:
    """Return the matrix from Chebyshev coefficients on an interval to those on its parts, one part after the other.

    A polynomial whose first coefficient outweighs the rest has no zero; the shorter the part, the fewer others have
    such a one. The parts reach a little beyond the interval's ends, as far as extrema are looked for.
    """
    ends = np.linspace(-2.0 * TOGETHER, 1.0 + 2.0 * TOGETHER, PARTS + 1)
    places = ends[:-1, None] + make_basis(degree).base * np.diff(ends)[:, None]
    values = chebyshev.chebvander(2.0 * places - 1.0, degree)
    return np.concatenate([_to_chebyshev(degree) @ part for part in values])


def _merge(found: list[Extremum], profile: Profile) -> list[Extremum]:
    """Return one extremum for each place where the slope really changes sign.

    To rounding an extremum on an edge may show in both intervals, in one or between them: candidates that lie together
    are one if the slope has different signs a little before and a little after them, and none if not. Those at an open
    segment's ends, to rounding, are left out.
    """
    groups: list[list[Extremum]] = []
    inner = found if profile.closed else [e for e in found if not _is_at_end(e, profile)]
    for e in sorted(inner, key=lambda e: e.time):
        if groups and _are_together(groups[-1][-1], e, profile, 0.0):
            groups[-1].append(e)
        else:
            groups.append([e])
    period = float(np.sum(profile.h))
    if profile.closed and len(groups) > 1 and _are_together(groups[-1][-1], groups[0][0], profile, period):
        groups[0] = [*groups.pop(), *groups[0]]
    result = []
    for group in groups:
        away = ASIDE * float(np.min(profile.h[[e.interval for e in group]]))
        before, after = profile.slope_beside(group[0], -away), profile.slope_beside(group[-1], away)
        if before * after < 0.0:
            top = before > 0.0
            best = max(group, key=lambda e: e.value if top else -e.value)
            result.append(replace(best, is_max=top))
    return result


def _is_at_end(e: Extremum, profile: Profile) -> bool:
    inside = np.flatnonzero(profile.segment == e.segment)
    begin, end = profile.start[inside[0]], profile.start[inside[-1]] + profile.h[inside[-1]]
    return bool(min(e.time - begin, end - e.time) < TOGETHER * profile.h[e.interval])


def _are_together(a: Extremum, b: Extremum, profile: Profile, period: float) -> bool:
    return bool(a.segment == b.segment and abs(b.time + period - a.time) < TOGETHER * profile.h[a.interval])


def _make(profile: Profile, j: int, sigma: float, value: float, is_max: bool) -> Extremum:
    time = float(profile.start[j] + sigma * profile.h[j])
    return Extremum(int(profile.segment[j]), j, sigma, time, value, is_max)
