"""Whether a branch runs along an asymptote: a quantity grows without bound while the parameters tend to limits.

Along p = p_0 + C g^-k, or p_0 + C exp(-k g), the slope dp / d(log g) falls at least like a power of what grows, g, and
never changes its sign. Points of a branch alone cannot tell this from a sharp fold that is yet to come or from a
resonance with little damping, so where the slope has become small the branch is looked along ahead of its steps: orbits
with g fixed are solved for, each so many times as large as the one before, until g has grown a thousandfold. Any of
them that is not to be found, on which something else happens, or that does not come nearer to the limit says that there
is no asymptote. An exponential, of which so much growth leaves no digits of p, is known by its rate: that stays the
same while g grows and p comes to rest, as it does near a saddle, whereas the parameter of orbits that explode (canards)
comes to rest at rates that change, and they grow little meanwhile. Each slope gives an estimate of the limit; the last
ones tell how good it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation.adaptive import solve_adaptively
from pddecont.continuation.arclength import find_tangent, solve_with_row, tangent_at
from pddecont.continuation.boundary import Approach, Boundary, E_contra, refuse_out_of_reach
from pddecont.continuation.curve_point import CurvePoint
from pddecont.continuation.newton import NewtonSettings, Solution
from pddecont.continuation.system import AdaptiveSystem, E
from pddecont.continuation.test_functions import TestFunctions, TestValues, evaluate_tests
from pddecont.errors import ConvergenceError
from pddecont.reasons import Reason

Array = NDArray[np.float64]
# A slope below this part of the way from the branch's beginning is small; it is looked ahead wherever it falls by the
# next factor.
SMALL, FACTOR = 0.05, 4.0
# A slope below this part of the range, times the growth since the look ahead began, is lost among the errors of points:
# the parameters no longer move.
RESOLVED = 1e-6
# No limit is known better than to this part of the range.
ROUNDING = 1e-12
# Growth that shows that there is no bound.
ENOUGH = 1000.0
# An exponential's rate stays the same to this part while what grows becomes this many times as large.
SAME_RATE, LONG = 0.05, 1.5
# The slope falls at least like the growth to the power of minus this.
LEAST_POWER = 0.1
# Logarithms of the growth from one orbit that is looked at to the next: the first, the largest, the smallest.
FIRST, LARGEST, SMALLEST = np.log(1.2), np.log(2.0), np.log(1.03)
# The logarithm of the slope falls by no more than this from one to the next.
FALL = 2.0


class Horizon(Protocol[E_contra]):
    """What may grow without bound along a branch that began with the free parameters ``origin``."""

    @property
    def origin(self) -> Array:
        """The free parameters at the branch's first point, shape (n_free,)."""
        ...

    def sizes(self, at: E_contra) -> Array:
        """Return the quantities, shape (n_quantities,); none is negative."""
        ...

    def rows(self, at: E_contra) -> Array:
        """Return rows (n_quantities, n_unknowns) whose products with the unknowns at ``at`` are the quantities."""
        ...

    def find_parameters(self, at: E_contra) -> slice:
        """Return the places of the free parameters among the unknowns."""
        ...

    def is_lost(self, violation: Reason) -> bool:
        """Return whether a violation says no more than that a simulation could not keep to a point."""
        ...

    def reason(self, at: E_contra, k: int, limits: Array, errors: Array) -> Reason:
        """Return what it means that quantity ``k`` grows while the free parameters tend to ``limits``."""
        ...


@dataclass(frozen=True, eq=False)
class Slope:
    """How fast the parameters move while quantity ``k`` grows: ``rates`` are their derivatives in its logarithm.

    ``size`` is their length in parts of the ranges, ``way`` that of the way from the branch's beginning.
    """

    k: int
    quantity: float
    parameters: Array
    rates: Array
    size: float
    way: float

    @property
    def steepness(self) -> float:
        """The derivative of the parameters in what grows itself, in parts of the ranges."""
        return self.size / self.quantity

    @property
    def level(self) -> int:
        """How often the slope has fallen by the factor at which it is looked ahead; negative where it is not small."""
        return int(np.floor(np.log(SMALL * self.way / max(self.size, RESOLVED)) / np.log(FACTOR))) if self.way else -1


