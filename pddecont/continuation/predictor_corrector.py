"""One step along a branch: predict, correct on a mesh that is fine enough, measure how the branch turned."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Generic

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation.adaptive import keep_within, solve_adaptively
from pddecont.continuation.arclength import correct, orient
from pddecont.continuation.boundary import Approach, Boundary, OutOfReachError, find_passed, land, refuse_out_of_reach
from pddecont.continuation.curve_point import CurvePoint
from pddecont.continuation.newton import NewtonSettings, Solution
from pddecont.continuation.system import AdaptiveSystem, E
from pddecont.errors import ConvergenceError

Array = NDArray[np.float64]
# Steps before a boundary where the equations fail become no smaller than this part of the first step: it is come near
# to, not crept up to.
NEAR = 0.02
# A step is so long that the branch turns by about this angle (radians) from its chord, but no more than so many times
# as long as the last one; it does not grow where Newton's method needs more than few iterations, and shrinks where it
# needs many.
TURN = 0.2
FEW_ITERATIONS, SOME_ITERATIONS = 3, 5
GROW, SHRINK = 2.0, 0.5


@dataclass(frozen=True, eq=False)
class ErrorControl(Generic[E]):
    """What keeps errors small: ``measure`` estimates that of a corrected point, which is to be ``tol`` at most."""

    measure: Callable[[CurvePoint[E]], float]
    tol: float


@dataclass(frozen=True)
class StepSettings:
    """Arclength steps in scaled unknowns, and what they are adapted to.

    A free parameter's range counts as length one, and so does one typical size of the orbit. ``control`` says when
    points are found again on finer meshes (None: the errors of their intervals alone do).
    """

    initial: float = 0.02
    min: float = 1e-6
    max: float = 0.1
    max_points: int = 500
    max_turn: float = 0.3
    newton: NewtonSettings = field(default_factory=lambda: NewtonSettings(max_iterations=8))
    control: ErrorControl[Any] | None = None


@dataclass(frozen=True, eq=False)
class StepStart:
    """Where a step started, as the mesh of its end has it.

    ``x`` are the unknowns, ``ahead`` is the way from there to the prediction; ``comparable`` says which of them tell
    how far points of the mesh are from there.
    """

    x: Array
    ahead: Array
    comparable: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Reached(Generic[E]):
    """The end of a ``step``, and the boundary it was taken back onto.

    ``seen`` is its start, ``error`` its estimated error, where they are known.
    """

    point: CurvePoint[E]
    step: float
    seen: StepStart | None = None
    error: float | None = None
    passed: tuple[Boundary[E], int, float] | None = None


def find_next(
    start: CurvePoint[E], step: float, settings: StepSettings, boundaries: Sequence[Boundary[E]]
) -> Reached[E]:
    """Return the next point, taken back onto a boundary that it passed."""
    while True:
        found = _advance(start, step, settings, boundaries)
        reached = found.point
        passed = find_passed(boundaries, Approach.BEYOND, start, reached)
        if passed is None:
            return found
        boundary, k, fraction = passed
        guess = (1.0 - fraction) * reached.system.interpolate_from(start.system, start.x) + fraction * reached.x
        try:
            landed = land(boundary, k, reached.system, guess, settings.newton)
            return Reached(landed, found.step, passed=passed)
        except ConvergenceError:
            # A fold next to the boundary: come closer with smaller steps.
            step = found.step / 2
            if step < settings.min:
                raise


def _advance(
    start: CurvePoint[E], step: float, settings: StepSettings, boundaries: Sequence[Boundary[E]]
) -> Reached[E]:
    """Return the next point, one step on; halve the step until the corrector converges."""
    while True:
        try:
            return _take_step(start, step, settings, boundaries)
        except ConvergenceError as exc:
            near = max(settings.min, NEAR * settings.initial)
            least = near if isinstance(exc, OutOfReachError) else settings.min
            if step <= least:
                raise
            step = max(0.5 * step, least)


def _take_step(
    start: CurvePoint[E], step: float, settings: StepSettings, boundaries: Sequence[Boundary[E]]
) -> Reached[E]:
    """Return the point one step on: predict, make the mesh valid, correct, until the mesh is adequate."""
    predicted = start.system.at(start.x + step * start.tangent)
    refuse_out_of_reach(boundaries, predicted)
    passed = find_passed(boundaries, Approach.UP_TO, start, CurvePoint(start.system, predicted))
    if passed is not None:
        boundary, k, fraction = passed
        last = land(boundary, k, start.system, start.x + fraction * (predicted.x - start.x), settings.newton)
        refuse_out_of_reach(boundaries, last.at)
        return Reached(last, step)
    seen: list[StepStart] = []
    control: ErrorControl[E] | None = settings.control

    def solve(system: AdaptiveSystem[E], guess: Array, carried: list[Array]) -> Solution[E]:
        prediction, base = carried
        comparable = np.ones(len(base), dtype=bool)
        if system is not start.system:
            comparable = _find_comparable(system, base)
        seen[:] = [StepStart(base, prediction - base, comparable)]
        direction = np.where(comparable, prediction - base, 0.0)
        solution = correct(system, prediction, system.scaling.normalise(direction), settings.newton, guess)
        refuse_out_of_reach(boundaries, solution.at)
        if system.scaling.length(np.where(comparable, solution.x - prediction, 0.0)) > settings.max_turn * step:
            raise ConvergenceError("the branch turns too sharply for this step", solution.history)
        if find_passed(boundaries, Approach.UP_TO, start, CurvePoint(system, solution.at)) is not None:
            raise ConvergenceError("the step leads past the end of the branch", solution.history)
        return solution

    def reach(system: AdaptiveSystem[E], guess: Array, carried: list[Array]) -> Reached[E]:
        system, solution = solve_adaptively(system, guess, solve, carried)
        point = CurvePoint(system, solution.at, solution)
        return Reached(point, step, seen[0], None if control is None else control.measure(point))

    def reach_finer(coarse: Reached[E], error: float) -> Reached[E]:
        point, seen = coarse.point, coarse.seen
        assert seen is not None
        system = point.system.update_reference(point.at, error)
        return reach(*system.remesh(point.at, [seen.x + seen.ahead, seen.x], solved=True))

    found = reach(start.system, predicted.x, [predicted.x, start.x])
    return found if control is None else keep_within(control.tol, found, lambda f: f.error, reach_finer)


def _look_back(found: Reached[E], start: CurvePoint[E]) -> StepStart:
    """Return where a step started, in the unknowns of the mesh that it led to."""
    system = found.point.system
    x, predicted = (system.interpolate_from(start.system, start.x + way * start.tangent) for way in (0.0, found.step))
    return StepStart(x, predicted - x, _find_comparable(system, x))


def _find_comparable(system: AdaptiveSystem[E], x: Array) -> NDArray[np.bool_]:
    """Return which unknowns at ``x`` tell how far points of this mesh are from there.

    Where the mesh does not hold at ``x``, its breaking points are there in another order, and values at points between
    two that changed places are those of other parts of the solution.
    """
    if system.mesh_is_valid(system.at(x)):
        return np.ones(len(x), dtype=bool)
    comparable = np.zeros(len(x), dtype=bool)
    comparable[system.order_independent_index] = True
    return comparable


def turn_forward(start: CurvePoint[E], found: Reached[E]) -> tuple[CurvePoint[E], float, float]:
    """Return the end of a step with the branch's direction there, the step's length, and how much the branch turns.

    That is the larger of the angles (radians) that the step's chord makes with the directions at its ends: by one the
    corrected point lies off the predicted one, by the other the next prediction starts out.
    """
    reached, seen = found.point, found.seen or _look_back(found, start)
    scaling, chord = reached.system.scaling, reached.x - seen.x
    along = np.where(seen.comparable, chord, 0.0)
    direction = orient(reached.tangent, scaling, along)
    turn = max(scaling.find_angle(np.where(seen.comparable, v, 0.0), along) for v in (seen.ahead, direction))
    return replace(reached, direction=direction), scaling.length(chord), turn


def find_next_step(step: float, n_iterations: int, turn: float, settings: StepSettings) -> float:
    """Return the next step after one on which the branch turned by the angle ``turn``."""
    by_curve = TURN / turn if turn > TURN / GROW else GROW
    by_solver = GROW if n_iterations <= FEW_ITERATIONS else 1.0 if n_iterations <= SOME_ITERATIONS else SHRINK
    return float(np.clip(max(min(by_curve, by_solver), SHRINK) * step, settings.min, settings.max))
