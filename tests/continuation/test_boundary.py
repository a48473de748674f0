"""Boundaries of curves known in closed form: passed, reached, landed on, refused."""

import math

import numpy as np
import pytest

from pddecont.continuation import Approach, CurvePoint, End, FixedUnknowns, NewtonSettings
from pddecont.continuation.boundary import OutOfReachError, find_passed, find_reached, land, refuse_out_of_reach
from pddecont.errors import ConvergenceError
from pddecont.reasons import make_reason
from tests.continuation.systems import Growth, Margins, Range, circle, grow, line

SIMPLE = FixedUnknowns(line(1.0))
BOX = Range(0, -1.0, 1.0)


def point(*x):
    return CurvePoint(SIMPLE, SIMPLE.at(np.array(x, dtype=float)))


def test_the_way_to_a_boundary_is_told_as_a_fraction():
    assert find_passed([BOX], Approach.BEYOND, point(0.5, 0.0), point(1.5, 0.0)) == (BOX, 1, 0.5)
    assert find_passed([BOX], Approach.BEYOND, point(-0.7, 0.0), point(-1.9, 0.0)) == (BOX, 0, pytest.approx(0.25))


def test_the_first_boundary_on_the_way_counts():
    far, near = Range(0, -1.0, 1.0), Range(1, -1.0, 0.25)
    boundary, k, fraction = find_passed([far, near], Approach.BEYOND, point(0.0, 0.0), point(2.0, 2.0))
    assert (boundary, k, fraction) == (near, 1, 0.125)
    assert find_passed([near, far], Approach.BEYOND, point(0.0, 0.0), point(2.0, 2.0))[0] is near


def test_boundaries_of_another_kind_do_not_count():
    for approach in (Approach.UP_TO, Approach.TOWARDS):
        assert find_passed([BOX], approach, point(0.0, 0.0), point(2.0, 0.0)) is None


def test_the_end_of_a_range_is_an_exact_number():
    """A point on it has not passed it; one beyond by the smallest step of the numbers has."""
    assert find_passed([BOX], Approach.BEYOND, point(0.0, 0.0), point(1.0, 0.0)) is None
    beyond = find_passed([BOX], Approach.BEYOND, point(0.0, 0.0), point(np.nextafter(1.0, 2.0), 0.0))
    assert beyond is not None and beyond[1] == 1


@pytest.mark.parametrize(("below", "passed"), [(1e-13, False), (1e-11, True)])
def test_margins_of_other_boundaries_are_zero_to_rounding(below, passed):
    wall = Margins(lambda x: [x[0]], lambda x: [[1.0, 0.0]])
    assert (find_passed([wall], Approach.UP_TO, point(1.0, 0.0), point(-below, 0.0)) is not None) == passed
    # Rounding is that of the unknowns in their scales: a hundred times as much in unknowns a hundred times as large.
    large = FixedUnknowns(line(1.0, scale=(100.0, 1.0)))
    before, after = (CurvePoint(large, large.at(np.array(x))) for x in ([1.0, 0.0], [-100.0 * below, 0.0]))
    assert (find_passed([wall], Approach.UP_TO, before, after) is not None) == passed


def test_from_a_boundary_itself_the_way_is_none():
    """Where rounding left the start a little beyond, the fraction is zero, not negative."""
    wall = Margins(lambda x: [x[0]], lambda x: [[1.0, 0.0]])
    assert find_passed([wall], Approach.UP_TO, point(-1e-15, 0.0), point(-1.0, 0.0))[2] == 0.0


@pytest.mark.parametrize(("x", "direction", "reached"), [(0.0, -1.0, True), (0.0, 1.0, False), (1e-9, -1.0, False)])
def test_a_boundary_is_reached_where_its_margin_is_zero_and_falls(x, direction, reached):
    wall = Margins(lambda x: [1.0, x[0]], lambda x: [[0.0, 0.0], [1.0, 0.0]], end=End.LIMIT)
    found = find_reached([wall], point(x, 0.0), np.array([direction, 0.0]))
    assert found == ((End.LIMIT, make_reason("used_up", number=1)) if reached else None)


