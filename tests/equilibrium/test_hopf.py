"""Points with roots on the imaginary axis, against closed forms."""

import math

import numpy as np
import pytest

from pddecont.delay import Chain
from pddecont.equilibrium import HopfPoint, HopfProblem, solve_hopf
from pddecont.errors import ConvergenceError
from tests.equilibrium.motions import WRIGHT, make_motion

DUFFING = {
    "name": "duffing",
    "states": ["x", "v"],
    "parameters": {"b": 0.17, "tau": 17.4},
    "modes": {"m": {"x'": "v", "v'": "-0.05*v - 0.5*x - x**3 - b*(x - x(t - tau))"}},
    "initial": {"x": 1},
}


def guess(states, frequencies, vectors, p):
    """Return a guess of a point."""
    return HopfPoint(np.array(states), np.array(frequencies), np.array(vectors, dtype=complex), np.array(p))


def test_the_logistic_equation_has_its_hopf_point_at_half_of_pi():
    motion, p = make_motion(WRIGHT)
    problem = HopfProblem(motion, (1,), np.array([0.1]), np.array([1.0]))
    point = solve_hopf(problem, guess([1.02], [0.95], [[0.3 + 0.1j]], [p[0], 1.65]))
    assert point.parameters[1] == pytest.approx(math.pi / 2, abs=1e-14)
    assert point.frequencies[0] == pytest.approx(1.0, abs=1e-14)
    assert point.states[0] == pytest.approx(1.0, abs=1e-14)
    assert point.error < 1e-13


def test_a_chain_has_its_own_hopf_point():
    """1 + i w tau / n = (cos u)^-1 exp(i u) with n u = pi/2, so w = cos(u)^n and tau = n tan(u) / w."""
    n = 20
    motion, p = make_motion(WRIGHT, Chain(1, n))
    problem = HopfProblem(motion, (1,), np.array([0.1]), np.array([1.0]))
    point = solve_hopf(problem, guess([1.02], [0.95], [[0.3 + 0.1j]], [p[0], 1.65]))
    u = math.pi / (2 * n)
    assert point.frequencies[0] == pytest.approx(math.cos(u) ** n, abs=1e-13)
    assert point.parameters[1] == pytest.approx(n * math.tan(u) / math.cos(u) ** n, abs=1e-12)


def test_two_pairs_meet_the_scalar_equation_of_each():
    """-w^2 + 0.05 i w + 0.5 + b (1 - exp(-i w tau)) = 0 for both frequencies."""
    motion, p = make_motion(DUFFING)
    problem = HopfProblem(motion, (0, 1), np.array([0.1, 0.1]), np.array([0.7, 20.0]))
    first, second = 0.71, 0.92
    vectors = [[1.0, 1j * first], [1.0, 1j * second]]
    point = solve_hopf(problem, guess([0.01, 0.0], [first, second], vectors, p))
    b, tau = point.parameters
    for w in point.frequencies:
        assert abs(-(w**2) + 0.05j * w + 0.5 + b * (1 - np.exp(-1j * w * tau))) < 1e-13
    assert point.parameters == pytest.approx([0.17372466484, 17.41694540797], abs=1e-10)
    assert np.max(np.abs(point.states)) < 1e-13


def test_two_pairs_of_a_lag_that_moves():
    """The lag tau + 3 sin x - v^2 is tau at rest: the points are the same."""
    moving = {
        **DUFFING,
        "modes": {"m": {"x'": "v", "v'": "-0.05*v - 0.5*x - x**3 - b*(x - x(t - tau - 3*sin(x) + v**2))"}},
    }
    motion, p = make_motion(moving)
    problem = HopfProblem(motion, (0, 1), np.array([0.1, 0.1]), np.array([0.7, 20.0]))
    point = solve_hopf(problem, guess([0.01, 0.0], [0.71, 0.92], [[1.0, 0.71j], [1.0, 0.92j]], p))
    assert point.parameters == pytest.approx([0.17372466484, 17.41694540797], abs=1e-10)
    assert np.max(np.abs(point.states)) < 1e-13


def test_two_pairs_with_a_past_rate_and_an_integral():
    """-w^2 + 0.05 i w + 1/2 + b (1 - e^(-i w tau)) + 0.02 i w e^(-2 i w) + (1 - e^(-i w)) / (50 i w) = 0 for both."""
    mixed = {
        **DUFFING,
        "modes": {
            "m": {
                "x'": "v",
                "v'": "-0.05*v - 0.5*x - x**3 - b*(x - x(t - tau)) - 0.02*x'(t - 2)"
                " - integral(x(t - s)/50, s, 0, 1 + v)",
            }
        },
    }
    motion, p = make_motion(mixed)
    problem = HopfProblem(motion, (0, 1), np.array([0.1, 0.1]), np.array([0.7, 20.0]))
    point = solve_hopf(problem, guess([0.01, 0.0], [0.71, 0.92], [[1.0, 0.71j], [1.0, 0.92j]], p))
    b, tau = point.parameters
    for w in point.frequencies:
        e = 0.02j * w * np.exp(-2j * w) + (1 - np.exp(-1j * w)) / (50j * w)
        assert abs(-(w**2) + 0.05j * w + 0.5 + b * (1 - np.exp(-1j * w * tau)) + e) < 1e-13


def test_the_units_of_states_and_time_do_not_change_the_point():
    """States in units of 1e-5, time in units of 1e6."""
    small = {**WRIGHT, "modes": {"m": {"x'": "1e6*r*x*(1 - x(t - tau)/1e5)"}}}
    motion, p = make_motion(small)
    problem = HopfProblem(motion, (1,), np.array([1e4]), np.array([1e-6]))
    point = solve_hopf(problem, guess([1.02e5], [0.95e6], [[3e4]], [p[0], 1.65e-6]))
    assert point.parameters[1] * 1e6 == pytest.approx(math.pi / 2, abs=1e-13)


def test_where_there_is_no_such_point_it_is_said():
    """x' = r x (1 - x) has no complex root at all."""
    motion, p = make_motion({**WRIGHT, "modes": {"m": {"x'": "r*x*(1 - x) + 0*x(t - tau)"}}})
    problem = HopfProblem(motion, (1,), np.array([0.1]), np.array([1.0]))
    with pytest.raises(ConvergenceError):
        solve_hopf(problem, guess([1.0], [0.9], [[1.0]], p))
