"""Newton's method: how it converges, when it damps its steps, and what it says when it does not arrive."""

import math
from itertools import count

import numpy as np
import pytest

from pddecont.continuation import NewtonSettings, equilibrate, newton, solve_newton
from pddecont.errors import ConvergenceError
from tests.continuation.systems import Algebraic


def solve(equations, derivatives, x, scale=None, settings=None, sparse=False):
    """Solve equations given as functions; sizes of unknowns are one by default."""
    x = np.array(x, dtype=float)
    system = Algebraic(equations, derivatives, sparse=sparse)
    return solve_newton(system.at, x, np.ones(len(x)) if scale is None else np.array(scale), settings)


@pytest.mark.parametrize("sparse", [False, True])
def test_newton_converges_quadratically_and_keeps_its_history(sparse):
    solution = solve(lambda x: x**2 - 2, lambda x: np.diag(2 * x), [1.0], sparse=sparse)
    assert solution.x[0] == pytest.approx(math.sqrt(2), abs=1e-15)
    errors = solution.history
    assert errors[3] < 10 * errors[2] ** 2
    # Rows are scaled by the Jacobian's largest entry: (1 - 2) / 2 before the first step.
    assert errors[0] == 0.5


def test_newton_damps_where_a_full_step_overshoots():
    solution = solve(np.arctan, lambda x: np.diag(1 / (1 + x**2)), [3.0])
    assert solution.x[0] == pytest.approx(0, abs=1e-12)
    assert list(solution.history) == sorted(solution.history, reverse=True)


def test_failures_carry_their_history():
    with pytest.raises(ConvergenceError) as info:
        solve(lambda x: x**2 + 1, lambda x: np.diag(2 * x), [1.0])
    assert len(info.value.history) >= 1
    with pytest.raises(ConvergenceError, match="singular"):
        solve(lambda x: x + 1, lambda x: np.zeros((1, 1)), [1.0])


def test_steps_that_stay_large_are_told_where_the_equations_hold():
    """Two equations that are one but for 1e-13: rounding of 1e-15 moves the solution by 1e-2."""
    matrix, call = np.array([[1.0, 1.0], [1.0, 1.0 + 1e-13]]), count()

    def residual(x):
        return np.array([1e-15, -1e-15]) * (-1.0) ** next(call)

    with pytest.raises(ConvergenceError) as caught:
        solve(residual, lambda x: matrix, np.zeros(2))
    assert "did not converge in 12 iterations (the equations hold to 1.0e-15, but the unknowns still move" in str(
        caught.value
    )
    assert "the last steps are 2.0e-02, 2.0e-02, 2.0e-02, expected below 1e-08" in str(caught.value)


def test_residuals_that_stay_large_are_told():
    with pytest.raises(ConvergenceError, match=r"did not converge in 12 iterations \(residuals: 1\.0e\+00, "):
        solve(lambda x: np.exp(-x), lambda x: np.diag(-np.exp(-x)), np.zeros(1))


def test_the_solution_solves_with_its_last_jacobian():
    def derivatives(x):
        return np.array([[2 * x[0], 1.0], [x[1], x[0]]])

    solution = solve(lambda x: [x[0] ** 2 + x[1] - 5, x[0] * x[1] - 2], derivatives, [2.2, 1.2], scale=[5.0, 0.1])
    rhs = np.array([0.3, -0.8])
    assert derivatives(solution.x) @ solution.solve(rhs) == pytest.approx(rhs, abs=1e-7)


@pytest.mark.parametrize("sparse", [False, True])
def test_few_steps_with_one_jacobian_lead_to_the_solution_to_rounding(monkeypatch, sparse):
    """From 1.41 the first step leaves 6e-6; the next Newton step would leave 1e-11, and one more rounding."""
    monkeypatch.setattr(newton, "LARGE", 1)
    asked = []

    def derivatives(x):
        asked.append(x[0])
        return np.diag(2 * x)

    solution = solve(lambda x: x**2 - 2, derivatives, [1.41], sparse=sparse)
    assert asked == [1.41]
    assert solution.x[0] == pytest.approx(math.sqrt(2), abs=1e-15)
    assert solution.n_iterations == 3
    # What solves later has the Jacobian at the solution, not the one that led there.
    assert solution.solve(np.ones(1))[0] == pytest.approx(1 / math.sqrt(8), rel=1e-14)
    assert asked == [1.41, solution.x[0]]


@pytest.mark.parametrize(("larger", "n_asked"), [(1, 1), (1000, 2)])
def test_where_factors_are_dear_more_steps_are_taken_with_them(monkeypatch, larger, n_asked):
    monkeypatch.setattr(newton, "LARGE", 1)
    monkeypatch.setattr(newton, "LARGER", larger)
    asked = []
    solution = solve(lambda x: x**2 - 2, lambda x: asked.append(x[0]) or np.diag(2 * x), [1.37])
    assert len(asked) == n_asked
    assert solution.x[0] == pytest.approx(math.sqrt(2), abs=1e-15)


