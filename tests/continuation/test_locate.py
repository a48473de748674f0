"""Points between two points of a branch, and zeros of functions there."""

import math

import numpy as np
import pytest

from pddecont.continuation import CurvePoint, FixedUnknowns, NewtonSettings, correct_component, locate, newton
from pddecont.continuation.locate import BranchSegment
from pddecont.errors import ConvergenceError
from tests.continuation.systems import Algebraic, Growth, circle, crossing, fold, grow

SETTINGS = NewtonSettings()


def segment(system, a, b):
    """Return the segment between two points of a system without a mesh."""
    fixed = FixedUnknowns(system)
    return BranchSegment(*(CurvePoint(fixed, fixed.at(np.array(x))) for x in (a, b)), SETTINGS)


@pytest.mark.parametrize("scale", [(1.0, 1.0), (0.2, 5.0)])
@pytest.mark.parametrize("fraction", [0.01, 0.5, 0.8])
def test_a_point_lies_on_the_branch_at_its_fraction_of_the_chord(scale, fraction):
    a, b = np.array([1.0, 0.0]), np.array([0.6, 0.8])
    x = segment(circle(scale=scale), a, b).at(fraction).x
    assert x @ x == pytest.approx(1.0, abs=1e-13)
    along, sizes = (b - a) / np.array(scale), np.array(scale)
    assert along @ ((x - a) / sizes) / (along @ along) == pytest.approx(fraction, abs=1e-13)


def test_the_ends_are_the_points_themselves_and_points_are_kept():
    of = segment(circle(), [1.0, 0.0], [0.6, 0.8])
    assert of.at(0.0) is of.known[0.0] and of.at(1.0) is of.known[1.0]
    assert of.at(0.4) is of.at(0.4)


def test_each_guess_comes_from_the_nearest_known_points(monkeypatch):
    of, guesses = segment(circle(), [1.0, 0.0], [0.0, 1.0]), []
    correct = of._correct
    monkeypatch.setattr(
        of, "_correct", lambda system, guess, level: guesses.append(guess) or correct(system, guess, level)
    )
    half = of.at(0.5).x
    assert half == pytest.approx([math.sqrt(0.5)] * 2, abs=1e-14)
    of.at(0.75)
    assert guesses[1] == pytest.approx(0.5 * np.add(half, [0.0, 1.0]), abs=1e-15)


def test_points_near_one_another_are_found_with_one_jacobian(monkeypatch):
    monkeypatch.setattr(locate, "LARGE", 1)
    monkeypatch.setattr(newton, "LARGE", 1)
    asked = []
    watched = Algebraic(circle().equations, lambda x: asked.append(x) or circle().derivatives(x))
    of = segment(watched, [1.0, 0.0], [0.6, 0.8])
    half = of.at(0.5).x
    assert half @ half == pytest.approx(1.0, abs=1e-15) and asked
    asked.clear()
    beside = of.at(0.5001)
    assert beside.x @ beside.x == pytest.approx(1.0, abs=1e-15) and not asked
    # Its tangent is that of the circle there.
    assert beside.tangent @ beside.x == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("level", [0.05, 0.31, 0.7999])
def test_zeros_are_located_to_rounding(level):
    of = segment(circle(), [1.0, 0.0], [0.6, 0.8])
    fraction = of.find_zero(lambda point: point.x[1] - level, 0.0, 1.0, -level, 0.8 - level)
    assert of.at(fraction).x == pytest.approx([math.sqrt(1 - level**2), level], abs=2e-13)


def test_a_zero_is_looked_for_in_its_part_of_the_way():
    """(y - 0.3) (y - 0.5) has two zeros; between the fractions of 0.4 and 0.8 lies one."""
    of = segment(circle(), [1.0, 0.0], [0.6, 0.8])

    def value(point):
        return (point.x[1] - 0.3) * (point.x[1] - 0.5)

    low = of.find_zero(lambda point: point.x[1] - 0.4, 0.0, 1.0, -0.4, 0.4)
    fraction = of.find_zero(value, low, 1.0, value(of.at(low)), value(of.at(1.0)))
    assert of.at(fraction).x[1] == pytest.approx(0.5, abs=2e-13)


