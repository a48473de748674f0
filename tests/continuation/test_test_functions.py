"""Special points between two points of a curve: zeros of functions, changes of counts, and what both together say."""

import math
from dataclasses import dataclass, field

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.continuation import (
    CountFunction,
    CurvePoint,
    End,
    FixedUnknowns,
    NewtonSettings,
    TestFunction,
    TestFunctions,
)
from pddecont.continuation.locate import BranchSegment
from pddecont.continuation.test_functions import PAST_START, evaluate_tests, find_special_points
from pddecont.errors import ConvergenceError
from pddecont.reasons import NO_REASON, WITHIN, make_reason
from pddecont.tables import describe_reason
from tests.continuation.systems import line


@dataclass
class Step:
    """A step from (0, 0) to (1, 1) along the line y = x, on which fractions are values of x."""

    functions: TestFunctions
    segment: BranchSegment = field(init=False)

    def __post_init__(self):
        system = FixedUnknowns(line(1.0))
        self.ends = [CurvePoint(system, system.at(np.full(2, value))) for value in (0.0, 1.0)]
        self.segment = BranchSegment(*self.ends, NewtonSettings())

    def find(self, from_=0.0):
        values = [evaluate_tests(end, self.functions) for end in self.ends]
        return find_special_points(self.segment, self.functions, *values, from_)


def place(kind, x, **more):
    """Return a test function that is zero at x."""
    return TestFunction(kind, lambda point: point.x[0] - x, **more)


def count_places(*places):
    """Return the number of places passed; a change by one is explained by the nearest."""

    def count(point):
        return (sum(point.x[0] > x for x in places),)

    def nearest(point):
        return (-1.0) ** count(point)[0] * min(abs(point.x[0] - x) for x in places)

    return CountFunction(count, lambda a, b: [TestFunction("N", nearest)] if abs(a[0] - b[0]) == 1 else None)


def told(found):
    return [(special.test.kind, round(special.fraction, 9)) for special in found]


def test_values_counts_and_violations_are_evaluated_at_a_point():
    why = make_reason("why")
    functions = TestFunctions((place("A", 0.25), place("B", 2.0)), count_places(-1.0, 0.5), lambda point: why)
    at_end = evaluate_tests(Step(functions).ends[1], functions)
    assert (at_end.values, at_end.counts, at_end.violation) == ((0.75, -1.0), (2,), why)
    nothing = evaluate_tests(Step(functions).ends[1], TestFunctions())
    assert (nothing.values, nothing.counts, nothing.violation) == ((), (), NO_REASON)


def test_zeros_come_in_their_order_along_the_step():
    found, n_unexplained = Step(TestFunctions((place("B", 0.8), place("A", 0.3), place("C", 1.5)))).find()
    assert told(found) == [("A", 0.3), ("B", 0.8)] and n_unexplained == 0
    assert found[0].point.x == pytest.approx([0.3, 0.3], abs=1e-13)


@pytest.mark.parametrize(("x", "number"), [(0.0, 0), (1.0, 1)])
def test_a_zero_at_an_end_counts_once(x, number):
    """At the end of a step it is the step's; at its beginning the step before has told it."""
    assert len(Step(TestFunctions((place("A", x),))).find()[0]) == number


def test_where_two_fall_together_the_one_that_ends_the_branch_comes_first():
    tests = (place("A", 0.4), place("E", 0.4 + 1e-9, end=End.SPECIAL), place("B", 0.4 + 1e-4))
    assert [kind for kind, _ in told(Step(TestFunctions(tests)).find()[0])] == ["E", "A", "B"]


@pytest.mark.parametrize(("from_", "kinds"), [(0.0, ["A", "B"]), (1e-4, ["B"])])
def test_what_a_branch_starts_from_is_left_out(from_, kinds):
    found, _ = Step(TestFunctions((place("A", 5e-5), place("B", 2e-4)))).find(from_)
    assert [special.test.kind for special in found] == kinds


