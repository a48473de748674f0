"""What a point of a branch says of itself."""

import numpy as np
import pytest

from pddecont.continuation import CurvePoint, FixedUnknowns, NewtonSettings, correct_component, newton
from pddecont.continuation.arclength import solve_with_row
from tests.continuation.systems import Algebraic, Growth, circle, grow

SYSTEM = FixedUnknowns(circle())


def test_a_corrected_point_knows_its_iterations_and_its_tangent():
    solution = correct_component(SYSTEM, np.array([0.9, 0.5]), 1, 0.6, NewtonSettings())
    point = CurvePoint(SYSTEM, solution.at, solution)
    assert point.n_iterations == solution.n_iterations > 1
    assert point.x == pytest.approx([0.8, 0.6], abs=1e-14)
    # The row was the unit vector of y, so that y grows by one along the tangent: x by -y/x.
    assert point.tangent == pytest.approx([-0.75, 1.0], abs=1e-7)


def test_a_point_without_factors_has_its_tangent_and_factors_again_where_it_must():
    solution = correct_component(SYSTEM, np.array([0.9, 0.5]), 1, 0.6, NewtonSettings())
    point = CurvePoint(SYSTEM, solution.at, solution)
    slim = point.without_factors()
    assert slim.solution.solve is not solution.solve and slim.n_iterations == point.n_iterations
    assert slim.tangent is point.tangent
    # The equation 2 x dx + 2 y dy = 1 with dy = 0 has dx = 1 / 1.6.
    assert slim.solve_nearly(np.array([1.0, 0.0])) == pytest.approx([0.625, 0.0], abs=1e-12)


def test_what_led_to_a_point_solves_there_to_a_few_per_cent(monkeypatch):
    monkeypatch.setattr(newton, "LARGE", 1)
    asked = []
    watched = Algebraic(circle().equations, lambda x: asked.append(x) or circle().derivatives(x))
    system = FixedUnknowns(watched)
    solution = correct_component(system, np.array([0.801, 0.6]), 1, 0.6, NewtonSettings())
    point = CurvePoint(system, solution.at, solution)
    assert len(asked) == 1
    nearly = point.solve_nearly(np.array([1.0, 0.0]))
    assert nearly != pytest.approx([0.625, 0.0], rel=1e-12)
    assert nearly == pytest.approx([0.625, 0.0], rel=0.03) and len(asked) == 1


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_tangent_points_to_the_side_to_which_the_row_grows(sign):
    row = sign * np.array([0.2, 1.0])
    solution = solve_with_row(SYSTEM, row, float(row @ [0.8, 0.6]), np.array([0.9, 0.5]), NewtonSettings())
    tangent = CurvePoint(SYSTEM, solution.at, solution).tangent
    assert row @ tangent == pytest.approx(1.0, abs=1e-12)
    assert tangent @ [0.8, 0.6] == pytest.approx(0.0, abs=1e-7)


def test_a_known_direction_is_the_tangent():
    solution = correct_component(SYSTEM, np.array([0.9, 0.5]), 1, 0.6, NewtonSettings())
    direction = np.array([3.0, -4.0])
    assert CurvePoint(SYSTEM, solution.at, solution, direction).tangent is direction


def test_a_point_that_nobody_corrected_has_no_tangent():
    point = CurvePoint(SYSTEM, SYSTEM.at(np.array([1.0, 0.0])))
    assert point.n_iterations == 0
    with pytest.raises(AssertionError, match="only a corrected point"):
        _ = point.tangent


def test_unknowns_that_no_mesh_changes():
    for n in (4, 9):
        system = Growth(n)
        point = CurvePoint(system, system.at(grow(n, 1.5)))
        assert point.mesh_independent_unknowns == pytest.approx([1.0, grow(n, 1.5)[n], 1.5], abs=0)
