"""The side of curves of special equilibria against closed forms."""

import math

import numpy as np
import pytest

from pddecont.codegen import NumericModel
from pddecont.continuation import NewtonSettings, correct
from pddecont.delay import Direct
from pddecont.equilibrium import (
    ConstantMotion,
    Equilibrium,
    EquilibriumProblem,
    EquilibriumSystem,
    find_better_side,
    make_critical_start,
    measure_sizes,
)
from tests.runs import plan

WIDTHS = (2.0, 0.5)


def find_side(model, free, label, states, parameters, mode="m", event=""):
    """Return the side of the special point near a guess, divided by the widths of the ranges, and the parameters."""
    steps = [{"name": "t", "simulate": {"t_end": 1}}]
    numeric = NumericModel(plan({**model, "run": {"steps": steps}}).model)
    numbers = tuple(numeric.parameter_index(name) for name in free)
    motion, p = ConstantMotion(numeric, mode, Direct()), np.array(parameters, dtype=float)
    problem = EquilibriumProblem(motion, p, numbers)
    at = Equilibrium(motion, np.array(states, dtype=float), p)
    inner = EquilibriumSystem(problem, measure_sizes(at.states), WIDTHS)
    system, start = make_critical_start(inner, label, event, at)
    null = np.linalg.svd(system.at(start).jacobian())[2][-1]
    found = correct(system, start, null, NewtonSettings()).at
    side = find_better_side(found)
    assert np.linalg.norm(side / WIDTHS) == pytest.approx(1.0) or np.all(np.isnan(side))
    return side, found.equilibrium.parameters[list(numbers)]


def direct(gradient):
    """Return the direction of a gradient in the plane of the parameters in units of their ranges, as it is recorded."""
    scaled = np.array(gradient) * WIDTHS
    return scaled / np.linalg.norm(scaled) * WIDTHS


def test_below_the_hopf_curve_of_the_delayed_logistic_equation_fewer_roots_are_unstable():
    """x' = -r x(t - tau): r tau = pi/2 along the curve, stable below; the gradient of r tau is (tau, r)."""
    model = {
        "name": "w",
        "states": ["x"],
        "parameters": {"r": 1.5, "tau": 1.0},
        "modes": {"m": {"x'": "-r*x(t - tau)*(1 + x)"}},
        "initial": {"x": 0.1},
    }
    side, (r, tau) = find_side(model, ["r", "tau"], "HB", [0.0], [1.5, 1.05])
    assert r * tau == pytest.approx(math.pi / 2, abs=1e-12)
    assert side == pytest.approx(direct([-tau, -r]), abs=1e-8)


TAKENS = {
    "name": "bt",
    "states": ["x", "y"],
    "parameters": {"a": 0.2, "b": -1.0},
    "modes": {"m": {"x'": "y", "y'": "a + b*x + x**2 + x*y"}},
    "initial": {"x": 0.1},
}


def test_equilibria_exist_on_the_inner_side_of_a_fold():
    """x = -b/2 +- sqrt(b^2/4 - a): where a < b^2/4."""
    for b in (-1.0, 0.7):
        side, (_, at) = find_side(TAKENS, ["a", "b"], "LP", [-b / 2, 0.0], [b * b / 4, b])
        assert side == pytest.approx(direct([-1.0, at / 2]), abs=1e-8)


def test_a_curve_of_hopf_points_that_is_an_axis_has_its_side_across_it():
    """The trace at the equilibrium is x, zero at a = 0, where dx/da = -1/b > 0 and dx/db = 0."""
    side, (a, _) = find_side(TAKENS, ["a", "b"], "HB", [0.0, 0.0], [0.0, -0.8])
    assert a == pytest.approx(0.0, abs=1e-12)
    assert side == pytest.approx([-WIDTHS[0], 0.0], abs=1e-8)


def test_a_fold_whose_root_zero_is_double_has_its_side():
    side, _ = find_side(TAKENS, ["b", "a"], "LP", [0.0, 0.0], [0.0, 0.0])
    assert side == pytest.approx([0.0, -WIDTHS[1]], abs=1e-8)


def test_a_cusp_has_none():
    model = {
        "name": "cusp",
        "states": ["x"],
        "parameters": {"a": 0.0, "b": 0.0},
        "modes": {"m": {"x'": "a + b*x - x**3"}},
        "initial": {"x": 0.1},
    }
    assert np.all(np.isnan(find_side(model, ["a", "b"], "LP", [0.0], [0.0, 0.0])[0]))
    # Beside it, on b = 3 x^2, a = -2 x^3, three equilibria stand against one inside a^2 = 4 b^3 / 27.
    side, (a, b) = find_side(model, ["a", "b"], "LP", [0.4], [-2 * 0.4**3, 3 * 0.4**2])
    assert side == pytest.approx(direct([-2.0 * a, 12.0 * b**2 / 27.0]), abs=1e-7)


def test_a_boundary_equilibrium_lies_in_its_mode_on_one_side():
    """x' = k - x, left beyond x = m: the equilibrium x = k is in the mode where m - k > 0."""
    model = {
        "name": "be",
        "states": ["x"],
        "parameters": {"m": 1.0, "k": 1.0},
        "equations": {"x'": "k - x - max(0, x - m)"},
        "initial": {"x": 0.1},
    }
    for mode, sign in (("x_below", 1.0), ("x_above", -1.0)):
        side, _ = find_side(model, ["m", "k"], "BE", [1.0], [1.0, 1.0], mode, "x")
        assert side == pytest.approx(direct([sign, -sign]), abs=1e-8)
