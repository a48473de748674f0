"""Special orbits as a system, for a level of the free oscillator's amplitude A = 1 / |1 - w^2 + i c w|."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.optimize import brentq

from pddecont.bifurcation import extend_system, find_good_side
from pddecont.bifurcation.extended_system import ExtendedEvaluation, _span_null, solve_special_orbit
from pddecont.bifurcation.user_function import UserFunction
from pddecont.collocation import MeshRule
from pddecont.errors import ConvergenceError
from pddecont.orbit import PeriodicOrbitSystem, measure_orbit, parse_monitor
from tests.bifurcation.runs import free_amplitude

OMEGA, C = 2.0, 0.1
RANGES = (1.5, 0.4)
RULE = MeshRule(8, tol=1e-9)


def extend(orbit, free, level=0.3):
    """Return the orbit in the system of orbits of an amplitude, with free parameters."""
    orbit = orbit.with_free(free)
    inner = PeriodicOrbitSystem(orbit.problem, measure_orbit(orbit, RANGES[: len(free)]), RULE)
    defining = UserFunction(parse_monitor(orbit.numeric, "level", f"max(x) - {level}"))
    return extend_system(inner, defining), orbit


@pytest.fixture
def at(free_orbit):
    system, orbit = extend(free_orbit, ("omega", "c"))
    return system.at(orbit.x)


def gradient(omega=OMEGA, c=C):
    """Return the amplitude's derivatives in frequency and damping."""
    A = free_amplitude(omega, c)
    return A**3 * np.array([2.0 * omega * (1.0 - omega**2) - c**2 * omega, -c * omega**2])


def test_the_gradient_is_that_of_the_amplitude():
    h = 1e-6
    ahead = [free_amplitude(OMEGA + h, C) - free_amplitude(OMEGA - h, C), 0.0]
    ahead[1] = free_amplitude(OMEGA, C + h) - free_amplitude(OMEGA, C - h)
    assert gradient() == pytest.approx(np.array(ahead) / (2 * h), rel=1e-8)


def test_the_defining_function_is_the_last_residual(at):
    assert at.value == pytest.approx(free_amplitude(OMEGA, C) - 0.3, abs=1e-8)
    assert at.residual[-1] == at.value
    assert np.array_equal(at.residual[:-1], at.inner.residual)
    assert np.max(np.abs(at.inner.residual)) < 1e-9


def test_free_directions_span_the_null_space_of_the_orbits_equations(at):
    directions, scaling = at.free_directions(), at.system.scaling
    assert directions.shape == (2, len(at.x))
    assert [[scaling.dot(a, b) for a in directions] for b in directions] == pytest.approx(np.eye(2), abs=1e-12)
    matrix = at.inner.jacobian()
    assert np.max(np.abs(matrix @ directions.T)) < 1e-9
    # The next time they have the same signs.
    assert at.free_directions() == pytest.approx(directions, abs=1e-9)


def test_rates_of_change_are_those_of_the_closed_form(at):
    directions = at.free_directions()
    expected = directions[:, at.orbit.problem.unknowns.free] @ gradient()
    assert np.max(np.abs(expected)) > 0.01
    assert at.rates_along(directions) == pytest.approx(expected, abs=3e-5 * np.max(np.abs(expected)))


def test_along_the_curve_the_function_does_not_change(at):
    direction = at.direction_along()
    assert at.system.scaling.length(direction) == pytest.approx(1.0, abs=1e-12)
    step = direction[at.orbit.problem.unknowns.free]
    assert abs(step @ gradient()) < 3e-5 * np.linalg.norm(step) * np.linalg.norm(gradient())
    assert np.linalg.norm(step) > 0.1


def test_the_jacobians_last_row_is_right_in_the_directions_that_newton_takes(at):
    """In the free directions, and in the correction that the orbit's own equations ask for off a solution."""
    matrix, directions = at.jacobian(), at.free_directions()
    assert matrix.shape == (len(at.x) - 1, len(at.x))
    assert (matrix @ directions.T)[-1] == pytest.approx(at.rates_along(directions), abs=1e-8)
    size = at.system.scaling.size
    off = at.system.at(at.x + 1e-3 * size * np.random.default_rng(3).standard_normal(len(at.x)))
    correction = off._span(off.inner.jacobian(), -off.inner.residual)[1]
    along = correction / np.linalg.norm(correction / size)
    rate = (off.system.at(off.x + 1e-5 * along).value - off.system.at(off.x - 1e-5 * along).value) / 2e-5
    assert abs(rate) > 1e-3
    assert (off.jacobian() @ along)[-1] == pytest.approx(rate, abs=1e-5)


