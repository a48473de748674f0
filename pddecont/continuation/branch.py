"""Following a branch: predict, correct, evaluate the test functions, adapt the step, stop with a reason."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Generic

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation.adaptive import keep_within, solve_adaptively
from pddecont.continuation.arclength import correct, orient
from pddecont.continuation.asymptote import Horizon, find_asymptote
from pddecont.continuation.boundary import (
    Approach,
    Boundary,
    OutOfReachError,
    find_passed,
    find_reached,
    land,
    refuse_out_of_reach,
)
from pddecont.continuation.closure import Home, find_return
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
    find_values_at_start,
)
from pddecont.errors import ConvergenceError
from pddecont.reasons import NO_REASON, Reason, make_reason

Array = NDArray[np.float64]
# Special points on this first part of a branch's first step are the one that it starts from.
AT_START = 1e-4
# Steps before a boundary where the equations fail become no smaller than this part of the first step: it is come near
# to, not crept up to.
NEAR = 0.02
# Kind of the point at which a branch ends on a boundary, or back where it began.
END_POINT = "EP"
# A step is so long that the branch turns by about this angle (radians) from its chord, but no more than so many times
# as long as the last one; it does not grow where Newton's method needs more than few iterations, and shrinks where it
# needs many.
TURN = 0.2
FEW_ITERATIONS, SOME_ITERATIONS = 3, 5
GROW, SHRINK = 2.0, 0.5


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
class ErrorControl(Generic[E]):
    """What keeps errors small: ``measure`` estimates that of a corrected point, which is to be ``tol`` at most."""

    measure: Callable[[CurvePoint[E]], float]
    tol: float


@dataclass(frozen=True, eq=False)
class BranchState(Generic[E]):
    """Where a branch stands: all that is needed to go on from here, or to resume. The point's direction is known.

    ``is_start`` says whether the branch, or a new signature of it, begins here; ``error`` is the point's estimated
    error, where whoever was handed the point has estimated it.
    """

    point: CurvePoint[E]
    arclength: float
    step: float
    n_points: int
    is_start: bool = True
    error: float | None = None

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
    """A point of a branch as it is handed out; ``kind`` is empty for an ordinary one, else ``reason`` says more.

    ``error`` is the point's estimated error where it is known already: of one that equations of its own have found,
    which know it better, and of one whose error was to be small.
    ``n_unexplained`` counts the changes of whole numbers on the step that ends here which no special point accounts
    for.
    """

    state: BranchState[E]
    kind: str
    n_iterations: int
    reason: Reason = NO_REASON
    error: float | None = None
    n_unexplained: int = 0


@dataclass(frozen=True, eq=False)
class _Start:
    """Where a step started, as the mesh of its end has it.

    ``x`` are the unknowns, ``ahead`` is the way from there to the prediction; ``comparable`` says which of them tell
    how far points of the mesh are from there.
    """

    x: Array
    ahead: Array
    comparable: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class _Reached(Generic[E]):
    """The end of a ``step``, and the boundary it was taken back onto.

    ``seen`` is its start, ``error`` its estimated error, where they are known.
    """

    point: CurvePoint[E]
    step: float
    seen: _Start | None = None
    error: float | None = None
    passed: tuple[Boundary[E], int, float] | None = None


def follow_branch(
    state: BranchState[E],
    boundaries: Sequence[Boundary[E]],
    functions: TestFunctions[E],
    settings: StepSettings,
    emit: Callable[[BranchPoint[E]], float | None],
    sign: int,
    home: Home[E] | None = None,
    horizon: Horizon[E] | None = None,
    control: ErrorControl[E] | None = None,
) -> Termination:
    """Follow a branch from ``state`` along its tangent; return how it ended.

    Parameters
    ----------
    state
        A point on the branch and the direction to go.
    emit
        Takes each point; returns its estimated error, or None where it estimates none.
    boundaries
        What the branch cannot pass.
    functions
        Test functions, whose changes of sign are located and emitted as special points, and counts, whose changes they
        explain.
    sign
        Sign given to the arclengths of this direction.
    home
        Where the branch began; it ends where it comes back. None: it is not looked for.
    horizon
        What may grow without bound; it ends along an asymptote. None: none is looked for.
    control
        What points are to be found on finer meshes by. None: the errors of their intervals alone.
    """
    before: TestValues | None = None
    n_unexplained = 0
    if at_start := find_reached(boundaries, state.point, state.tangent):
        return Termination(*at_start)
    while state.n_points < settings.max_points:
        start = _begin_step(state)
        before = find_values_at_start(start, functions, before)
        try:
            found = _find_next(start, state.step, settings, boundaries, control)
        except OutOfReachError as exc:
            return Termination(exc.end, exc.reason, n_unexplained)
        except ConvergenceError as exc:
            return Termination(End.STEP_TOO_SMALL, make_reason("message", text=str(exc)), n_unexplained)
        if found.passed is not None and np.array_equal(found.point.x, start.x):
            # It begins at the end of its range, and was taken back to where it is.
            boundary, k, _ = found.passed
            emit(BranchPoint(state, END_POINT, found.point.n_iterations))
            return Termination(boundary.end, boundary.reason(found.point.at, k), n_unexplained)
        reached, length, turn = _turn_forward(start, found)
        after = evaluate_tests(reached, functions)
        segment = BranchSegment(start, reached, settings.newton)
        specials, more = find_special_points(segment, functions, before, after, AT_START if state.is_start else 0.0)
        closing = find_return(segment, home) if home is not None and state.arclength != 0.0 else None
        n_unexplained += more
        if end := _emit_on_step(segment, specials, closing, more, state, sign * length, emit):
            return replace(end, n_unexplained=n_unexplained)
        next_step = _next_step(found.step, reached.n_iterations, turn, settings)
        state = BranchState(reached, state.arclength + sign * length, next_step, state.n_points + 1, False)
        limit = _find_limit(boundaries, reached, found.passed)
        if horizon is not None and not (limit or after.violation):
            grows = find_asymptote(horizon, start, reached, after, functions, boundaries, settings.newton)
            limit = (End.ASYMPTOTE, grows) if grows else None
        kind = END_POINT if limit else ""
        error = emit(BranchPoint(state, kind, reached.n_iterations, error=found.error, n_unexplained=more))
        state = replace(state, error=error)
        if after.violation and not before.violation:
            return Termination(End.INVALID, after.violation, n_unexplained)
        if limit:
            return Termination(*limit, n_unexplained)
        before = after
    return Termination(End.MAX_POINTS, NO_REASON, n_unexplained)


def _begin_step(state: BranchState[E]) -> CurvePoint[E]:
    """Return the last point as the one that a step starts from and takes as its reference."""
    system = state.point.system.update_reference(state.point.at, state.error)
    return CurvePoint(system, system.at(state.x), None, state.tangent)


def _find_limit(
    boundaries: Sequence[Boundary[E]], reached: CurvePoint[E], passed: tuple[Boundary[E], int, float] | None
) -> tuple[str, Reason] | None:
    """Return how the branch ends at a boundary that a point lies on, or was taken back to; None if it goes on."""
    assert reached.direction is not None
    limit = find_reached(boundaries, reached, reached.direction)
    if limit is None and passed is not None:
        boundary, k, _ = passed
        return boundary.end, boundary.reason(reached.at, k)
    return limit


def _turn_forward(start: CurvePoint[E], found: _Reached[E]) -> tuple[CurvePoint[E], float, float]:
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


def _emit_on_step(
    segment: BranchSegment[E],
    specials: Sequence[SpecialPoint[E]],
    closing: float | None,
    n_unexplained: int,
    before: BranchState[E],
    length: float,
    emit: Callable[[BranchPoint[E]], float | None],
) -> Termination | None:
    """Hand out what is special on the step of signed ``length`` after ``before``; return how that ends the branch.

    Those beyond the part of the step at which the branch is ``closing`` it has had already. A point that ends a branch
    does so by its kind, or by what is wrong beyond it; it takes the step's ``n_unexplained`` with it.
    """
    for special in specials:
        if closing is not None and special.fraction > closing + AT_START:
            continue
        point, test = _make_special(special, before, length), special.test
        emit(replace(point, n_unexplained=n_unexplained) if test.end else point)
        if test.end:
            reason = special.reason if test.end == End.INVALID else make_reason("kind", kind=test.kind)
            return Termination(test.end, reason)
    if closing is None:
        return None
    emit(replace(_make_last(segment, closing, before, length), n_unexplained=n_unexplained))
    return Termination(End.CLOSED)


def _find_next(
    start: CurvePoint[E],
    step: float,
    settings: StepSettings,
    boundaries: Sequence[Boundary[E]],
    control: ErrorControl[E] | None,
) -> _Reached[E]:
    """Return the next point, taken back onto a boundary that it passed."""
    while True:
        found = _advance(start, step, settings, boundaries, control)
        reached = found.point
        passed = find_passed(boundaries, Approach.BEYOND, start, reached)
        if passed is None:
            return found
        boundary, k, fraction = passed
        guess = (1.0 - fraction) * reached.system.interpolate_from(start.system, start.x) + fraction * reached.x
        try:
            landed = land(boundary, k, reached.system, guess, settings.newton)
            return _Reached(landed, found.step, passed=passed)
        except ConvergenceError:
            # A fold next to the boundary: come closer with smaller steps.
            step = found.step / 2
            if step < settings.min:
                raise


def _make_last(segment: BranchSegment[E], fraction: float, before: BranchState[E], length: float) -> BranchPoint[E]:
    """Return the point of a closed branch that is its first, on the step of signed ``length`` after ``before``."""
    found = segment.at(fraction)
    point = replace(found, direction=found.system.scaling.normalise(found.tangent))
    n_points = before.n_points + 1
    state = BranchState(point, before.arclength + fraction * length, before.step, n_points)
    return BranchPoint(state, END_POINT, found.n_iterations)


def _make_special(special: SpecialPoint[E], before: BranchState[E], length: float) -> BranchPoint[E]:
    """Return a special point found on the step of signed ``length`` after ``before``."""
    found = special.point
    point = replace(found, direction=found.system.scaling.normalise(found.tangent))
    state = replace(before, point=point, arclength=before.arclength + special.fraction * length)
    return BranchPoint(state, special.test.kind, found.n_iterations, special.reason)


def _advance(
    start: CurvePoint[E],
    step: float,
    settings: StepSettings,
    boundaries: Sequence[Boundary[E]],
    control: ErrorControl[E] | None,
) -> _Reached[E]:
    """Return the next point, one step on; halve the step until the corrector converges."""
    while True:
        try:
            return _take_step(start, step, settings, boundaries, control)
        except ConvergenceError as exc:
            near = max(settings.min, NEAR * settings.initial)
            least = near if isinstance(exc, OutOfReachError) else settings.min
            if step <= least:
                raise
            step = max(0.5 * step, least)


def _take_step(
    start: CurvePoint[E],
    step: float,
    settings: StepSettings,
    boundaries: Sequence[Boundary[E]],
    control: ErrorControl[E] | None,
) -> _Reached[E]:
    """Return the point one step on: predict, make the mesh valid, correct, until the mesh is adequate."""
    predicted = start.system.at(start.x + step * start.tangent)
    refuse_out_of_reach(boundaries, predicted)
    passed = find_passed(boundaries, Approach.UP_TO, start, CurvePoint(start.system, predicted))
    if passed is not None:
        boundary, k, fraction = passed
        last = land(boundary, k, start.system, start.x + fraction * (predicted.x - start.x), settings.newton)
        refuse_out_of_reach(boundaries, last.at)
        return _Reached(last, step)
    seen: list[_Start] = []

    def solve(system: AdaptiveSystem[E], guess: Array, carried: list[Array]) -> Solution[E]:
        prediction, base = carried
        comparable = np.ones(len(base), dtype=bool)
        if system is not start.system:
            comparable = _find_comparable(system, base)
        seen[:] = [_Start(base, prediction - base, comparable)]
        direction = np.where(comparable, prediction - base, 0.0)
        solution = correct(system, prediction, system.scaling.normalise(direction), settings.newton, guess)
        refuse_out_of_reach(boundaries, solution.at)
        if system.scaling.length(np.where(comparable, solution.x - prediction, 0.0)) > settings.max_turn * step:
            raise ConvergenceError("the branch turns too sharply for this step", solution.history)
        if find_passed(boundaries, Approach.UP_TO, start, CurvePoint(system, solution.at)) is not None:
            raise ConvergenceError("the step leads past the end of the branch", solution.history)
        return solution

    def reach(system: AdaptiveSystem[E], guess: Array, carried: list[Array]) -> _Reached[E]:
        system, solution = solve_adaptively(system, guess, solve, carried)
        point = CurvePoint(system, solution.at, solution)
        return _Reached(point, step, seen[0], None if control is None else control.measure(point))

    def reach_finer(coarse: _Reached[E], error: float) -> _Reached[E]:
        point, seen = coarse.point, coarse.seen
        assert seen is not None
        system = point.system.update_reference(point.at, error)
        return reach(*system.remesh(point.at, [seen.x + seen.ahead, seen.x], solved=True))

    found = reach(start.system, predicted.x, [predicted.x, start.x])
    return found if control is None else keep_within(control.tol, found, lambda f: f.error, reach_finer)


def _look_back(found: _Reached[E], start: CurvePoint[E]) -> _Start:
    """Return where a step started, in the unknowns of the mesh that it led to."""
    system = found.point.system
    x, predicted = (system.interpolate_from(start.system, start.x + way * start.tangent) for way in (0.0, found.step))
    return _Start(x, predicted - x, _find_comparable(system, x))


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


def _next_step(step: float, n_iterations: int, turn: float, settings: StepSettings) -> float:
    """Return the next step after one on which the branch turned by the angle ``turn``."""
    by_curve = TURN / turn if turn > TURN / GROW else GROW
    by_solver = GROW if n_iterations <= FEW_ITERATIONS else 1.0 if n_iterations <= SOME_ITERATIONS else SHRINK
    return float(np.clip(max(min(by_curve, by_solver), SHRINK) * step, settings.min, settings.max))
