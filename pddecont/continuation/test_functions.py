"""Special points on a step of a branch: test functions, counts of whole numbers, and what happened in between."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Generic

from pddecont.continuation.curve_point import CurvePoint
from pddecont.continuation.locate import BranchSegment
from pddecont.continuation.system import E
from pddecont.continuation.termination import End
from pddecont.errors import ConvergenceError
from pddecont.reasons import NO_REASON, WITHIN, Reason

# How often a step is halved to tell changes of counts apart that came together.
MAX_CUTS = 10
# How often a step is halved for the point at which its problem ceases to be solved.
MAX_HALVINGS = 36
# Where in between is tried in turn; a point within this part of a step is located.
PARTS, LOCATED = (0.5, 0.3, 0.7, 0.1, 0.9), 1e-6
# How far short of a point that ends the branch its counts are taken and the problem has to be solved, as a fraction of
# the way there.
SHORT = 1e-6
# Where else short of such a point others are looked for that the step's end hides.
FARTHER = (0.02, 0.2)
# So near to the last point that solves the problem, as a fraction of the step, a test function is looked for that says
# which one it is.
NEAR_END = 1e-3
# At this fraction of its first step a branch has left the special point that it comes from.
PAST_START = 0.05
# Zeros nearer than so many decimals of a step fall together; the one that ends the branch comes first.
TOGETHER_DECIMALS = 6


def find_no_objection(_: CurvePoint[Any]) -> bool:
    """Return that a point is what its kind says."""
    return True


@dataclass(frozen=True)
class TestFunction(Generic[E]):
    """A function along the branch whose zero is a special point of ``kind``.

    ``reason`` says more of the point. Where ``end`` is not empty the branch ends there, with this code.
    ``find_meeting`` finds the point itself between two points with a change of sign, or None: where a branch meets
    another one, no point between the two can be found on the way and no count can be trusted. ``crosses``: branches
    cross at its zeros, so that the equations there do not say which direction is the branch's. ``smooth`` has the same
    sign and no kinks; the zero is looked for with it where ``value`` does not lead there. ``explain`` returns what is
    said of a point instead of ``reason``. ``holds`` says whether a point is what its kind says, where a zero that is as
    small as the values on both sides let it be does not.
    """

    __test__ = False
    kind: str
    value: Callable[[CurvePoint[E]], float]
    end: str = ""
    reason: Reason = NO_REASON
    find_meeting: Callable[[CurvePoint[E], CurvePoint[E]], CurvePoint[E] | None] | None = None
    crosses: bool = False
    smooth: Callable[[CurvePoint[E]], float] | None = None
    explain: Callable[[CurvePoint[E]], Reason] | None = None
    holds: Callable[[CurvePoint[E]], bool] = find_no_objection


Counts = tuple[int, ...]


def hides_nothing(before: Counts, after: Counts) -> bool:
    """Return that all changes between two counts show in them."""
    return False


@dataclass(frozen=True)
class CountFunction(Generic[E]):
    """Whole numbers that change only at special points, such as how many multipliers lie outside the unit circle.

    ``explain(before, after)`` returns the test functions whose zeros account for a change, or None if several changes
    have come together and the step must be cut. ``hides(before, after)`` says whether changes that make up for one
    another seem to lie in between.
    """

    count: Callable[[CurvePoint[E]], Counts]
    explain: Callable[[Counts, Counts], Sequence[TestFunction[E]] | None]
    hides: Callable[[Counts, Counts], bool] = hides_nothing


def find_no_violation(_: CurvePoint[E]) -> Reason:
    """Return no reason: every point is valid."""
    return NO_REASON


@dataclass(frozen=True)
class TestFunctions(Generic[E]):
    """What is evaluated along a branch.

    ``find_violation`` says why a point is none of the problem's solutions. The point at which that begins is a special
    one of ``violation_kind`` (empty: it is not located), found by ``find_strictly``: the same without room for errors.
    ``depend_on_reference``: values change, if only by rounding, with the orbit that the system took as its reference.
    """

    __test__ = False
    tests: Sequence[TestFunction[E]] = ()
    counts: CountFunction[E] | None = None
    find_violation: Callable[[CurvePoint[E]], Reason] = find_no_violation
    violation_kind: str = ""
    find_strictly: Callable[[CurvePoint[E]], Reason] = find_no_violation
    depend_on_reference: bool = False


@dataclass(frozen=True)
class TestValues:
    """Values of test functions and counts at a point, and why it is no solution (no reason if it is one)."""

    __test__ = False
    values: tuple[float, ...]
    counts: Counts
    violation: Reason


def evaluate_tests(point: CurvePoint[E], functions: TestFunctions[E]) -> TestValues:
    """Return the values of all functions at a point."""
    counts = functions.counts.count(point) if functions.counts else ()
    return TestValues(tuple(test.value(point) for test in functions.tests), counts, functions.find_violation(point))


def find_values_at_start(start: CurvePoint[E], functions: TestFunctions[E], before: TestValues | None) -> TestValues:
    """Return the values of all functions where a step starts, from those ``before`` that the last one ended with.

    They are the same to the last bit for a branch that is resumed there, which has none from before.
    """
    if before is None:
        return evaluate_tests(start, functions)
    if functions.depend_on_reference:
        return replace(before, values=tuple(test.value(start) for test in functions.tests))
    return before


@dataclass(frozen=True, eq=False)
class SpecialPoint(Generic[E]):
    """A special point at a fraction of a step."""

    test: TestFunction[E]
    point: CurvePoint[E]
    fraction: float

    @property
    def reason(self) -> Reason:
        """What is said of the point."""
        return self.test.reason if self.test.explain is None else self.test.explain(self.point)


def find_special_points(
    segment: BranchSegment[E], functions: TestFunctions[E], before: TestValues, after: TestValues, from_: float
) -> tuple[list[SpecialPoint[E]], int]:
    """Return the special points on a step in order, and the number of changes of counts that none of them explains.

    Where two fall together the one that ends the branch comes first. Those before the fraction ``from_`` are the point
    that the branch starts from, and left out.
    """
    found = []
    for test, f0, f1 in zip(functions.tests, before.values, after.values, strict=True):
        if (f0 * f1 < 0.0 or (f1 == 0.0 and f0 != 0.0)) and not _only_at_start(segment, test, f0, f1, from_):
            found += _locate(segment, test, 0.0, 1.0, f0, f1)
    found += _find_before_end(segment, functions, before, found)
    found, n_unexplained = [f for f in found if f.fraction >= from_], 0
    if functions.counts is not None and not any(f.test.find_meeting for f in found):
        # What lies beyond a point that ends the branch counts for nothing, and on it a count may be of either side.
        last = min((f.fraction * (1.0 - SHORT) for f in found if f.test.end), default=1.0)
        counts = after.counts if last == 1.0 else functions.counts.count(segment.at(last))
        counted = _explain_counts(segment, functions.counts, 0.0, last, before.counts, counts, MAX_CUTS)
        found += [f for f in counted if f is not None]
        n_unexplained = len([f for f in counted if f is None])
        if n_unexplained and from_:
            # At the start of a branch the special point that it comes from may still show.
            n_unexplained = _count_unexplained(
                segment, functions.counts, PAST_START * last, last, counts, n_unexplained
            )
    wrong_at = _find_violated(segment, functions, before, after, found)
    if wrong_at is not None:
        last_valid = _find_last_valid(segment, functions, *wrong_at)
        ends = _name_end(segment, functions, last_valid.fraction) or [last_valid]
        found = [f for f in found if not f.test.end]
        found = [*(f for f in found if round(f.fraction - last_valid.fraction, TOGETHER_DECIMALS) <= 0.0), *ends]
    kept = (f for f in found if f.fraction >= from_ or f.test.end == End.INVALID)
    return sorted(kept, key=_find_place), n_unexplained


def _find_before_end(
    segment: BranchSegment[E], functions: TestFunctions[E], before: TestValues, found: Sequence[SpecialPoint[E]]
) -> list[SpecialPoint[E]]:
    """Return the special points before the first of those ``found`` that ends the branch which the step's end hides.

    Beyond that one a test function may have changed its sign again, or have no value any more; very near to it too.
    """
    more: list[SpecialPoint[E]] = []
    for short in (SHORT, *FARTHER):
        end = min((f.fraction for f in (*found, *more) if f.test.end), default=0.0) * (1.0 - short)
        if end <= 0.0:
            return more
        with contextlib.suppress(ConvergenceError):
            near = segment.at(end)
            for test, f0 in zip(functions.tests, before.values, strict=True):
                if test.find_meeting is None and all(f.test is not test for f in (*found, *more)):
                    f1 = test.value(near)
                    more += _locate(segment, test, 0.0, end, f0, f1) if f0 * f1 < 0.0 else []
    return more


def _find_place(special: SpecialPoint[E]) -> tuple[float, int, float]:
    """Return what special points on a step are sorted by: beyond the last one that solves the problem is none."""
    place = 2 if special.test.end == End.INVALID else int(not special.test.end)
    return round(special.fraction, TOGETHER_DECIMALS), place, special.fraction


def _find_violated(
    segment: BranchSegment[E],
    functions: TestFunctions[E],
    before: TestValues,
    after: TestValues,
    found: Sequence[SpecialPoint[E]],
) -> tuple[float, Reason] | None:
    """Return where on a step the problem is not solved any more, and why; None if it is up to where the branch ends.

    A test function's zero says nothing where it lies beyond the last point that solves the problem.
    """
    if not functions.violation_kind or before.violation:
        return None
    end = min((f.fraction for f in found if f.test.end), default=None)
    if end is None:
        return (1.0, after.violation) if after.violation else None
    if not after.violation or end * (1.0 - SHORT) <= 0.0:
        return None
    try:
        violation = functions.find_violation(segment.at(end * (1.0 - SHORT)))
    except ConvergenceError:
        return None
    return (end * (1.0 - SHORT), violation) if violation else None


def _name_end(segment: BranchSegment[E], functions: TestFunctions[E], fraction: float) -> list[SpecialPoint[E]]:
    """Return the first zero, near the last point that solves the problem, of a test function that ends the branch.

    It may have changed its sign again, or have no value any more, where the step ends.
    """
    found = []
    try:
        low, high = max(fraction - NEAR_END, 0.0), min(fraction + NEAR_END, 1.0)
        sides = [segment.at(low), segment.at(high)]
        for test in functions.tests:
            f_low, f_high = map(test.value, sides) if test.end else (0.0, 0.0)
            found += _locate(segment, test, low, high, f_low, f_high) if f_low * f_high < 0.0 else []
    except ConvergenceError:
        return []
    return sorted(found, key=_find_place)[:1]


def _find_last_valid(
    segment: BranchSegment[E], functions: TestFunctions[E], high: float, violation: Reason
) -> SpecialPoint[E]:
    """Return the last point of a step, to rounding, that solves the problem, and why the next one does not.

    ``violation`` is what is wrong at the fraction ``high``; at the step's beginning nothing is.
    """
    low = 0.0
    for _ in range(MAX_HALVINGS):
        tried = _try_between(segment, functions, low, high)
        if tried is None:
            break
        middle, found = tried
        low, high, violation = (low, middle, found) if found else (middle, high, violation)
    if high - low > LOCATED:
        # No point can be found between the two; how far apart they are is told.
        violation = Reason(violation.code, {**violation.values, WITHIN: high - low})
    test: TestFunction[E] = TestFunction(functions.violation_kind, lambda _: 0.0, End.INVALID, violation)
    return SpecialPoint(test, segment.at(low), low)


def _try_between(
    segment: BranchSegment[E], functions: TestFunctions[E], low: float, high: float
) -> tuple[float, Reason] | None:
    """Return a fraction between two others and why the point there is no solution; None where none can be found."""
    for part in PARTS:
        middle = low + part * (high - low)
        with contextlib.suppress(ConvergenceError):
            return middle, functions.find_strictly(segment.at(middle))
    return None


def _only_at_start(segment: BranchSegment[E], test: TestFunction[E], f0: float, f1: float, from_: float) -> bool:
    """Return whether a test function changes its sign before ``from_`` alone, where the branch starts on its zero."""
    if test.find_meeting is not None or abs(f0) >= from_ * abs(f1):
        return False
    try:
        return test.value(segment.at(from_)) * f1 > 0.0
    except ConvergenceError:
        return False


def _locate(
    segment: BranchSegment[E], test: TestFunction[E], low: float, high: float, f_low: float, f_high: float
) -> list[SpecialPoint[E]]:
    """Return the zero of a test function between two fractions; nothing if it jumps or is no such point."""
    if test.find_meeting is not None:
        met = test.find_meeting(segment.at(low), segment.at(high))
        return [] if met is None else [SpecialPoint(test, met, low + (high - low) * f_low / (f_low - f_high))]
    fraction = segment.find_zero(test.value, low, high, f_low, f_high)
    if fraction is None:
        return []
    point = segment.cross(fraction, low, high) if test.crosses else segment.at(fraction)
    if not test.holds(point):
        return []
    return [SpecialPoint(test, point, fraction)]


def _locate_counted(
    segment: BranchSegment[E], test: TestFunction[E], low: float, high: float
) -> list[SpecialPoint[E]] | None:
    """Return the point for which a count has changed; nothing if it is not found, None if its function has no sign."""
    f_low, f_high = test.value(segment.at(low)), test.value(segment.at(high))
    if not f_low * f_high <= 0.0:
        return None
    return _locate(segment, test, low, high, f_low, f_high) or _locate_smoothly(segment, test, low, high)


def _locate_smoothly(
    segment: BranchSegment[E], test: TestFunction[E], low: float, high: float
) -> list[SpecialPoint[E]]:
    """Return the point that a test function's smooth twin leads to; nothing if there is none."""
    if test.smooth is None:
        return []
    f_low, f_high = test.smooth(segment.at(low)), test.smooth(segment.at(high))
    smooth = replace(test, value=test.smooth)
    return _locate(segment, smooth, low, high, f_low, f_high) if f_low * f_high < 0.0 else []


