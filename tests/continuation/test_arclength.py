"""Tangents and corrections of curves known in closed form."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.continuation import NewtonSettings, correct, correct_component, find_tangent, tangent_at
from pddecont.continuation.arclength import BorderedEvaluation, solve_with_row
from pddecont.errors import ConvergenceError
from tests.continuation.systems import circle, fold, line

sizes = st.tuples(*2 * [st.floats(0.01, 100.0)])
angles = st.floats(-math.pi, math.pi)


def on_circle(angle):
    return np.array([math.cos(angle), math.sin(angle)])


@settings(max_examples=50, deadline=None, derandomize=True)
@given(angles, sizes, sizes, angles)
def test_the_tangent_of_a_circle(angle, scale, weight, side):
    """It is at right angles to the radius, whatever the scaling; its length and side are those of the scaling."""
    system, x, towards = circle(scale=scale, weight=weight), on_circle(angle), on_circle(side)
    across = np.array([-x[1], x[0]])
    if abs(system.scaling.dot(across, towards)) < 1e-3 * system.scaling.length(across) * system.scaling.length(towards):
        return
    found = find_tangent(system.at(x), system.scaling, towards)
    sign = np.sign(system.scaling.dot(across, towards))
    assert found == pytest.approx(sign * across / system.scaling.length(across), rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("sparse", [False, True])
def test_the_tangent_at_a_corrected_point_is_that_of_its_jacobian(sparse):
    system = circle(scale=(2.0, 0.5), sparse=sparse)
    row = system.scaling.covector(np.array([0.3, 1.0]))
    solution = solve_with_row(system, row, 0.9 * float(row @ on_circle(0.4)), on_circle(0.4), NewtonSettings())
    for towards in (np.array([0.0, 1.0]), np.array([0.0, -1.0])):
        expected = find_tangent(solution.at, system.scaling, towards)
        # Its factors are those of the last Newton step, one step of length 1e-8 or less before.
        assert tangent_at(solution, system.scaling, towards) == pytest.approx(expected, abs=1e-7)


@settings(max_examples=50, deadline=None, derandomize=True)
@given(angles, st.floats(0.01, 0.7))
def test_a_prediction_is_taken_back_across_the_tangent(angle, step):
    """From a point x of the circle along its tangent t by s, the correction runs along x: to sqrt(1 - s^2) x + s t."""
    system, x = circle(), on_circle(angle)
    t = np.array([-x[1], x[0]])
    found = correct(system, x + step * t, t, NewtonSettings())
    assert found.x == pytest.approx(math.sqrt(1.0 - step**2) * x + step * t, abs=1e-12)


def test_the_prediction_misses_by_the_square_of_the_step():
    x, t = on_circle(0.7), np.array([-math.sin(0.7), math.cos(0.7)])
    steps = np.array([0.1, 0.05, 0.025])
    misses = [np.linalg.norm(correct(circle(), x + s * t, t, NewtonSettings()).x - x - s * t) for s in steps]
    assert np.diff(np.log2(misses)) == pytest.approx([-2.0, -2.0], abs=0.01)


def test_right_angles_are_those_of_the_scaling():
    """On the line y = 2x from the prediction (1, 0) the scaled distance is the smallest one."""
    system = line(2.0, scale=(1.0, 3.0), weight=(1.0, 0.5))
    along = np.array([1.0, 2.0])
    found = correct(system, np.array([1.0, 0.0]), along, NewtonSettings()).x
    distances = [system.scaling.length(np.array([1.0, 0.0]) - k * along) for k in np.linspace(-1.0, 2.0, 3001)]
    assert system.scaling.length(np.array([1.0, 0.0]) - found) == pytest.approx(min(distances), abs=1e-6)
    assert system.scaling.dot(along, found - np.array([1.0, 0.0])) == pytest.approx(0.0, abs=1e-14)


def test_newtons_method_starts_from_the_guess_and_stays_in_the_predictions_plane():
    """The plane y = 0.6 cuts the circle twice."""
    predicted, up = np.array([0.9, 0.6]), np.array([0.0, 1.0])
    near = correct(circle(), predicted, up, NewtonSettings()).x
    far = correct(circle(), predicted, up, NewtonSettings(), np.array([-0.9, 0.3])).x
    assert near == pytest.approx([0.8, 0.6], abs=1e-12)
    assert far == pytest.approx([-0.8, 0.6], abs=1e-12)


def test_a_component_is_given_a_value_exactly():
    found = correct_component(fold(), np.array([-1.1, 1.0]), 1, 0.49, NewtonSettings())
    assert found.x[1] == 0.49
    assert found.x[0] == pytest.approx(-0.7, abs=1e-13)


def test_a_plane_beyond_the_branch_holds_no_point_of_it():
    with pytest.raises(ConvergenceError):
        correct(circle(), np.array([1.2, 0.0]), np.array([1.0, 0.0]), NewtonSettings())


@pytest.mark.parametrize("sparse", [False, True])
def test_the_equation_that_picks_a_point_comes_last(sparse):
    row, x = np.array([0.3, -0.7]), np.array([0.5, 2.0])
    at = BorderedEvaluation(circle(sparse=sparse).at(x), row, 0.25)
    assert at.residual == pytest.approx([0.25 + 4.0 - 1.0, 0.15 - 1.4 - 0.25], abs=1e-15)
    matrix = at.jacobian().toarray() if sparse else at.jacobian()
    for k in range(2):
        moved = [BorderedEvaluation(circle().at(x + s * 1e-6 * np.eye(2)[k]), row, 0.25).residual for s in (-1, 1)]
        assert matrix[:, k] == pytest.approx((moved[1] - moved[0]) / 2e-6, abs=1e-9)