@settings(max_examples=30, deadline=None, derandomize=True)
@given(st.lists(st.integers(1, 999), min_size=1, max_size=5, unique=True))
def test_each_change_of_a_count_is_explained_however_many_fall_in_one_step(places):
    """Places are 1/1000 apart or more: the step is halved ten times at most."""
    exact = sorted(x / 1000.0 + 1e-4 for x in places)
    found, n_unexplained = Step(TestFunctions(counts=count_places(*exact))).find()
    assert n_unexplained == 0
    assert [special.fraction for special in found] == pytest.approx(exact, abs=1e-11)


def test_changes_that_cannot_be_told_apart_are_counted():
    """Two places nearer than the smallest cut, 2^-10 of the step: one change that nothing explains."""
    assert Step(TestFunctions(counts=count_places(0.3, 0.3 + 1e-5))).find() == ([], 1)
    # Near the beginning of a branch's first step it is the point that the branch comes from, and not farther on.
    assert Step(TestFunctions(counts=count_places(0.01, 0.01 + 1e-5))).find(1e-4) == ([], 0)
    assert Step(TestFunctions(counts=count_places(0.3, 0.3 + 1e-5))).find(1e-4) == ([], 1)


def test_where_no_count_can_be_taken_later_the_change_stays_unexplained():
    """The special point that a branch comes from may show on its first step; a twentieth along it there is no point."""

    def count(point):
        if abs(point.x[0] - PAST_START) < 1e-9:
            raise ConvergenceError("no point here")
        return exact.count(point)

    exact = count_places(0.01, 0.01 + 1e-5)
    counts = CountFunction(count, exact.explain)
    assert Step(TestFunctions(counts=counts)).find(1e-4) == ([], 1)


def violated(start, holes=()):
    """Return functions that no point beyond ``start`` fulfils, without points within the ``holes``."""

    def find(point):
        if any(low < point.x[0] < high for low, high in holes):
            raise ConvergenceError("no point here")
        return make_reason("slides") if point.x[0] > start else NO_REASON

    return TestFunctions(find_violation=find, violation_kind="V", find_strictly=find)


@pytest.mark.parametrize("holes", [(), ((0.49, 0.51),), ((0.49, 0.51), (0.29, 0.31))])
def test_the_last_valid_point_is_located_past_places_without_points(holes):
    ((special,), _) = Step(violated(1 / 3, holes)).find()
    assert special.fraction == pytest.approx(1 / 3, abs=1e-9)
    assert special.reason == make_reason("slides")


def test_where_no_point_is_found_it_is_said_how_well_the_last_valid_one_is_known():
    ((special,), _) = Step(violated(0.75, ((0.01, 0.99),))).find()
    assert special.fraction == 0.0
    assert special.reason.values == {WITHIN: 1.0}
    assert describe_reason(make_reason("no_time", **{WITHIN: 0.25})).endswith("(located only within 25.00% of a step)")


def test_a_change_may_be_no_special_point_at_all():
    counts = CountFunction(lambda point: (int(point.x[0] > 0.4),), lambda before, after: [])
    assert Step(TestFunctions(counts=counts)).find() == ([], 0)


def test_a_change_that_takes_place_at_once_is_told_by_several_functions():
    counts = CountFunction(lambda point: (int(point.x[0] > 0.4),), lambda a, b: [place("B", 0.4), place("A", 0.3)])
    found, n_unexplained = Step(TestFunctions(counts=counts)).find()
    assert told(found) == [("A", 0.3), ("B", 0.4)] and n_unexplained == 0


def test_a_function_that_is_not_there_all_along_is_looked_for_where_it_is():
    """It exists from x = 0.3 on only: the step is cut until both ends have a value."""

    def late(point):
        return point.x[0] - 0.4 if point.x[0] > 0.3 else math.nan

    counts = CountFunction(lambda point: (int(point.x[0] > 0.4),), lambda a, b: [TestFunction("A", late)])
    found, n_unexplained = Step(TestFunctions(counts=counts)).find()
    assert told(found) == [("A", 0.4)] and n_unexplained == 0


