"""Following a branch: predict, correct, evaluate the test functions, adapt the step, stop with a reason."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Generic

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation.adaptive import solve_adaptively
from pddecont.continuation.arclength import correct, tangent_at
from pddecont.continuation.boundary import (
    Approach,
    Boundary,
    OutOfReachError,
    find_passed,
    find_reached,
    land,
    refuse_out_of_reach,
)
from pddecont.continuation.curve_point import CurvePoint
from pddecont.continuation.locate import BranchSegment
from pddecont.continuation.newton import NewtonSettings, Solution
from pddecont.continuation.system import AdaptiveSystem, E
from pddecont.continuation.termination import End, Termination
from pddecont.continuation.test_functions import (
    SpecialPoint,
    TestFunctions,
    TestValues,
    evaluate_tests,
    find_special_points,
)
from pddecont.errors import ConvergenceError
from pddecont.reasons import NO_REASON, Reason, make_reason

Array = NDArray[np.float64]
# Special points on this first part of a branch's first step are the one that it starts from.
AT_START = 1e-4
# Steps before a boundary where the equations fail become no smaller than this part of the first step: it is come near
# to, not crept up to.
NEAR = 0.02
# Kind of the point at which a branch ends on a boundary.
END_POINT = "EP"
# A step grows where Newton's method needs few iterations and shrinks where it needs many, or the branch bends.
FEW_ITERATIONS, SOME_ITERATIONS = 3, 5
GROW, SHRINK, SHRINK_IN_BEND = 1.5, 0.5, 0.7
BEND = 0.95


@dataclass(frozen=True)
class StepSettings:
    """Arclength steps in scaled unknowns, and what they are adapted to.

    A free parameter's range counts as length one, and so does one typical size of the orbit.
    """

    initial: float = 0.02
    min: float = 1e-6
    max: float = 0.1
    max_points: int = 500
    max_turn: float = 0.3
    newton: NewtonSettings = field(default_factory=lambda: NewtonSettings(max_iterations=8))


@dataclass(frozen=True, eq=False)
class BranchState(Generic[E]):
    """Where a branch stands: all that is needed to go on from here, or to resume. The point's direction is known."""

    point: CurvePoint[E]
    arclength: float
    step: float
    n_points: int

    @property
    def x(self) -> Array:
        """The unknowns."""
        return self.point.x

    @property
    def tangent(self) -> Array:
        """The branch's unit tangent, in the direction in which it is followed."""
        return self.point.tangent


@dataclass(frozen=True, eq=False)
class BranchPoint(Generic[E]):
    """A point of a branch as it is handed out; ``kind`` is empty for an ordinary one, else ``reason`` says more."""

    state: BranchState[E]
    kind: str
    n_iterations: int
    reason: Reason = NO_REASON


def follow_branch(
    state: BranchState[E],
    boundaries: Sequence[Boundary[E]],
    functions: TestFunctions[E],
    settings: StepSettings,
    emit: Callable[[BranchPoint[E]], None],
    sign: int,
) -> Termination:
    """Follow a branch from ``state`` along its tangent, handing each point to ``emit``; return how it ended.

    Parameters
    ----------
    state
        A point on the branch and the direction to go.
    boundaries
        What the branch cannot pass.
    functions
        Test functions, whose changes of sign are located and emitted as special points, and counts, whose changes they
        explain.
    sign
        Sign given to the arclengths of this direction.
    """
    before: TestValues | None = None
    first, n_unexplained = True, 0
    reached_at_start = find_reached(boundaries, state.point, state.tangent)
    if reached_at_start:
        return Termination(*reached_at_start)
    while state.n_points < settings.max_points:
        system = state.point.system.update_reference(state.point.at)
        start = CurvePoint(system, system.at(state.x), None, state.tangent)
        before = before or evaluate_tests(start, functions)
        try:
            reached, step = _advance(start, state.step, settings, boundaries)
        except OutOfReachError as exc:
            return Termination(exc.end, exc.reason, n_unexplained)
        except ConvergenceError as exc:
            return Termination(End.STEP_TOO_SMALL, make_reason("message", text=str(exc)), n_unexplained)
        passed = find_passed(boundaries, Approach.BEYOND, start, reached)
        if passed is not None:
            boundary, k, fraction = passed
            guess = (1.0 - fraction) * reached.system.interpolate_from(system, start.x) + fraction * reached.x
            try:
                reached = land(boundary, k, reached.system, guess, settings.newton)
            except ConvergenceError as exc:
                # A fold next to the boundary: come closer with smaller steps.
                state = replace(state, step=step / 2)
                if state.step < settings.min:
                    return Termination(End.STEP_TOO_SMALL, make_reason("message", text=str(exc)), n_unexplained)
                continue
        scaling = reached.system.scaling
        chord = reached.x - reached.system.interpolate_from(system, start.x)
        length = scaling.length(chord)
        assert reached.solution is not None
        direction = tangent_at(reached.solution, scaling, chord)
        reached = replace(reached, direction=direction)
        after = evaluate_tests(reached, functions)
        segment = BranchSegment(start, reached, settings.newton)
        specials, more = find_special_points(segment, functions, before, after, AT_START if first else 0.0)
        n_unexplained += more
        for special in specials:
            emit(_make_special(special, state, sign * length))
            if special.test.end:
                return Termination(special.test.end, make_reason("kind", kind=special.test.kind), n_unexplained)
        cosine = scaling.dot(direction, chord) / length
        next_step = _next_step(step, reached.n_iterations, cosine, settings)
        state = BranchState(reached, state.arclength + sign * length, next_step, state.n_points + 1)
        limit = find_reached(boundaries, reached, direction)
        emit(BranchPoint(state, END_POINT if limit or passed else "", reached.n_iterations))
        if after.violation and not before.violation:
            return Termination(End.INVALID, after.violation, n_unexplained)
        if limit:
            return Termination(*limit, n_unexplained)
        if passed:
            return Termination(passed[0].end, passed[0].reason(reached.at, passed[1]), n_unexplained)
        before, first = after, False
    return Termination(End.MAX_POINTS, NO_REASON, n_unexplained)