def _count_unexplained(
    segment: BranchSegment[E], counts: CountFunction[E], low: float, high: float, after: Counts, otherwise: int
) -> int:
    """Return how many changes between two fractions nothing explains; ``otherwise`` if there is no point at ``low``."""
    try:
        before = counts.count(segment.at(low))
    except ConvergenceError:
        return otherwise
    return len([f for f in _explain_counts(segment, counts, low, high, before, after, MAX_CUTS) if f is None])


def _explain_counts(
    segment: BranchSegment[E],
    counts: CountFunction[E],
    low: float,
    high: float,
    before: Counts,
    after: Counts,
    cuts: int,
) -> list[SpecialPoint[E] | None]:
    """Return the special points that account for a change of counts, cutting the step where several come together.

    None stands for a change that could not be explained.
    """
    hidden = cuts > 0 and counts.hides(before, after)
    if before == after and not hidden:
        return []
    tests = None if hidden else counts.explain(before, after)
    if tests is not None:
        located = [_locate_counted(segment, test, low, high) for test in tests]
        # A test function may not exist all along: no real multiplier at one end, say. Then the step is cut too.
        if all(points is not None for points in located):
            explained: list[SpecialPoint[E] | None] = []
            for points in located:
                explained += points or [None]
            return explained
    middle = 0.5 * (low + high)
    try:
        between = counts.count(segment.at(middle)) if cuts else None
    except ConvergenceError:
        between = None
    if between is None:
        return [point for test in tests or () for point in _locate_smoothly(segment, test, low, high)] or [None]
    return [
        *_explain_counts(segment, counts, low, middle, before, between, cuts - 1),
        *_explain_counts(segment, counts, middle, high, between, after, cuts - 1),
    ]
