"""Trajectories evaluated inside their steps, at their events, and at even times."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pddecont.delay import Chain
from pddecont.simulate import simulate
from tests.conftest import shipped
from tests.simulate.motions import BALL, trajectory_of

# x = cos t; n counts the zeros of x that fall.
COSINE = (
    "name: c\nstates: [x, v, n]\nmodes: {m: {x': v, v': -x, n': 0}}\nevents: {zero: x}\nresets: {add: {n: n + 1}}\n"
    "segments: {s: {mode: m, event: zero, direction: falling, reset: add, to: m}}\ninitial: {x: 1}\n"
)


@pytest.fixture(scope="module")
def cosine():
    return trajectory_of(COSINE, 30.0)


@given(st.floats(0.0, 30.0))
def test_inside_every_step_it_is_the_solution(cosine, t):
    x, v, n = cosine(t)
    assert (x, v) == pytest.approx((math.cos(t), -math.sin(t)), abs=1e-9)
    if abs((t - math.pi / 2) % (2 * math.pi)) > 1e-9:
        assert n == pytest.approx(math.floor((t - math.pi / 2) / (2 * math.pi)) + 1, abs=1e-9)


@given(st.lists(st.floats(0.0, 30.0), min_size=1, max_size=20))
def test_many_times_are_as_one_by_one(cosine, times):
    assert np.array_equal(cosine(np.array(times)), [cosine(t) for t in times])


@given(st.integers(0, 4), st.floats(0.0, 1.0))
def test_an_arc_is_read_between_its_events(cosine, arc, share):
    bounds = [0.0, *cosine.events.t, 30.0]
    t = bounds[arc] + share * (bounds[arc + 1] - bounds[arc])
    assert cosine.evaluate_arc(arc, np.array([t]))[0] == pytest.approx([math.cos(t), -math.sin(t), arc], abs=1e-9)


def test_at_an_event_the_state_is_that_after_it(cosine):
    for k, t in enumerate(cosine.events.t):
        assert cosine(t)[2] == k + 1
        assert cosine.evaluate_arc(k, np.array([t]))[0, 2] == pytest.approx(k)
    # The floor turns the ball round where the trajectory ends.
    ball = trajectory_of(BALL, math.sqrt(2 / 9.81) + 1e-15)
    assert len(ball.events) == 1
    assert ball(ball.t_end)[1] == pytest.approx(0.8 * math.sqrt(2 * 9.81))
    assert ball(ball.t_end - 1e-6)[1] == pytest.approx(-math.sqrt(2 * 9.81), rel=1e-5)


def test_an_arc_of_no_length_has_the_states_after_its_event():
    text = (
        "name: o\nstates: [x, c]\nmodes: {m: {x': 0, c': 1}}\nevents: {a: c - 1, b: 2*c - 2}\nresets: {p: {x: x + 1}}\n"
        "segments:\n  A: {mode: m, event: a, direction: rising, reset: p, to: m}\n"
        "  B: {mode: m, event: b, direction: rising, reset: p, to: m}\n"
    )
    trajectory = trajectory_of(text, 2.0)
    assert trajectory.evaluate_arc(1, np.array([1.0, 1.5])) == pytest.approx(np.array([[1, 1], [1, 1]]))
    assert trajectory.find_mode(1) == "m"


def test_samples_hold_both_sides_of_events(cosine):
    times, states, modes = cosine.sample(3)
    assert np.all(np.diff(times) >= 0)
    assert len(modes) == len(times) == len(states)
    for k, t in enumerate(cosine.events.t):
        assert sorted(states[times == t, 2]) == pytest.approx([k, k + 1])
    assert (times[0], times[-1]) == (0.0, 30.0)


@pytest.mark.parametrize(("interval", "start", "n"), [(0.1, 0.0, 301), (7.0, 1.0, 5), (30.0, 0.0, 2), (40.0, 0.0, 1)])
def test_even_samples_reach_as_far_as_the_trajectory(cosine, interval, start, n):
    times, states, modes = cosine.sample_every(interval, start)
    assert times == pytest.approx(start + interval * np.arange(n))
    assert states[:, 0] == pytest.approx(np.cos(times), abs=1e-9)
    assert modes == ["m"] * n


def test_a_recorded_trajectory_never_passes_its_events():
    numeric = shipped("wall_oscillator")
    trajectory = simulate(numeric, numeric.parameter_values, Chain(2, 15), 20 * math.pi)
    times, states, _ = trajectory.sample()
    assert np.all(np.diff(times) >= 0)
    assert np.max(states[:, 0]) <= 0.2 + 1e-9
