"""Points between two points of a branch, and the zero of a test function there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
import scipy.optimize
from numpy.typing import NDArray
from scipy.interpolate import BarycentricInterpolator

from pddecont.continuation.arclength import bordered
from pddecont.continuation.newton import NewtonSettings, Solution
from pddecont.continuation.settling import settled
from pddecont.errors import ConvergenceError

Array = NDArray[np.float64]
FRACTION_TOL = 1e-13
JUMP_TOL = 1e-5
AGREE = 1e-3
# Where interpolation takes its points, from one side to the other, none near the middle.
AROUND = np.array([-1.0, -0.8, -0.55, -0.3, 0.3, 0.55, 0.8, 1.0])


@dataclass(frozen=True, eq=False)
class Located:
    """A point of a branch with the problem that it solves.

    ``direction`` is the tangent there where it is known; a corrected point has it from its last Newton step.
    """

    problem: Any
    x: Array
    solution: Solution | None = None
    direction: Array | None = None

    @property
    def n_iterations(self) -> int:
        """Number of Newton steps that it took."""
        return self.solution.n_iterations if self.solution else 0

    @cached_property
    def tangent(self) -> Array:
        """The branch's tangent, of any length, on the side to which the row that bordered the Jacobian grows."""
        if self.direction is not None:
            return self.direction
        assert self.solution is not None, "only a corrected point knows its tangent"
        last = np.zeros(len(self.x))
        last[-1] = 1.0
        return self.solution.solve(last)


Value: TypeAlias = Callable[[Located], float]


class Chord:
    """Points of the branch between two of its points, by the fraction of the way from one to the other.

    Each is corrected onto the branch in a hyperplane across the chord of the unknowns that no mesh changes, on a mesh of its own
    where it needs one. What has been computed is kept.
    """

    def __init__(self, a: Located, b: Located, settings: NewtonSettings):
        self.settings = settings
        self.known: dict[float, Located] = {0.0: a, 1.0: b}
        self.start, end = a.problem.outline(a.x), b.problem.outline(b.x)
        scale = a.problem.metric().scale[a.problem.outline_index()]
        self.chord = end - self.start
        row = self.chord / scale**2
        self.row = row / np.linalg.norm(row * scale)

    def at(self, fraction: float) -> Located:
        """Return the point at ``fraction``; raise ConvergenceError if there is none to be found."""
        if fraction not in self.known:
            places = np.array(sorted(self.known))
            below, above = float(places[places < fraction].max()), float(places[places > fraction].min())
            part = (fraction - below) / (above - below)
            near, far, part = (below, above, part) if part < 0.5 else (above, below, 1.0 - part)
            problem = self.known[near].problem
            guess = (1.0 - part) * self.known[near].x + part * problem.carry(self.known[far].problem, self.known[far].x)
            level = float(self.row @ (self.start + fraction * self.chord))
            self.known[fraction] = _correct(problem, guess, self.row, level, self.settings)
        return self.known[fraction]

    def zero(self, test: Value, low: float, high: float, f_low: float, f_high: float) -> float | None:
        """Return the fraction between ``low`` and ``high`` at which ``test`` is zero, by Brent's method.

        Where branches cross, points cannot be corrected near the crossing; its place is then interpolated from points around it. None
        where the test function jumps through zero or cannot be followed: there is no special point then.
        """
        ends = {low: f_low, high: f_high}

        def value(fraction: float) -> float:
            result = ends[fraction] if fraction in ends else test(self.at(fraction))
            if not np.isfinite(result):
                raise ConvergenceError("the test function is not defined between two points")
            return result

        try:
            fraction = float(scipy.optimize.brentq(value, low, high, xtol=FRACTION_TOL, rtol=1e-14))
            at_zero = value(fraction)
        except ConvergenceError:
            return self._across(test, low, high)
        return None if abs(at_zero) > JUMP_TOL * max(abs(f_low), abs(f_high)) else fraction


    def _across(self, test: Value, low: float, high: float) -> float | None:
        """Return the zero of ``test`` by interpolation, twice: over the whole way, then nearer; keep the interpolated point."""
        found, width = None, high - low
        for middle, spread in ((0.5 * (low + high), 0.48 * width), (None, 0.12 * width)):
            centre = middle if middle is not None else found
            if centre is None:
                return None
            nodes = centre + spread * AROUND
            better = self._interpolated(test, nodes[(nodes >= low) & (nodes <= high)])
            found = found if better is None else better
        return found

    def _interpolated(self, test: Value, nodes: Array) -> float | None:
        points = []
        for fraction in map(float, nodes):
            try:
                value = test(self.at(fraction))
            except ConvergenceError:
                continue
            if np.isfinite(value):
                points.append((fraction, value))
        change = [i for i in range(len(points) - 1) if points[i][1] * points[i + 1][1] < 0.0]
        if len(points) < 5 or len(change) != 1:
            return None
        places, values = np.array(points).T
        fit = BarycentricInterpolator(places, values)
        left, right = places[change[0]], places[change[0] + 1]
        if fit(left) * fit(right) >= 0.0:
            return None
        root = float(scipy.optimize.brentq(fit, left, right, xtol=FRACTION_TOL))
        # Points on another branch would spoil the fit: without its farthest node it must say the same.
        farthest = int(np.argmax(np.abs(places - root)))
        rest = BarycentricInterpolator(np.delete(places, farthest), np.delete(values, farthest))
        if abs(float(rest(root))) > AGREE * float(np.max(np.abs(values))):
            return None
        near = self.known[float(places[np.argmin(np.abs(places - root))])]
        x = np.stack([near.problem.carry(self.known[float(f)].problem, self.known[float(f)].x) for f in places])
        line = BarycentricInterpolator(places, x)
        step = 1e-3 * (right - left)
        self.known[root] = Located(near.problem, line(root), near.solution, line(root + step) - line(root - step))
        return root


def _correct(problem: Any, guess: Array, outline_row: Array, level: float, settings: NewtonSettings) -> Located:
    def solve(on_mesh: Any, from_: Array) -> Solution:
        row = np.zeros(len(from_))
        row[on_mesh.outline_index()] = outline_row
        return bordered(on_mesh, row, level, from_, on_mesh.metric(), settings)

    problem, solution = settled(problem, guess, solve)
    return Located(problem, solution.x, solution)
