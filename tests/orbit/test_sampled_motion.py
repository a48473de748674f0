"""Curves through rows, with the two sides of a jump kept apart."""

import numpy as np
import pytest

from pddecont.orbit.sampled_motion import close_rows, join_rows


def test_a_closed_motion_repeats_itself_and_is_smooth_where_it_closes():
    t = np.linspace(1.0, 5.0, 81)
    phase = 0.5 * np.pi * (t - 1.0)
    motion = close_rows(t, np.stack([np.sin(phase), np.cos(phase)], axis=1))
    assert motion.period == pytest.approx(4.0)
    at = np.array([0.99, 1.01, 4.99, 5.01, -7.01, 21.3])
    exact = np.stack([np.sin(0.5 * np.pi * (at - 1.0)), np.cos(0.5 * np.pi * (at - 1.0))], axis=1)
    assert motion.evaluate(at) == pytest.approx(exact, abs=1e-3)
    slopes = 0.5 * np.pi * np.stack([exact[:, 1], -exact[:, 0]], axis=1)
    assert motion.evaluate(at, 1) == pytest.approx(slopes, abs=0.02)


def test_the_error_between_rows_falls_with_their_distance():
    def miss(n):
        t = np.linspace(0.0, 1.0, n + 1)
        middles = 0.5 * (t[1:] + t[:-1])
        motion = close_rows(t, np.sin(2 * np.pi * t)[:, None])
        return np.max(np.abs(motion.evaluate(middles)[:, 0] - np.sin(2 * np.pi * middles)))

    errors = np.array([miss(n) for n in (20, 40, 80, 160)])
    orders = np.log2(errors[:-1] / errors[1:])
    assert np.all(orders > 1.9), orders


def test_what_lies_between_two_jumps_sees_nothing_beyond_them():
    rows = [np.array([0.0, 0.5, 1.0]), np.array([1.0, 1.5, 2.0])]
    states = [np.array([[0.0], [0.5], [1.0]]), np.array([[5.0], [4.5], [4.0]])]
    motion = join_rows(rows, states, np.array([0.0, 1.0, 2.0]))
    at = np.array([0.0, 0.25, 1.0])
    assert motion.evaluate_between(at, 0.0, 1.0)[:, 0] == pytest.approx([0.0, 0.25, 1.0])
    assert motion.evaluate_between(at + 1.0, 1.0, 2.0)[:, 0] == pytest.approx([5.0, 4.75, 4.0])
    # The same a period and three periods later, and over a place where states could jump and a segment does not end.
    assert motion.evaluate_between(at + 2.0, 2.0, 3.0)[:, 0] == pytest.approx([0.0, 0.25, 1.0])
    assert motion.evaluate_between(at + 7.0, 7.0, 8.0)[:, 0] == pytest.approx([5.0, 4.75, 4.0])
    assert motion.evaluate_between(np.array([1.5, 2.0, 2.5]), 1.5, 2.5)[:, 0] == pytest.approx([4.5, 0.0, 0.5])
    # At a jump alone the motion is what it is after it.
    assert motion.evaluate(np.array([1.0, 2.0, 3.0]))[:, 0] == pytest.approx([5.0, 0.0, 5.0])


def test_rows_that_few_digits_put_at_one_time_are_one_row():
    t = np.array([0.0, 0.25, 0.25, 0.5, 0.75, 1.0])
    x = np.array([0.0, 0.9, 1.1, 0.0, -1.0, 0.02])
    motion = close_rows(t, x[:, None])
    assert motion.evaluate(np.array([0.0, 0.25, 1.0]))[:, 0] == pytest.approx([0.01, 1.0, 0.01])


def test_two_rows_are_a_line():
    motion = join_rows([np.array([0.0, 2.0])], [np.array([[1.0], [3.0]])], np.array([0.0, 2.0]))
    assert motion.evaluate_between(np.array([0.0, 0.5, 2.0]), 0.0, 2.0)[:, 0] == pytest.approx([1.0, 1.5, 3.0])
