"""Following a branch: test functions are evaluated and special points handed out, step by step, until it ends."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Generic

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation.asymptote import Horizon, find_asymptote
from pddecont.continuation.boundary import Boundary, OutOfReachError, find_reached
from pddecont.continuation.closure import Home, find_return
from pddecont.continuation.curve_point import CurvePoint
from pddecont.continuation.locate import BranchSegment
from pddecont.continuation.predictor_corrector import StepSettings, find_next, find_next_step, turn_forward
from pddecont.continuation.system import E
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
# Kind of the point at which a branch ends on a boundary, or back where it began.
END_POINT = "EP"


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


def follow_branch(
    state: BranchState[E],
    boundaries: Sequence[Boundary[E]],
    functions: TestFunctions[E],
    settings: StepSettings,
    emit: Callable[[BranchPoint[E]], float | None],
    sign: int,
    home: Home[E] | None = None,
    horizon: Horizon[E] | None = None,
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
    """
    before: TestValues | None = None
    n_unexplained = 0
    if at_start := find_reached(boundaries, state.point, state.tangent):
        return Termination(*at_start)
    while state.n_points < settings.max_points:
        start = _begin_step(state)
        before = find_values_at_start(start, functions, before)
        try:
            found = find_next(start, state.step, settings, boundaries)
        except ConvergenceError as exc:
            return _end_by(exc, n_unexplained)
        if found.passed is not None and np.array_equal(found.point.x, start.x):
            # It begins at the end of its range, and was taken back to where it is.
            boundary, k, _ = found.passed
            emit(BranchPoint(state, END_POINT, found.point.n_iterations))
            return Termination(boundary.end, boundary.reason(found.point.at, k), n_unexplained)
        reached, length, turn = turn_forward(start, found)
        after = evaluate_tests(reached, functions)
        segment = BranchSegment(start, reached, settings.newton)
        specials, more = find_special_points(segment, functions, before, after, AT_START if state.is_start else 0.0)
        closing = find_return(segment, home) if home is not None and state.arclength != 0.0 else None
        n_unexplained += more
        if end := _emit_on_step(segment, specials, closing, more, state, sign * length, emit):
            return replace(end, n_unexplained=n_unexplained)
        next_step = find_next_step(found.step, reached.n_iterations, turn, settings)
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


def _end_by(exc: ConvergenceError, n_unexplained: int) -> Termination:
    """Return how a branch ends that has no next point."""
    if isinstance(exc, OutOfReachError):
        return Termination(exc.end, exc.reason, n_unexplained)
    return Termination(End.STEP_TOO_SMALL, make_reason("message", text=str(exc)), n_unexplained)


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
