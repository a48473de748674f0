"""Points between two points of a branch, and the zero of a test function there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Generic, TypeAlias

import numpy as np
import scipy.optimize
from numpy.typing import NDArray
from scipy.interpolate import BarycentricInterpolator

from pddecont.continuation.adaptive import solve_adaptively
from pddecont.continuation.arclength import solve_with_row
from pddecont.continuation.curve_point import CurvePoint
from pddecont.continuation.linear import ScaledFactors
from pddecont.continuation.newton import LARGE, NewtonSettings, Solution
from pddecont.continuation.secants import find_zero_between
from pddecont.continuation.system import AdaptiveSystem, E
from pddecont.errors import ConvergenceError

Array = NDArray[np.float64]
# How exactly a zero is located, as a fraction of the step: rounding.
FRACTION_TOL = 1e-13
# A test function larger than this at its zero, relative to its values at the step's ends, jumps through zero.
JUMP_TOL = 1e-5
# Interpolations with and without one node must agree to this, relative to the largest value.
AGREE = 1e-3
# Where interpolation takes its points, from one side to the other, none near the middle.
AROUND = np.array([-1.0, -0.8, -0.55, -0.3, 0.3, 0.55, 0.8, 1.0])
# How far from a zero that is known roughly, or nearly, points are taken, in parts of the way.
NEARER, NEAR = 0.12, (0.0075, 0.03, 0.12)
# How far to each side of a zero its tangent is taken, as a fraction of the way between the nearest nodes.
TANGENT_STEP = 1e-3
Value: TypeAlias = Callable[[CurvePoint[E]], float]


class BranchSegment(Generic[E]):
    """Points of the branch between two of its points, by the fraction of the way from one to the other.

    Each is corrected onto the branch in a hyperplane across the chord of the unknowns that no mesh changes, on a mesh
    of its own where it needs one. What has been computed is kept.
    """

    def __init__(self, a: CurvePoint[E], b: CurvePoint[E], settings: NewtonSettings):
        self.settings = settings
        self.known: dict[float, CurvePoint[E]] = {0.0: a, 1.0: b}
        self.start, end = a.mesh_independent_unknowns, b.mesh_independent_unknowns
        scale = a.system.scaling.scale[a.system.mesh_independent_index]
        self.chord = end - self.start
        row = self.chord / scale**2
        self.row = row / np.linalg.norm(row * scale)
        self._factored: CurvePoint[E] | None = None

    def at(self, fraction: float) -> CurvePoint[E]:
        """Return the point at ``fraction``; raise ConvergenceError if there is none to be found."""
        if fraction not in self.known:
            places = np.array(sorted(self.known))
            below, above = float(places[places < fraction].max()), float(places[places > fraction].min())
            part = (fraction - below) / (above - below)
            near, far, part = (below, above, part) if part < 0.5 else (above, below, 1.0 - part)
            a, b = self.known[near], self.known[far]
            guess = (1.0 - part) * a.x + part * a.system.interpolate_from(b.system, b.x)
            level = float(self.row @ (self.start + fraction * self.chord))
            self.known[fraction] = self._correct(a.system, guess, level)
        return self.known[fraction]

    def cross(self, fraction: float, low: float, high: float) -> CurvePoint[E]:
        """Return the point at ``fraction`` with its tangent from points on both sides: branches cross there."""
        point, step = self.at(fraction), TANGENT_STEP * (high - low)
        if point.direction is not None:
            return point
        try:
            beside = [self.at(max(fraction - step, low)), self.at(min(fraction + step, high))]
        except ConvergenceError:
            return point
        ends = [point.system.interpolate_from(p.system, p.x) for p in beside]
        return replace(point, direction=ends[1] - ends[0])

    def find_zero(self, test: Value[E], low: float, high: float, f_low: float, f_high: float) -> float | None:
        """Return the fraction between ``low`` and ``high`` at which ``test`` is zero.

        Where branches cross, points cannot be corrected near the crossing; its place is then interpolated from points
        around it, all of them near it where the zero was nearly reached before. None where the test function jumps
        through zero or cannot be followed: there is no special point then. It is looked for between points that are
        known already: other test functions are often zero at the same place.
        """
        values: dict[float, float] = {}

        def value(fraction: float) -> float:
            result = test(self.at(fraction))
            if not np.isfinite(result):
                raise ConvergenceError("the test function is not defined between two points")
            values[fraction] = abs(result)
            return result

        try:
            bracket = self._narrow(value, low, high, f_low, f_high)
            fraction, at_zero = find_zero_between(value, *bracket, FRACTION_TOL)
        except ConvergenceError:
            near = min(values, key=values.__getitem__, default=None)
            if near is None or values[near] > AGREE * max(abs(f_low), abs(f_high)):
                return self._interpolate_across(test, low, high)
            return self._interpolate_near(test, near, low, high)
        return None if abs(at_zero) > JUMP_TOL * max(abs(f_low), abs(f_high)) else fraction

    def _narrow(
        self, value: Callable[[float], float], low: float, high: float, f_low: float, f_high: float
    ) -> tuple[float, float, float, float]:
        """Return two neighbours among the known points from ``low`` to ``high`` with a zero between, and its values.

        Points where the function has no value are left out.
        """
        known = sorted(fraction for fraction in self.known if low < fraction < high)
        while known:
            middle = known.pop(len(known) // 2)
            try:
                f_middle = value(middle)
            except ConvergenceError:
                continue
            if (f_middle > 0.0) == (f_low > 0.0):
                low, f_low = middle, f_middle
            else:
                high, f_high = middle, f_middle
            known = [fraction for fraction in known if low < fraction < high]
        return low, high, f_low, f_high

    def _correct(self, system: AdaptiveSystem[E], guess: Array, level: float) -> CurvePoint[E]:
        def solve(on_mesh: AdaptiveSystem[E], start: Array, _: list[Array]) -> Solution[E]:
            row = np.zeros(len(start))
            row[on_mesh.mesh_independent_index] = self.row
            return solve_with_row(on_mesh, row, level, start, self.settings, self._find_factors(on_mesh))

        near = self._factored
        system, solution = solve_adaptively(system, guess, solve)
        point: CurvePoint[E] = CurvePoint(system, solution.at, solution)
        if len(point.x) < LARGE:
            return point
        if near is not None and near.solution is not None and near.solution.factors is solution.factors:
            return point
        # Dozens of points are kept here, and the factors of the last one.
        self._factored = point
        return point.without_factors()

    def _find_factors(self, system: AdaptiveSystem[E]) -> ScaledFactors | None:
        """Return the factors of the last Jacobian that was factored here, if the system has the same unknowns."""
        point = self._factored
        if point is None or point.solution is None or system.interpolate_from(point.system, point.x) is not point.x:
            return None
        return point.solution.factors

    def _interpolate_across(self, test: Value[E], low: float, high: float) -> float | None:
        """Return the zero of ``test`` by interpolation, over the whole way, then nearer; keep the point there."""
        found = self._interpolate_around(test, 0.5 * (low + high), 0.48 * (high - low), low, high)
        if found is None:
            return None
        better = self._interpolate_around(test, found, NEARER * (high - low), low, high)
        return found if better is None else better

    def _interpolate_near(self, test: Value[E], near: float, low: float, high: float) -> float | None:
        """Return the zero of ``test`` beside the place ``near`` it by interpolation, as near as it can; keep the point.

        Farther away a pole beside the zero would spoil it.
        """
        for spread in NEAR:
            found = self._interpolate_around(test, near, spread * (high - low), low, high)
            if found is not None:
                return found
        return None

    def _interpolate_around(
        self, test: Value[E], centre: float, spread: float, low: float, high: float
    ) -> float | None:
        """Return the zero of ``test`` by interpolation from points up to ``spread`` away from a place; None if none."""
        nodes = centre + spread * AROUND
        return self._interpolate(test, nodes[(nodes >= low) & (nodes <= high)])

    def _interpolate(self, test: Value[E], nodes: Array) -> float | None:
        """Return the zero of the polynomial through the values of ``test`` at ``nodes``; None where there is none."""
        sampled = []
        for fraction in map(float, nodes):
            try:
                value = test(self.at(fraction))
            except ConvergenceError:
                continue
            if np.isfinite(value):
                sampled.append((fraction, value))
        change = [i for i in range(len(sampled) - 1) if sampled[i][1] * sampled[i + 1][1] < 0.0]
        if len(sampled) < 5 or len(change) != 1:
            return None
        places, values = np.array(sampled).T
        fit = _interpolate_through(places, values)
        left, right = float(places[change[0]]), float(places[change[0] + 1])
        if fit(left) * fit(right) >= 0.0:
            return None
        root = float(scipy.optimize.brentq(fit, left, right, xtol=FRACTION_TOL))
        # Points on another branch would spoil the fit: without its farthest node it must say the same.
        farthest = int(np.argmax(np.abs(places - root)))
        rest = _interpolate_through(np.delete(places, farthest), np.delete(values, farthest))
        if abs(float(rest(root))) > AGREE * float(np.max(np.abs(values))):
            return None
        self._keep_interpolated(root, places, TANGENT_STEP * (right - left))
        # What the values say must hold at the point itself, which is interpolated apart from them.
        try:
            holds = abs(test(self.known[root])) <= AGREE * float(np.max(np.abs(values)))
        except ConvergenceError:
            holds = False
        if not holds:
            del self.known[root]
            return None
        return root

    def _keep_interpolated(self, fraction: float, places: Array, step: float) -> None:
        """Keep the point at ``fraction`` of the polynomial through the points at ``places``, with its tangent."""
        near = self.known[float(places[np.argmin(np.abs(places - fraction))])]
        known: list[CurvePoint[Any]] = [self.known[float(f)] for f in places]
        line = _interpolate_through(places, np.stack([near.system.interpolate_from(p.system, p.x) for p in known]))
        direction = line(fraction + step) - line(fraction - step)
        self.known[fraction] = CurvePoint(near.system, near.system.at(line(fraction)), near.solution, direction)


def _interpolate_through(places: Array, values: Array) -> BarycentricInterpolator:
    """Return the polynomial through ``values`` (n, ...) at ``places`` (n,).

    Its weights are given: scipy would multiply their factors in an order by chance, which tells in the last digits.
    """
    differences = (places[:, None] - places) / np.ptp(places)
    np.fill_diagonal(differences, 1.0)
    return BarycentricInterpolator(places, values, wi=1.0 / np.prod(differences, axis=1))