def find_asymptote(
    horizon: Horizon[E],
    before: CurvePoint[E],
    after: CurvePoint[E],
    values: TestValues,
    functions: TestFunctions[E],
    boundaries: Sequence[Boundary[E]],
    settings: NewtonSettings,
) -> Reason | None:
    """Return what grows without bound beyond the step from ``before`` to ``after``; None where nothing is seen to.

    ``values`` are those of the ``functions`` at ``after``. The step alone decides whether it is looked ahead, so that a
    branch that is resumed there ends where it would have ended.
    """
    slope = _find_slope(horizon, after)
    if slope is None or slope.size < RESOLVED or slope.level < 0:
        return None
    earlier = _find_slope(horizon, before, slope.k)
    if earlier is not None and earlier.level >= slope.level:
        return None
    slopes = _look_ahead(horizon, after, slope, values, functions, boundaries, settings)
    if slopes is None:
        return None
    extrapolate = _extrapolate_exponential if _falls_exponentially(slopes) else _extrapolate_power
    limits = np.array([extrapolate(*pair) for pair in zip(slopes[-3:-1], slopes[-2:], strict=True)])
    rounding = ROUNDING * after.system.scaling.scale[horizon.find_parameters(after.at)]
    errors = np.maximum(2.0 * np.abs(limits[1] - limits[0]), rounding)
    return horizon.reason(after.at, slope.k, limits[-1], errors)


def _find_slope(horizon: Horizon[E], point: CurvePoint[E], k: int | None = None) -> Slope | None:
    """Return the slope where the branch goes on from a point, of what grows fastest or of quantity ``k``.

    None where it does not grow.
    """
    x, direction, free = point.x, point.tangent, horizon.find_parameters(point.at)
    sizes, rows = horizon.sizes(point.at), horizon.rows(point.at)
    growth = np.where(sizes > 0.0, rows @ direction / np.where(sizes > 0.0, sizes, 1.0), -np.inf)
    k = int(np.argmax(growth)) if k is None else k
    if not growth[k] > 0.0:
        return None
    rates = direction[free] / growth[k]
    size, way = (float(np.linalg.norm(v / point.system.scaling.scale[free])) for v in (rates, x[free] - horizon.origin))
    return Slope(k, float(sizes[k]), x[free], rates, size, way)


def _look_ahead(
    horizon: Horizon[E],
    point: CurvePoint[E],
    slope: Slope,
    values: TestValues,
    functions: TestFunctions[E],
    boundaries: Sequence[Boundary[E]],
    settings: NewtonSettings,
) -> list[Slope] | None:
    """Return the slopes at points ever farther ahead; None where they show no asymptote."""
    slopes, step = [slope], FIRST
    while slopes[-1].quantity < ENOUGH * slope.quantity:
        grown = slopes[-1].quantity / slope.quantity
        # Unknowns grow, and so do rounding errors.
        at_size = replace(settings, step_tol=settings.step_tol * grown, residual_tol=settings.residual_tol * grown)
        try:
            ahead = _find_ahead(horizon, point, slope.k, float(np.exp(step)), boundaries, at_size)
            there = _find_slope(horizon, ahead, slope.k)
        except ConvergenceError:
            step *= 0.5
            if step < SMALLEST:
                return None
            continue
        if there is None:
            return None
        moves = there.size > RESOLVED * there.quantity / slope.quantity
        if not moves and _falls_exponentially(slopes):
            return slopes
        if moves and not _comes_nearer(slopes[-1], there):
            return None
        if not _is_undisturbed(horizon, ahead, moves, values, functions, boundaries):
            return None
        slopes.append(there)
        point, step = ahead, min(1.5 * step, LARGEST, FALL / _find_power(*slopes[-2:]) if moves else LARGEST)
    return slopes