def test_steps_of_rounding_end_it():
    """Residuals off by 1e-13, now this way, now that: steps with the factors at hand stay that long."""
    call = count()

    def residual(x):
        return x**2 - 2.0 + 1e-13 * (-1.0) ** next(call)

    asked = []
    near = equilibrate(np.diag([2 * math.sqrt(2.00001)]), np.ones(1)).factor()
    system = Algebraic(residual, lambda x: asked.append(x) or np.diag(2 * x))
    solution = solve_newton(system.at, np.array([1.4143]), np.ones(1), near=near)
    assert solution.x[0] == pytest.approx(math.sqrt(2), abs=2e-13)
    assert not asked


def test_factors_of_a_point_nearby_lead_to_the_solution_to_rounding():
    """The square root of 2 by the slope at that of 2.001: every step is 4e-4 times as long as the one before."""
    asked = []

    def derivatives(x):
        asked.append(x[0])
        return np.diag(2 * x)

    system = Algebraic(lambda x: x**2 - 2, derivatives)
    near = equilibrate(np.diag([2 * math.sqrt(2.001)]), np.ones(1)).factor()
    solution = solve_newton(system.at, np.array([1.415]), np.ones(1), near=near)
    assert solution.x[0] == pytest.approx(math.sqrt(2), abs=1e-15)
    assert not asked and solution.factors is near
    assert solution.solve(np.ones(1))[0] == pytest.approx(1 / math.sqrt(8), rel=1e-14)


def test_factors_that_lead_on_slowly_are_left():
    system = Algebraic(lambda x: x**2 - 2, lambda x: np.diag(2 * x))
    far = equilibrate(np.diag([4.0]), np.ones(1)).factor()
    solution, alone = (solve_newton(system.at, np.array([1.5]), np.ones(1), near=near) for near in (far, None))
    assert solution.factors is not far
    assert (solution.x, solution.history, solution.n_iterations) == (alone.x, alone.history, alone.n_iterations)


def test_steps_with_one_jacobian_that_shrink_slowly_are_not_taken(monkeypatch):
    """Towards a double root every Newton step is half of the one before: each has its own Jacobian."""
    monkeypatch.setattr(newton, "LARGE", 1)
    asked = []

    def derivatives(x):
        asked.append(x[0])
        return np.diag(2 * x)

    settings = NewtonSettings(step_tol=1e-4, residual_tol=1e-4, max_iterations=30)
    solution = solve(lambda x: x**2, derivatives, [1.0], settings=settings)
    assert len(asked) == solution.n_iterations == 14


def test_units_of_unknowns_and_equations_change_nothing():
    """The same equations in other units take the same steps."""
    plain = solve(lambda x: [x[0] ** 2 - 2, x[0] * x[1] - 3], lambda x: [[2 * x[0], 0], [x[1], x[0]]], [1.0, 1.0])
    units, rows = np.array([1024.0, 2.0**-20]), np.array([2.0**30, 0.5])

    def equations(y):
        x = y / units
        return rows * [x[0] ** 2 - 2, x[0] * x[1] - 3]

    def derivatives(y):
        x = y / units
        return rows[:, None] * [[2 * x[0], 0], [x[1], x[0]]] / units

    scaled = solve(equations, derivatives, units, scale=units)
    assert np.array_equal(scaled.x, units * plain.x)
    assert scaled.history == plain.history


def test_a_step_into_a_region_without_values_is_shortened():
    """sqrt has no values beyond 0, where the first full step would go."""

    def equations(x):
        return np.sqrt(x) - 0.1 if x[0] >= 0 else [np.nan]

    assert solve(equations, lambda x: [[0.5 / np.sqrt(x[0])]], [1.0]).x[0] == pytest.approx(0.01, abs=1e-12)


def test_where_no_step_is_short_enough_the_obstacle_is_named():
    """Every step leads to where there are no values."""

    def equations(x):
        return [1.0] if x[0] == 0.0 else [np.nan]

    with pytest.raises(
        ConvergenceError, match=r"cannot lower the residual further \(residuals: 1\.0e\+00\); the equat"
    ):
        solve(equations, lambda x: [[1.0]], [0.0])


@pytest.mark.parametrize(("tol", "n"), [(1e-1, 2), (1e-8, 5)])
def test_the_last_step_is_as_small_as_asked(tol, n):
    """From 1 the steps are .5, .083, .0025, 2.1e-6 and 1.6e-12."""
    settings = NewtonSettings(step_tol=tol, residual_tol=1e-1)
    assert solve(lambda x: x**2 - 2, lambda x: np.diag(2 * x), [1.0], settings=settings).n_iterations == n


@pytest.mark.parametrize(("residual_tol", "n"), [(10.0, 1), (1.2, 2)])
def test_a_damped_step_is_never_the_last(residual_tol, n):
    """From 1.45 a full step leads to -1.55, where the residual is larger, half of it to -0.05.

    One that is cut short says nothing of the error that is left, however small it is.
    """
    settings = NewtonSettings(step_tol=10.0, residual_tol=residual_tol)
    assert solve(np.arctan, lambda x: np.diag(1 / (1 + x**2)), [1.45], settings=settings).n_iterations == n