def test_counts_that_cannot_be_taken_on_the_way_explain_nothing():
    def count(point):
        if 0.0 < point.x[0] < 1.0:
            raise ConvergenceError("no multipliers here")
        return (2 * int(point.x[0] > 0.4),)

    counts = CountFunction(count, lambda a, b: None)
    assert Step(TestFunctions(counts=counts)).find() == ([], 1)


def test_beyond_a_point_that_ends_the_branch_no_count_is_taken():
    asked, whole = [], count_places(0.3, 0.8)
    counts = CountFunction(lambda point: asked.append(point.x[0]) or whole.count(point), whole.explain)
    functions = TestFunctions((place("E", 0.5, end=End.SPECIAL),), counts)
    step = Step(functions)
    values = [evaluate_tests(end, functions) for end in step.ends]
    asked.clear()
    found, n_unexplained = find_special_points(step.segment, functions, *values, 0.0)
    assert told(found) == [("N", 0.3), ("E", 0.5)] and n_unexplained == 0
    assert max(asked) < 0.5


def test_a_meeting_with_another_branch_is_found_by_its_own_means():
    """Its point is what was found, at the fraction where the function would be zero; no count is trusted around it."""
    elsewhere, asked = object(), []
    counts = count_places(0.3, 0.8)
    meeting = place("PD", 0.6, end=End.SPECIAL, find_meeting=lambda a, b: asked.append((a.x[0], b.x[0])) or elsewhere)
    found, n_unexplained = Step(TestFunctions((meeting,), counts)).find()
    assert told(found) == [("PD", 0.6)] and n_unexplained == 0
    assert found[0].point is elsewhere and asked == [(0.0, 1.0)]
    none = place("PD", 0.6, end=End.SPECIAL, find_meeting=lambda a, b: None)
    found, _ = Step(TestFunctions((none,), counts)).find()
    assert [kind for kind, _ in told(found)] == ["N", "N"]


@pytest.mark.parametrize(("start", "n_evaluations"), [(1e-16, 3), (-1e-16, 2)])
def test_a_zero_that_the_branch_starts_on_is_not_located_whatever_its_sign_by_rounding(start, n_evaluations):
    """The sign at the start is rounding's: either it is that of the end, or one value beyond the start tells."""
    values = []

    def value(point):
        values.append(start if point.x[0] == 0.0 else -point.x[0])
        return values[-1]

    found, _ = Step(TestFunctions([TestFunction("GR", value)])).find(from_=1e-4)
    assert found == []
    assert len(values) == n_evaluations


def test_where_a_function_has_no_values_the_smooth_one_is_followed():
    """The count changes at 0.4, where its function ends; its smooth one does not."""

    def nearest(point):
        x = point.x[0]
        return math.nan if x < 0.4 else 0.4 - x

    def make(smooth):
        tests = [TestFunction("N", nearest, smooth=smooth)]
        return TestFunctions(counts=CountFunction(lambda p: (int(p.x[0] > 0.4),), lambda a, b: tests))

    specials, n_unexplained = Step(make(lambda p: 0.16 - p.x[0] ** 2)).find()
    assert [s.test.kind for s in specials] == ["N"]
    assert specials[0].fraction == pytest.approx(0.4, abs=1e-12)
    assert n_unexplained == 0


@pytest.mark.parametrize("counted", [False, True])
def test_a_zero_that_does_not_hold_is_no_special_point_and_a_counted_one_is_lost(counted):
    place_at = TestFunction("N", lambda point: point.x[0] - 0.4, holds=lambda point: point.x[0] > 0.5)
    counts = CountFunction(lambda point: (int(point.x[0] > 0.4),), lambda before, after: [place_at])
    assert Step(TestFunctions((), counts) if counted else TestFunctions((place_at,))).find() == ([], int(counted))