def _find_ahead(
    horizon: Horizon[E],
    point: CurvePoint[E],
    k: int,
    factor: float,
    boundaries: Sequence[Boundary[E]],
    settings: NewtonSettings,
) -> CurvePoint[E]:
    """Return the point of the branch at which quantity ``k`` is ``factor`` times what it is at ``point``.

    Raises
    ------
    ConvergenceError
        If it is not found, or the way there leads where there are no equations.
    """
    system = point.system.update_reference(point.at)
    row, level = horizon.rows(point.at)[k], factor * float(horizon.sizes(point.at)[k])

    def solve(on_mesh: AdaptiveSystem[E], start: Array, _: list[Array]) -> Solution[E]:
        return solve_with_row(on_mesh, horizon.rows(on_mesh.at(start))[k], level, start, settings)

    along = point.tangent / float(row @ point.tangent)
    guess = point.x + (level - float(row @ point.x)) * along
    refuse_out_of_reach(boundaries, system.at(guess))
    system, solution = solve_adaptively(system, guess, solve)
    towards = tangent_at(solution, system.scaling, system.scaling.size * horizon.rows(solution.at)[k])
    return CurvePoint(system, solution.at, solution, find_tangent(solution.at, system.scaling, towards))


def _comes_nearer(before: Slope, after: Slope) -> bool:
    """Return whether the parameters come nearer to limits from one point ahead to the next."""
    falls = after.size < before.size * (after.quantity / before.quantity) ** -LEAST_POWER
    return falls and float(np.dot(before.rates, after.rates)) > 0.0


def _is_undisturbed(
    horizon: Horizon[E],
    point: CurvePoint[E],
    moves: bool,
    values: TestValues,
    functions: TestFunctions[E],
    boundaries: Sequence[Boundary[E]],
) -> bool:
    """Return whether nothing else happens to the branch up to a point ahead.

    Where the parameters no longer move (not ``moves``) their rounding errors decide where a motion leaves the saddle
    that it passes: counts of multipliers and simulations say nothing there.
    """
    if any(np.any(b.margins(point.at) <= 0.0) for b in boundaries if b.approach is not Approach.UP_TO):
        return False
    found = evaluate_tests(point, functions)
    crossed = any(f0 * f1 < 0.0 for f0, f1 in zip(values.values, found.values, strict=True))
    changed = found.counts != values.counts or (bool(found.violation) and not horizon.is_lost(found.violation))
    return not crossed and not (changed and moves)


def _find_power(before: Slope, after: Slope) -> float:
    """Return the power of what grows by which the slope falls."""
    return float(np.log(before.size / after.size) / np.log(after.quantity / before.quantity))


def _falls_exponentially(slopes: Sequence[Slope]) -> bool:
    """Return whether the parameters come to rest at a rate that stays the same while what grows becomes much larger."""
    if len(slopes) < 4 or slopes[-1].quantity < LONG * slopes[0].quantity:
        return False
    rates = [float(np.log(a.steepness / b.steepness)) / (b.quantity - a.quantity) for a, b in pairwise(slopes)]
    return max(rates) - min(rates) < SAME_RATE * max(rates)


def _extrapolate_power(before: Slope, after: Slope) -> Array:
    """Return the limits of the parameters, from the power of what grows by which their slopes fall."""
    grown = np.log(after.quantity / before.quantity)
    with np.errstate(divide="ignore", invalid="ignore"):
        power = -np.log(after.rates / before.rates) / grown
    rest = np.where(np.isfinite(power) & (power > LEAST_POWER), after.rates / power, 0.0)
    return np.asarray(after.parameters + rest)


def _extrapolate_exponential(before: Slope, after: Slope) -> Array:
    """Return the limits of the parameters, from the rate at which they come to rest."""
    rate = np.log(before.steepness / after.steepness) / (after.quantity - before.quantity)
    return np.asarray(after.parameters + after.rates / (after.quantity * rate))