def test_a_place_that_is_known_is_not_looked_for_again():
    """Another function with the same zero takes no more points; one with another zero finds that."""
    of = segment(circle(), [1.0, 0.0], [0.6, 0.8])
    fraction = of.find_zero(lambda point: point.x[1] - 0.3, 0.0, 1.0, -0.3, 0.5)
    n = len(of.known)
    again = of.find_zero(lambda point: np.expm1(0.3 - point.x[1]), 0.0, 1.0, np.expm1(0.3), np.expm1(-0.5))
    assert (again, len(of.known)) == (fraction, n)
    other = of.find_zero(lambda point: point.x[1] - 0.6, 0.0, 1.0, -0.6, 0.2)
    assert of.at(other).x[1] == pytest.approx(0.6, abs=2e-13) and len(of.known) > n


def test_a_known_place_without_a_value_is_passed_over():
    of = segment(circle(), [1.0, 0.0], [0.6, 0.8])
    of.at(0.5)
    there = of.at(0.25).x[1]
    fraction = of.find_zero(lambda point: math.nan if point.x[1] == there else point.x[1] - 0.3, 0.0, 1.0, -0.3, 0.5)
    assert of.at(fraction).x[1] == pytest.approx(0.3, abs=2e-13)


def test_a_jump_through_zero_is_none():
    of = segment(circle(), [1.0, 0.0], [0.6, 0.8])
    assert of.find_zero(lambda point: 1.0 if point.x[1] > 0.3 else -1.0, 0.0, 1.0, -1.0, 1.0) is None


def test_a_function_that_is_not_defined_on_the_way_has_no_zero_there():
    of = segment(circle(), [1.0, 0.0], [0.6, 0.8])
    assert of.find_zero(lambda point: math.nan, 0.0, 1.0, -1.0, 1.0) is None


@pytest.mark.parametrize("end", [0.37, 1.0])
def test_where_branches_cross_the_place_is_interpolated(end):
    """At the crossing p = 0 the Jacobian on the line y = 0 vanishes, and no point can be corrected there."""
    of = segment(crossing(), [0.0, -1.0], [0.0, end])
    with pytest.raises(ConvergenceError, match="singular"):
        segment(crossing(), [0.0, -1.0], [0.0, 1.0]).at(0.5)
    fraction = of.find_zero(lambda point: point.x[1], 0.0, 1.0, -1.0, end)
    assert fraction == pytest.approx(1.0 / (1.0 + end), abs=1e-12)
    # The point that is kept there lies on the branch, and knows which way it goes.
    point = of.at(fraction)
    assert point.x == pytest.approx([0.0, 0.0], abs=1e-12)
    assert point.tangent[0] == pytest.approx(0.0, abs=1e-15) and point.tangent[1] > 0.0


def test_the_place_of_a_crossing_is_the_same_to_the_last_bit_every_time():
    def locate():
        of = segment(crossing(), [0.0, -1.0], [0.0, 1.0])
        fraction = of.find_zero(lambda point: np.expm1(point.x[1]), 0.0, 1.0, np.expm1(-1.0), np.expm1(1.0))
        return fraction, of.at(fraction).x.tobytes(), of.at(fraction).tangent.tobytes()

    assert len({locate() for _ in range(20)}) == 1


