"""Branches of curves known in closed form, followed to their ends; nothing of models or orbits."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.continuation import (
    END_POINT,
    Approach,
    CountFunction,
    End,
    StepSettings,
    TestFunction,
    TestFunctions,
    follow_branch,
    predictor_corrector,
)
from pddecont.errors import ConvergenceError
from pddecont.reasons import NO_REASON, make_reason
from tests.continuation.systems import Algebraic, Growth, Margins, Range, circle, follow, grow, line, start_at

WIDE = Range(0, -2.0, 2.0)
UP, DOWN = (0.0, 1.0), (0.0, -1.0)
# Where x0^2 + x1 = 0 on the circle, x1 = (1 - sqrt(5)) / 2, on the way round from x = (-1, 0).
PARABOLA = Margins(lambda x: [x[0] ** 2 + x[1]], lambda x: [[2.0 * x[0], 1.0]])
LOW = 0.5 * (1.0 - math.sqrt(5.0))


def go_round(boundaries, tests=(), *, sign=1, counts=None, **steps):
    """Follow the circle from (-1, 0), upwards for a positive sign."""
    functions = TestFunctions(tuple(tests), counts)
    steps = {"max_points": 200, **steps}
    return follow(circle(), (-1.0, 0.0), (0.0, float(sign)), boundaries, functions, sign=sign, **steps)


def special_kinds(points):
    return [point.kind for point in points if point.kind]


def angles(points):
    """Return the angles passed on the way round, from (-1, 0) clockwise."""
    return np.unwrap([math.atan2(p.state.x[1], -p.state.x[0]) for p in points])


def test_points_lie_on_the_branch_and_arclength_is_right():
    points, end = go_round([WIDE], max_points=100, max=0.05)
    assert (end.end, end.detail) == (End.MAX_POINTS, NO_REASON)
    assert len(points) == 99
    for point in points:
        assert math.hypot(*point.state.x) == pytest.approx(1, abs=1e-12)
        angle = (math.pi - math.atan2(point.state.x[1], point.state.x[0])) % (2 * math.pi)
        assert point.state.arclength % (2 * math.pi) == pytest.approx(angle, rel=2e-3)


@pytest.mark.parametrize("step", [0.2, 0.1, 0.05])
def test_arclength_is_the_sum_of_chords(step):
    """A chord over an angle a is 2 sin(a / 2) long: exact step by step, and short of the arc by its square / 24."""
    points, _ = go_round([WIDE], max_points=20, initial=step, min=step, max=step)
    passed, lengths = angles(points), np.array([p.state.arclength for p in points])
    turns = np.diff(passed, prepend=0.0)
    assert np.diff(lengths, prepend=0.0) == pytest.approx(2.0 * np.sin(0.5 * turns), abs=1e-12)
    assert (passed[-1] - lengths[-1]) / passed[-1] == pytest.approx(step**2 / 24.0, rel=0.02)


def test_the_other_direction_has_negative_arclengths_and_the_mirrored_points():
    up, down = (go_round([WIDE], sign=sign, max_points=30)[0] for sign in (1, -1))
    for one, other in zip(up, down, strict=True):
        assert one.state.x == pytest.approx(other.state.x * [1.0, -1.0], abs=1e-12)
        assert one.state.arclength == pytest.approx(-other.state.arclength, abs=1e-12) and one.state.arclength > 0


def test_points_carry_unit_tangents_along_the_way():
    points, _ = go_round([WIDE], max_points=60)
    for point in points:
        x, y = point.state.x
        assert point.state.tangent == pytest.approx([y, -x], abs=1e-9)


def test_lengths_are_measured_in_scaled_unknowns():
    """In units of 10 a line of slope 1 from 0 to 5 is half a unit long in either unknown."""
    points, end = follow(line(1.0, scale=(10.0, 10.0)), (0.0, 0.0), (1.0, 0.0), [Range(0, -1.0, 5.0)])
    assert end.end == End.RANGE
    assert points[-1].state.arclength == pytest.approx(math.sqrt(0.5), abs=1e-12)


def test_steps_grow_twofold_on_a_line():
    points, _ = follow(line(1.0), (0.0, 0.0), (1.0, 0.0), [Range(0, -1.0, 50.0)], initial=0.02, max=0.1, max_points=9)
    assert [p.state.step for p in points] == pytest.approx([0.04, 0.08, *[0.1] * 6], abs=1e-12)


@pytest.mark.parametrize("step", [0.01, 0.05, 0.07])
def test_a_step_is_as_long_as_the_branch_may_turn(step):
    """From a step h on a circle of radius r, which turns by asin(h / r), half of that from its chord."""
    small = Algebraic(lambda x: [x @ x - 0.01], lambda x: [2.0 * x])
    points, _ = follow(small, (-0.1, 0.0), UP, [WIDE], initial=step, max=0.1, max_points=3, max_turn=0.9)
    wanted = step * 0.2 / (0.5 * math.asin(step / 0.1))
    # More than three Newton steps keep it from growing.
    most = 2.0 if points[0].n_iterations <= 3 else 1.0
    assert points[0].state.step == pytest.approx(min(most * step, wanted), rel=1e-9)


def test_a_step_is_at_least_halved_where_the_branch_bends_more_than_its_chord_shows():
    """Round a corner the prediction lies off the corrected point by more than the next one starts out."""
    corner = Algebraic(
        lambda x: [x[1] - 0.5 * (x[0] + np.sqrt(x[0] ** 2 + 1e-6))],
        lambda x: [np.array([-0.5 * (1.0 + x[0] / np.sqrt(x[0] ** 2 + 1e-6)), 1.0])],
    )
    points, _ = follow(corner, (-0.05, 0.0), (1.0, 0.0), [WIDE], initial=0.1, max=0.2, max_points=2, max_turn=0.9)
    first = points[0].state.x - [-0.05, 0.0]
    turn = math.atan2(first[1], first[0])
    assert turn > 0.4 and points[0].state.step == pytest.approx(0.1 * max(0.5, 0.2 / turn), rel=0.02)


def test_a_step_that_bends_too_far_is_taken_again_with_half_of_it():
    small = Algebraic(lambda x: [x @ x - 0.01], lambda x: [2.0 * x])
    points, _ = follow(small, (-0.1, 0.0), UP, [WIDE], initial=0.1, max=0.1, max_points=3)
    distance = np.linalg.norm(points[0].state.x - [-0.1, 0.0])
    assert 0.05 < distance < 0.055


def test_it_passes_folds_and_ends_exactly_at_the_end_of_the_range():
    points, end = go_round([Range(1, -0.5, 2.0)])
    assert end.end is End.RANGE
    assert end.detail == make_reason("range", parameter="x1", value=-0.5)
    assert points[-1].kind == END_POINT
    assert points[-1].state.x[1] == -0.5
    assert points[-1].state.x[0] == pytest.approx(math.sqrt(0.75), abs=1e-12)
    assert max(p.state.x[1] for p in points) > 0.99


@settings(max_examples=25, deadline=None, derandomize=True)
@given(level=st.floats(-0.95, 0.95), step=st.floats(0.01, 0.2))
def test_a_branch_ends_on_the_very_number_of_its_range(level, step):
    points, end = go_round([Range(0, -2.0, level)], initial=step, max=0.2)
    assert end.end is End.RANGE
    assert points[-1].state.x[0] == level
    assert points[-1].state.x[1] == pytest.approx(math.sqrt(1.0 - level**2), abs=1e-11)
    assert all(point.state.x[0] < level for point in points[:-1])


@pytest.mark.parametrize(("sign", "side"), [(1, 1), (-1, -1)])
def test_a_branch_ends_exactly_where_a_margin_is_used_up(sign, side):
    points, end = go_round([WIDE, PARABOLA], sign=sign)
    assert (end.end, end.detail) == (End.LIMIT, make_reason("used_up", number=0))
    assert points[-1].kind == END_POINT
    assert points[-1].state.x == pytest.approx([side * math.sqrt(1 - LOW**2), LOW], abs=1e-12)
    assert all(p.state.x[0] ** 2 + p.state.x[1] > -1e-12 for p in points)


def test_a_range_that_ends_before_a_margin_counts_first():
    points, end = go_round([Range(1, -0.6, 2.0), PARABOLA], initial=0.3, max=0.3)
    assert end.end is End.RANGE
    assert points[-1].state.x[1] == -0.6


def test_a_branch_that_starts_where_a_margin_is_used_up_has_no_other_point():
    used = Margins(lambda x: x[1:], lambda x: [[0.0, 1.0]])
    points, end = go_round([WIDE, used], sign=-1)
    assert (end.end, points) == (End.LIMIT, [])


def test_a_branch_that_starts_on_the_end_of_its_range_ends_at_that_very_point():
    (point,), end = follow(line(0.0), (0.5, 0.0), (1.0, 0.0), [Range(0, 0.0, 0.5)])
    assert (point.kind, point.state.x.tolist(), end.end) == (END_POINT, [0.5, 0.0], End.RANGE)
    points, end = follow(line(0.0), (0.5, 0.0), (-1.0, 0.0), [Range(0, 0.0, 0.5)])
    assert points[-1].state.x[0] == 0.0 and end.end == End.RANGE


def test_a_range_of_one_point_leads_nowhere():
    points, end = follow(
        line(0.0), (0.5, 0.0), (1.0, 0.0), [Range(0, 0.5 - 1e-17, 0.5 + 1e-17)], initial=1e-20, min=1e-21
    )
    assert (points, end.end) == ([], End.STEP_TOO_SMALL)
    assert "rounding" in end.detail.values["text"]


def test_where_the_equations_fail_it_comes_near_and_says_what_fails():
    """Steps before such a boundary become no smaller than 0.02 of the first: near to it, and not beyond."""
    pole = Margins(lambda x: [0.3 - x[0]], lambda x: [[-1.0, 0.0]], Approach.TOWARDS, End.IMPOSSIBLE)
    points, end = go_round([WIDE, pole], initial=0.02)
    assert (end.end, end.detail) == (End.IMPOSSIBLE, make_reason("used_up", number=0))
    assert 0.3 - 0.02 * 0.02 < points[-1].state.x[0] < 0.3
    assert points[-1].kind == ""


@pytest.mark.parametrize(("failures", "ends"), [(3, End.RANGE), (100, End.STEP_TOO_SMALL)])
def test_the_end_of_a_range_that_is_not_landed_on_is_come_closer_to(monkeypatch, failures, ends):
    """Each failure, as beside a fold, halves the step before it."""
    whole, asked = predictor_corrector.land, []

    def failing(boundary, k, system, guess, options):
        asked.append(guess[0])
        if len(asked) <= failures:
            raise ConvergenceError("not found")
        return whole(boundary, k, system, guess, options)

    monkeypatch.setattr(predictor_corrector, "land", failing)
    points, end = follow(line(0.0), (0.0, 0.0), (1.0, 0.0), [Range(0, -1.0, 0.46)], initial=0.1, max=0.1)
    assert end.end is ends
    if ends is End.RANGE:
        # A step of 0.1 passes the end from 0.4; one of 0.05 does not, but those of 0.075, half and a quarter of it do.
        assert [p.state.x[0] for p in points[-3:]] == pytest.approx([0.4, 0.45, 0.46], abs=1e-12)
        assert len(asked) == 4 and points[-1].kind == END_POINT
    else:
        assert end.detail == make_reason("message", text="not found")
        assert 0.46 - 2e-6 < points[-1].state.x[0] <= 0.46


@pytest.mark.parametrize(("ends", "last"), [("special", "GR"), ("", "EP")])
def test_a_test_function_is_located(ends, last):
    test = TestFunction("GR", lambda point: point.x[0] - 0.3, end=ends, reason=make_reason("why", number=3))
    points, end = go_round([Range(0, -2.0, 0.9)], [test])
    found = next(point for point in points if point.kind == "GR")
    assert found.reason == make_reason("why", number=3)
    assert found.state.x == pytest.approx([0.3, math.sqrt(0.91)], abs=1e-11)
    assert points[-1].kind == last
    assert end.end == (End.SPECIAL if ends else End.RANGE)
    if ends:
        assert end.detail == make_reason("kind", kind="GR")
    # Its arclength is as far on the step as it lies, and its tangent has length one.
    i = points.index(found)
    if not ends:
        assert points[i - 1].state.arclength < found.state.arclength < points[i + 1].state.arclength
    assert np.linalg.norm(found.state.tangent) == pytest.approx(1.0, abs=1e-12)


def test_a_branch_ends_with_a_code_of_the_test_functions_own():
    points, end = go_round([WIDE], [TestFunction("R1", lambda point: point.x[0] - 0.3, end="resonance")])
    assert end.end == "resonance" and points[-1].kind == "R1"


def test_a_jump_through_zero_is_not_a_special_point():
    test = TestFunction("GR", lambda point: 1.0 if point.x[0] > 0.3 else -1.0, end=End.SPECIAL)
    points, end = go_round([Range(0, -2.0, 0.9)], [test])
    assert end.end is End.RANGE
    assert special_kinds(points) == ["EP"]


def test_two_specials_in_one_step_come_in_order():
    tests = [TestFunction("B", lambda point: point.x[0] - 0.02), TestFunction("A", lambda point: point.x[0] + 0.02)]
    points, _ = go_round([Range(0, -2.0, 0.9)], tests, max=0.2)
    assert special_kinds(points) == ["A", "B", "EP"]
    assert np.all(np.diff([p.state.arclength for p in points]) > 0)


def test_the_special_point_that_a_branch_starts_from_is_not_found_again():
    """The start lies a little before the zero of a test function, as a recorded special point does."""
    test = TestFunction("GR", lambda point: point.x[1] - 1e-7, end=End.SPECIAL)
    points, end = go_round([Range(0, -2.0, 0.9)], [test])
    assert end.end is End.RANGE and special_kinds(points) == ["EP"]
    again, end = go_round([WIDE], [test])
    assert end.end is End.SPECIAL and again[-1].state.x == pytest.approx([1.0, 1e-7], abs=1e-11)


@pytest.mark.parametrize("places", [(0.2,), (0.2, 0.21), (0.2, 0.2001, 0.201), (0.35, 0.1, 0.1004)])
def test_counts_are_explained_even_where_several_changes_fall_in_one_step(places):
    """They count how many of ``places`` lie below; a change by one is told by the nearest."""

    def count(point):
        return (sum(point.x[1] > y for y in places),)

    def nearest(point):
        return (-1.0) ** count(point)[0] * min(abs(point.x[1] - y) for y in places)

    counts = CountFunction(count, lambda a, b: [TestFunction("N", nearest)] if abs(a[0] - b[0]) == 1 else None)
    points, end = go_round([Range(0, -2.0, 0.0)], counts=counts, max=0.4, initial=0.4)
    assert [p.state.x[1] for p in points if p.kind == "N"] == pytest.approx(sorted(places), abs=1e-11)
    assert end.n_unexplained == 0


def test_changes_that_nothing_explains_are_counted():
    counts = CountFunction(lambda point: (int(point.x[0] > 0.3) + int(point.x[0] > 0.5),), lambda before, after: None)
    points, end = go_round([Range(0, -2.0, 0.9)], counts=counts)
    assert (end.end, end.n_unexplained) == (End.RANGE, 2)
    assert special_kinds(points) == ["EP"]


def test_a_branch_does_not_go_on_with_points_that_are_no_solutions():
    """Whatever makes a point invalid without a located special point ends the branch, and says what it is."""
    beyond = make_reason("beyond", wall=0.5)
    functions = TestFunctions(find_violation=lambda point: beyond if point.x[0] > 0.5 else NO_REASON)
    points, end = follow(circle(), (-1.0, 0.0), UP, [WIDE], functions)
    assert (end.end, end.detail) == (End.INVALID, beyond)
    assert 0.5 < points[-1].state.x[0] < 0.65
    # From a point that is none already it goes on: its user has asked for that.
    points, end = follow(circle(), (0.6, 0.8), (1.0, 0.0), [Range(1, -0.5, 2.0)], functions)
    assert end.end is End.RANGE


def test_a_branch_that_stops_existing_says_so():
    ends = Algebraic(lambda x: [math.nan if x[0] > 0 else x @ x - 1.0], lambda x: [2.0 * x])
    points, end = follow(ends, (-1.0, 0.0), UP, [WIDE])
    assert end.end is End.STEP_TOO_SMALL
    assert end.detail == make_reason("message", text="the equations have no values here")
    assert -1e-4 < points[-1].state.x[0] <= 0


def test_a_branch_that_is_taken_up_again_gives_the_same_points():
    whole, _ = go_round([WIDE], max_points=40)
    states, rest, options = [p.state for p in whole], [], StepSettings(max_points=40)
    follow_branch(states[14], [WIDE], TestFunctions(), options, rest.append, 1)
    assert len(rest) == len(whole) - 15
    for one, other in zip(rest, whole[15:], strict=True):
        assert np.array_equal(one.state.x, other.state.x)
        assert (one.state.arclength, one.state.step) == (other.state.arclength, other.state.step)


def test_a_branch_on_meshes_that_it_changes():
    """The growths u' = p u from p = 0.5 to 2: each on a grid fine enough for it, and exact there.

    The branch lies a little elsewhere on each grid, so that a step onto a new one seems to turn.
    """
    points, end = follow(Growth(2), grow(2, 0.5), np.eye(4)[3], [Range(-1, 0.0, 2.0)], max_turn=0.9)
    assert end.end is End.RANGE
    sizes = [point.state.point.system.n for point in points]
    assert sizes[0] == 2 and sizes[-1] > 4 and np.all(np.diff(sizes) >= 0)
    for point, n in zip(points, sizes, strict=True):
        rate = point.state.x[-1]
        assert rate <= 0.5 * n
        assert point.state.x == pytest.approx(grow(n, rate), rel=1e-9)
    assert points[-1].state.x[-1] == 2.0
    # What a system keeps of a solution is renewed once a step; a new grid keeps the count.
    assert points[-1].state.point.system.references == len(points)


def test_where_a_branch_stands_is_all_that_is_needed():
    state = start_at(circle(), (0.6, 0.8), (1.0, 0.0), step=0.05)
    assert (state.arclength, state.step, state.n_points) == (0.0, 0.05, 1)
    assert state.tangent == pytest.approx([0.8, -0.6], abs=1e-14)
    points = []
    end = follow_branch(state, [WIDE], TestFunctions(), StepSettings(max_points=1), points.append, 1)
    assert (end.end, points) == (End.MAX_POINTS, [])