@pytest.mark.parametrize("signs", [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)])
def test_directions_keep_the_signs_that_they_had(signs):
    rng = np.random.default_rng(2)
    matrix, size = rng.standard_normal((3, 5)), 10.0 ** rng.uniform(-2, 2, 5)
    null = np.linalg.svd(matrix * size)[2][-2:] * size
    near = np.array(signs)[:, None] * null
    found, solution = _span_null(matrix, size, near, np.ones(3), None)
    assert found / size == pytest.approx(near / size, abs=1e-12)
    # The solution for the right-hand side is the shortest.
    assert matrix @ solution == pytest.approx(np.ones(3), abs=1e-12)
    assert (near / size) @ (solution / size) == pytest.approx(np.zeros(2), abs=1e-12)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_good_side_is_the_gradient_in_units_of_the_ranges(at, sign):
    side = find_good_side(at, sign) / np.array(RANGES)
    expected = gradient() * np.array(RANGES)
    assert np.linalg.norm(side) == pytest.approx(1.0, abs=1e-12)
    assert side == pytest.approx(sign * expected / np.linalg.norm(expected), abs=1e-4)


def test_without_a_sign_there_is_no_good_side(at):
    assert np.all(np.isnan(find_good_side(at, None)))


def test_parameters_that_move_together_leave_no_side(at, monkeypatch):
    directions = at.free_directions()
    monkeypatch.setattr(ExtendedEvaluation, "free_directions", lambda self: directions[[0, 0]])
    assert np.all(np.isnan(find_good_side(at, 1.0)))


@pytest.mark.parametrize("level", [0.25, 0.3, 0.4])
def test_the_special_orbit_near_another_one(free_orbit, level):
    system, orbit = extend(free_orbit, ("omega",), level)
    omega = brentq(lambda w: free_amplitude(w, C) - level, 1.5, 2.6, xtol=1e-14)
    special, solution = solve_special_orbit(system.inner, orbit.x, system.defining)
    assert solution.at.orbit.free[0] == pytest.approx(omega, abs=1e-9)
    assert special.mesh_is_adequate(solution.at)


@dataclass
class Nowhere:
    """A condition that is defined nowhere, and keeps count of how often it was taken from an orbit."""

    number: int = 0
    kind: str = "XX"

    def evaluate(self, at):
        return math.nan

    def update_at(self, at):
        return Nowhere(self.number + 1)


def test_a_condition_that_is_not_defined_is_named(free_orbit):
    system, orbit = extend(free_orbit, ("omega",))
    with pytest.raises(ConvergenceError, match="the condition of XX is not defined here"):
        _ = extend_system(system.inner, Nowhere()).at(orbit.x).residual
    with pytest.raises(ConvergenceError, match="the condition of XX"):
        solve_special_orbit(system.inner, orbit.x, Nowhere())


def test_new_meshes_and_references_renew_the_condition(free_orbit):
    inner, orbit = extend(free_orbit, ("omega", "c"))
    system = extend_system(inner.inner, Nowhere())
    renewed = system.update_reference(system.at(orbit.x))
    assert (system.defining.number, renewed.defining.number) == (0, 1)
    remeshed, x, others = renewed.remesh(renewed.at(orbit.x), [orbit.x, 2.0 * orbit.x], solved=True)
    assert remeshed.defining.number == 2
    assert np.array_equal(others[0], x) and len(others[1]) == len(x)
    assert remeshed.interpolate_from(system, orbit.x) == pytest.approx(x, abs=1e-12)
    assert remeshed.explain_unsettled_mesh() == system.inner.explain_unsettled_mesh()
    assert np.array_equal(system.mesh_independent_index, system.inner.mesh_independent_index)
