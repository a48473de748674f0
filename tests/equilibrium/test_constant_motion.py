"""The vector field of a motion that stays, and its linearisation."""

import numpy as np

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