@pytest.mark.parametrize("approach", [Approach.BEYOND, Approach.TOWARDS])
def test_only_boundaries_that_steps_come_up_to_are_reached(approach):
    wall = Margins(lambda x: [x[0]], lambda x: [[1.0, 0.0]], approach)
    assert find_reached([wall], point(0.0, 0.0), np.array([-1.0, 0.0])) is None


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan])
def test_what_lies_where_equations_fail_is_refused(value):
    pole = Margins(lambda x: [1.0, value], lambda x: np.zeros((2, 2)), Approach.TOWARDS, End.IMPOSSIBLE)
    with pytest.raises(OutOfReachError, match=r"the branch ends here \(used_up\)") as caught:
        refuse_out_of_reach([BOX, pole], point(0.0, 0.0).at)
    assert caught.value.end == End.IMPOSSIBLE
    assert caught.value.reason == make_reason("used_up", number=1)


def test_nothing_else_is_refused():
    wall = Margins(lambda x: [-1.0], lambda x: np.zeros((1, 2)), Approach.UP_TO)
    open_pole = Margins(lambda x: [1e-300], lambda x: np.zeros((1, 2)), Approach.TOWARDS)
    refuse_out_of_reach([BOX, wall, open_pole], point(5.0, 0.0).at)


def test_landing_on_the_end_of_a_range_gives_that_very_number():
    system, box = FixedUnknowns(circle(scale=(3.0, 0.7))), Range(1, -0.3, 0.1)
    for k, value in enumerate((-0.3, 0.1)):
        found = land(box, k, system, np.array([0.9, value + 0.05]), NewtonSettings())
        assert found.x[1] == value
        assert found.x[0] == pytest.approx(math.sqrt(1.0 - value**2), abs=1e-14)


def test_landing_on_a_curved_boundary():
    """x^2 + y = 0 on the circle, at y = (1 - sqrt(5)) / 2."""
    wall = Margins(lambda x: [x[0] ** 2 + x[1]], lambda x: [[2.0 * x[0], 1.0]])
    low = 0.5 * (1.0 - math.sqrt(5.0))
    found = land(wall, 0, FixedUnknowns(circle()), np.array([0.9, -0.4]), NewtonSettings())
    assert found.x == pytest.approx([math.sqrt(1.0 - low**2), low], abs=1e-12)


def test_a_boundary_that_is_nowhere_on_the_branch_is_not_landed_on():
    """x^2 + y^2 = 1 where x + y = 1.5: Newton's method finds none."""
    wall = Margins(lambda x: [1.5 - x[0] - x[1]], lambda x: [[-1.0, -1.0]])
    with pytest.raises(ConvergenceError):
        land(wall, 0, FixedUnknowns(circle()), np.array([0.8, 0.6]), NewtonSettings())


def test_a_boundary_that_each_solution_overshoots_is_given_up():
    """The cubic root of x falls off so steeply that Newton's method doubles the distance each time."""
    wall = Margins(lambda x: [np.cbrt(x[0])], lambda x: [[np.cbrt(x[0]) ** -2 / 3.0, 0.0]])
    with pytest.raises(ConvergenceError, match="the end of the branch is not found"):
        land(wall, 0, SIMPLE, np.array([0.5, 0.5]), NewtonSettings())


def test_landing_makes_the_mesh_that_the_point_wants():
    """u(1) = 4 on the branch of growths: on n intervals at p = 2n (4^(1/n) - 1) / (4^(1/n) + 1)."""
    wall = Margins(lambda x: [4.0 - x[-2]], lambda x: [-np.eye(len(x))[-2]])
    found = land(wall, 0, Growth(2), grow(2, 1.3), NewtonSettings())
    n = found.system.n
    assert n > 2 and len(found.x) == n + 2
    assert found.x[-1] == pytest.approx(2 * n * (4 ** (1 / n) - 1) / (4 ** (1 / n) + 1), abs=1e-11)