@pytest.mark.parametrize("steepest", [0.12, 0.2, 0.24, 0.26, 0.27, 0.3, 0.32])
def test_beside_a_pole_the_place_of_a_crossing_is_interpolated_near_it(steepest, monkeypatch):
    """No polynomial over the whole way follows a modulus with a pole beside its zero at p = 0.03."""
    shifted = Algebraic(lambda x: [x[0] * (x[1] - 0.03 - x[0] ** 2)], lambda x: [[x[1] - 0.03 - 3.0 * x[0] ** 2, x[0]]])

    def value(point):
        p = point.x[1]
        return (p - 0.03) / abs(p - steepest)

    of = segment(shifted, [0.0, -1.0], [0.0, 1.0])
    correct = of._correct

    def fail_near(system, guess, level):
        if abs(level - 0.03) < 1e-6:
            raise ConvergenceError("the Jacobian is singular")
        return correct(system, guess, level)

    monkeypatch.setattr(of, "_correct", fail_near)
    fraction = of.find_zero(value, 0.0, 1.0, value(of.at(0.0)), value(of.at(1.0)))
    assert fraction == pytest.approx(0.515, abs=1e-9)
    assert of.at(fraction).x == pytest.approx([0.0, 0.03], abs=1e-9)


@pytest.mark.parametrize(("low", "fraction"), [(0.0, 0.5), (0.5, 0.5)])
def test_at_a_crossing_the_tangent_is_that_of_the_points_beside_it(low, fraction):
    """The point itself was corrected, by chance; its last Newton step would take any direction for the branch's."""
    of = segment(crossing(), [0.0, -1.0], [0.0, 1.0])
    system = of.known[0.0].system
    of.known[fraction] = CurvePoint(system, system.at(np.zeros(2)))
    point = of.cross(fraction, low, 1.0)
    assert point.x == pytest.approx([0.0, 0.0], abs=1e-15)
    assert point.tangent[0] == pytest.approx(0.0, abs=1e-15) and point.tangent[1] > 0.0


def test_points_on_another_branch_do_not_spoil_the_place(monkeypatch):
    """One of the points around a crossing lies on the other branch: then the place is not known."""
    of = segment(crossing(), [0.0, -1.0], [0.0, 1.0])
    correct = of._correct

    def astray(system, guess, level):
        point = correct(system, guess, level)
        if level > 0.2:
            return CurvePoint(system, system.at(np.array([math.sqrt(level), level])), point.solution)
        return point

    monkeypatch.setattr(of, "_correct", astray)
    assert of.find_zero(lambda point: point.x[1] + 5.0 * point.x[0], 0.0, 1.0, -1.0, 1.0) is None


def test_a_point_that_is_nowhere_on_the_branch_is_an_error():
    """Points (0, 0) and (0, 4) are none of x^2 = p, but nothing lies between them either."""
    with pytest.raises(ConvergenceError):
        segment(fold(), [0.0, -1.0], [0.0, -3.0]).at(0.5)


def test_points_between_two_grids_get_grids_of_their_own():
    """From p = 1 on 2 intervals to p = 5 on 20: u(1) = 9 is found in closed form on whatever grid the point has."""
    ends = [CurvePoint(Growth(n), Growth(n).at(grow(n, p))) for n, p in ((2, 1.0), (20, 5.0))]
    of = BranchSegment(*ends, SETTINGS)

    def value(point):
        return point.x[-2] - 9.0

    fraction = of.find_zero(value, 0.0, 1.0, *(value(end) for end in ends))
    found, n = of.at(fraction), of.at(fraction).system.n
    assert n != 2 and found.system.mesh_is_adequate(found.at)
    assert found.x[-1] == pytest.approx(2 * n * (9 ** (1 / n) - 1) / (9 ** (1 / n) + 1), abs=1e-10)


def test_the_chord_runs_through_unknowns_that_no_mesh_changes():
    """Along p alone the fraction is that of p and of u(1), whatever the values between are."""
    system = Growth(12)
    ends = [CurvePoint(system, system.at(grow(12, p))) for p in (1.0, 3.0)]
    x = BranchSegment(*ends, SETTINGS).at(0.25).x
    chord = np.array([grow(12, 3.0)[12] - grow(12, 1.0)[12], 2.0])
    moved = np.array([x[12] - grow(12, 1.0)[12], x[-1] - 1.0])
    assert chord @ moved / (chord @ chord) == pytest.approx(0.25, abs=1e-13)
    assert x == pytest.approx(correct_component(system, x, 13, x[-1], SETTINGS).x, abs=1e-12)
