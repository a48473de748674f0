"""The vector field of a motion that stays, and its linearisation."""

import math
from dataclasses import replace

import numpy as np
import pytest

from pddecont.errors import ConvergenceError
from tests.equilibrium.motions import TWO_DELAYS, make_motion


def test_the_rate_reads_the_present_state_for_every_delayed_value():
    motion, p = make_motion(TWO_DELAYS)
    x, y = 0.4, -0.3
    expected = [-1.2 * (x + y) * (1 + x), 3 * (x - y) + 0.5 * x * y]
    assert np.allclose(motion.rate(np.array([x, y]), p), expected, rtol=1e-15)


def test_the_linearisation_is_that_of_pen_and_paper():
    motion, p = make_motion(TWO_DELAYS)
    x, y = 0.4, -0.3
    matrix = motion.linearise(np.array([x, y]), p)
    assert np.allclose(matrix.present, [[-1.2 * (x + y), 0.0], [3.0, -3.0 + 0.5 * x]], rtol=1e-15)
    by_delay = dict(zip(matrix.delays.tolist(), matrix.delayed, strict=True))
    assert np.allclose(by_delay[1.0], [[-1.2 * (1 + x), 0.0], [0.0, 0.0]], rtol=1e-15)
    assert np.allclose(by_delay[1.5], [[0.0, -1.2 * (1 + x)], [0.5 * y, 0.0]], rtol=1e-15)


def test_all_partial_derivatives_together_are_that_of_the_rate():
    motion, p = make_motion(TWO_DELAYS)
    x, h = np.array([0.2, 0.5]), 1e-6
    matrix = motion.linearise(x, p)
    whole = matrix.present + sum(matrix.delayed)
    ends = [[motion.rate(x + sign * h * unit, p) for unit in np.eye(2)] for sign in (-1.0, 1.0)]
    assert np.allclose(whole, (np.array(ends[1]) - ends[0]).T / (2 * h), atol=1e-9)


EVERY = {
    "name": "every",
    "states": ["x", "y"],
    "parameters": {"a": 2.0, "q": 0.5, "b": 0.25},
    "modes": {
        "m": {
            "x'": "-x(t - 1 - y(t - b - x)) + x'(t - a - x)*y + integral(exp(-q*s)*x(t - s)**2, s, b, a + y)",
            "y'": "x - y(t - a)",
        }
    },
    "initial": {"x": 0.1},
}


def test_at_rest_lags_are_those_of_present_values():
    """Nested ones too; rates are zero, and the integral is x^2 (e^(-q b) - e^(-q (a + y))) / q."""
    motion, p = make_motion(EVERY)
    x, y = 0.7, -0.2
    at = np.array([x, y])
    whole = x**2 * (math.exp(-0.125) - math.exp(-0.5 * (2 + y))) / 0.5
    assert motion.rate(at, p) == pytest.approx([-x + whole, x - y], rel=1e-15)
    lags = motion.reads.find_lags(at, motion.read(at, p), p)
    assert sorted(lags) == pytest.approx(sorted([0.25, 2.0, 1 + y, 0.25 + x, 2 + x, 2 + y]), rel=1e-15)


def test_a_negative_lag_is_found_where_the_mode_reads_by_it():
    motion, p = make_motion(EVERY)
    assert motion.find_negative_lag(np.array([0.7, -0.2]), p) is None
    delay, lag = motion.find_negative_lag(np.array([-0.5, -0.2]), p)
    assert delay == "b + x" and lag == pytest.approx(-0.25)
    unused = {
        **EVERY,
        "modes": {**EVERY["modes"], "other": {"x'": "-x", "y'": "-y"}},
        "events": {"edge": "y"},
        "segments": {
            "go": {"mode": "m", "event": "edge", "direction": "rising", "to": "other"},
            "back": {"mode": "other", "event": "edge", "direction": "falling", "to": "m"},
        },
    }
    other = replace(make_motion(unused)[0], mode="other")
    assert other.find_negative_lag(np.array([-0.5, -0.2]), p) is None


def test_an_integral_without_a_value_is_no_number():
    motion, p = make_motion({**EVERY, "modes": {"m": {"x'": "integral(x(t - s)/s, s, 0, a)", "y'": "-y + b*q"}}})
    with pytest.raises(ConvergenceError, match="no finite value"):
        motion.rate(np.array([0.5, 0.0]), p)
