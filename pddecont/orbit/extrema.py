"""Extrema of an expression along an orbit, from the polynomials and not from samples."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from pddecont.model.codegen import ArrayFunction
from pddecont.orbit.basis import make_basis
from pddecont.orbit.mesh import Places
from pddecont.orbit.problem import OrbitProblem, read

Array = NDArray[np.float64]
TOGETHER = 1e-6


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
    """A function along an orbit as one polynomial a mesh interval.

    ``values`` (n_intervals, degree + 1) are taken at the base points of the basis of ``degree``. The only segment of a ``closed``
    orbit goes on into itself, so that an extremum may lie where it begins.
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

    def end_slope(self, s: int) -> float:
        """Return the slope in time at the end of segment ``s``."""
        last = int(np.flatnonzero(self.segment == s)[-1])
        return float(make_basis(self.degree).differentiate[-1] @ self.values[last] / self.h[last])

    def start_slope(self, s: int) -> float:
        """Return the slope in time at the start of segment ``s``."""
        first = int(np.flatnonzero(self.segment == s)[0])
        return float(make_basis(self.degree).differentiate[0] @ self.values[first] / self.h[first])

    def extrema(self) -> list[Extremum]:
        """Return all local extrema inside segments, in order of time."""
        return _told_apart(list(_extrema(self)), self)


def profile(problem: OrbitProblem, x: Array, function: ArrayFunction, row: int = 0) -> Profile:
    """Return expression ``row`` of ``function`` along the orbit with unknowns ``x``.

    An expression that is linear in the states is a polynomial of the orbit's degree; any other is interpolated at twice
    that degree.
    """
    mesh = problem.mesh
    degree = mesh.degree if function.linear[row] else 2 * mesh.degree
    base = make_basis(degree).base
    places = Places(np.repeat(np.arange(mesh.n_intervals), len(base)), np.tile(base, mesh.n_intervals))
    reads = read(problem, x, places, delays=function.uses_delayed)
    values = function.value(reads.t, reads.x, reads.xd, reads.p)[row].reshape(mesh.n_intervals, -1)
    return Profile(degree, values, mesh.segment, mesh.start @ reads.theta, reads.h, not problem.segments[0].event)


def _extrema(profile: Profile) -> Iterator[Extremum]:
    basis = make_basis(profile.degree)
    slopes = profile.values @ basis.differentiate.T
    to_power = np.linalg.inv(np.vander(basis.base, increasing=True))
    to_power_slope = (np.diag(np.arange(1.0, profile.degree + 1), 1)[:-1] @ to_power)
    series = slopes @ _to_chebyshev(profile.degree).T
    may_turn = np.abs(series[:, 0]) <= np.sum(np.abs(series[:, 1:]), axis=1)
    n = len(profile.values)
    for j, values in enumerate(profile.values):
        if may_turn[j]:
            yield from _inside(profile, j, values, to_power_slope @ values)
        if j + 1 == n and not profile.closed:
            continue
        following = (j + 1) % n
        if profile.segment[following] == profile.segment[j]:
            left, right = (_sign(slopes[k], end) for k, end in ((j, -1), (following, 0)))
            if left * right < 0:
                yield _make(profile, j, 1.0, float(values[-1]), left > 0)


def _told_apart(found: list[Extremum], profile: Profile) -> list[Extremum]:
    """Return extrema with those merged that lie together to rounding, and those left out that lie at a segment's ends to rounding.

    An extremum on an edge may show just inside both intervals and once more, the other way round, between them. An odd number
    of them is one extremum, an even number none.
    """
    groups: list[list[Extremum]] = []
    for e in found if profile.closed else [e for e in found if not _at_end(e, profile)]:
        if groups and _together(groups[-1][-1], e, profile, 0.0):
            groups[-1].append(e)
        else:
            groups.append([e])
    if profile.closed and len(groups) > 1 and _together(groups[-1][-1], groups[0][0], profile, float(np.sum(profile.h))):
        groups[0] = [*groups.pop(), *groups[0]]
    return [max(group, key=lambda e: (e.is_max == group[0].is_max, e.value if group[0].is_max else -e.value))
            for group in groups if len(group) % 2]  # fmt: skip


def _at_end(e: Extremum, profile: Profile) -> bool:
    inside = np.flatnonzero(profile.segment == e.segment)
    begin, end = profile.start[inside[0]], profile.start[inside[-1]] + profile.h[inside[-1]]
    return min(e.time - begin, end - e.time) < TOGETHER * profile.h[e.interval]


def _together(a: Extremum, b: Extremum, profile: Profile, period: float) -> bool:
    return a.segment == b.segment and abs(b.time + period - a.time) < TOGETHER * profile.h[a.interval]


def _sign(slopes: Array, end: int) -> int:
    """Return the sign of the slope at an interval's end, or where it is zero there that of the nearest base point where it is not."""
    inward = slopes[::-1] if end == -1 else slopes
    signs = np.sign(inward[np.flatnonzero(inward)[:1]])
    return int(signs[0]) if len(signs) else 0


@cache
def _to_chebyshev(degree: int) -> Array:
    """Return the matrix from values at the base points to Chebyshev coefficients: a slope whose first outweighs the rest has no zero."""
    vander = np.polynomial.chebyshev.chebvander(2.0 * make_basis(degree).base - 1.0, degree)
    return np.asarray(np.linalg.inv(vander), dtype=np.float64)


def _inside(profile: Profile, j: int, values: Array, slope: Array) -> Iterator[Extremum]:
    """Yield the extrema strictly inside interval ``j``; ``slope`` are the power coefficients of the derivative."""
    coefficients = slope[::-1]
    largest = np.max(np.abs(coefficients), initial=0.0)
    if largest == 0.0 or not np.isfinite(largest):
        return
    roots = np.roots(np.where(np.abs(coefficients) > 1e-15 * largest, coefficients, 0.0))
    inside = np.sort(roots.real[(np.abs(roots.imag) < 1e-9) & (roots.real > 0.0) & (roots.real < 1.0)])
    curvature = np.polyder(coefficients)
    for sigma in inside:
        bend = np.polyval(curvature, sigma)
        if bend != 0.0:
            sigma = min(max(sigma - np.polyval(coefficients, sigma) / bend, 0.0), 1.0)
        value = float(make_basis(profile.degree).lagrange(np.array(sigma)) @ values)
        yield _make(profile, j, float(sigma), value, bool(bend < 0))


def _make(profile: Profile, j: int, sigma: float, value: float, is_max: bool) -> Extremum:
    time = float(profile.start[j] + sigma * profile.h[j])
    return Extremum(int(profile.segment[j]), j, sigma, time, value, is_max)