def _make_special(special: SpecialPoint[E], before: BranchState[E], length: float) -> BranchPoint[E]:
    """Return a special point found on the step of signed ``length`` after ``before``."""
    found = special.point
    point = replace(found, direction=found.system.scaling.normalise(found.tangent))
    state = replace(before, point=point, arclength=before.arclength + special.fraction * length)
    return BranchPoint(state, special.test.kind, found.n_iterations, special.test.reason)


def _advance(
    start: CurvePoint[E], step: float, settings: StepSettings, boundaries: Sequence[Boundary[E]]
) -> tuple[CurvePoint[E], float]:
    """Return the next point and the step that reached it; halve the step until the corrector converges."""
    while True:
        try:
            return _take_step(start, step, settings, boundaries), step
        except ConvergenceError as exc:
            near = max(settings.min, NEAR * settings.initial)
            least = near if isinstance(exc, OutOfReachError) else settings.min
            if step <= least:
                raise
            step = max(0.5 * step, least)


def _take_step(
    start: CurvePoint[E], step: float, settings: StepSettings, boundaries: Sequence[Boundary[E]]
) -> CurvePoint[E]:
    """Return the point one step on: predict, make the mesh valid, correct, until the mesh is adequate."""
    predicted = start.system.at(start.x + step * start.tangent)
    refuse_out_of_reach(boundaries, predicted)
    passed = find_passed(boundaries, Approach.UP_TO, start, CurvePoint(start.system, predicted))
    if passed is not None:
        boundary, k, fraction = passed
        last = land(boundary, k, start.system, start.x + fraction * (predicted.x - start.x), settings.newton)
        refuse_out_of_reach(boundaries, last.at)
        return last

    def solve(system: AdaptiveSystem[E], guess: Array, carried: list[Array]) -> Solution[E]:
        prediction, base = carried
        solution = correct(system, prediction, system.scaling.normalise(prediction - base), settings.newton, guess)
        refuse_out_of_reach(boundaries, solution.at)
        if system.scaling.length(solution.x - prediction) > settings.max_turn * step:
            raise ConvergenceError("the branch turns too sharply for this step", solution.history)
        if find_passed(boundaries, Approach.UP_TO, start, CurvePoint(system, solution.at)) is not None:
            raise ConvergenceError("the step leads past the end of the branch", solution.history)
        return solution

    system, solution = solve_adaptively(start.system, predicted.x, solve, [predicted.x, start.x])
    return CurvePoint(system, solution.at, solution)


def _next_step(step: float, n_iterations: int, cosine: float, settings: StepSettings) -> float:
    factor = GROW if n_iterations <= FEW_ITERATIONS else 1.0 if n_iterations <= SOME_ITERATIONS else SHRINK
    if cosine < BEND:
        factor = min(factor, SHRINK_IN_BEND)
    return float(np.clip(factor * step, settings.min, settings.max))
