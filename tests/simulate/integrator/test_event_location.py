"""Every zero of an event function within a step is found, once, and located to rounding."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.delay import Chain, Direct
from pddecont.simulate import simulate
from tests.conftest import numeric_from
from tests.simulate.motions import COUNTER, TIGHT, trajectory_of


class Step:
    """A step of length 1 from t = 0 over which the first state is t: an event function of c is one of time."""

    def __init__(self, interpreted, h):
        run = interpreted.start(COUNTER.replace("H}", h + "}").replace("DIR", "any"), [0.0, 0.0])
        self.core, self.interpreted = run.core, interpreted
        self.core.extension[:] = 0.0
        self.core.extension[0] = 1.0

    def first(self, direction, side):
        return self.interpreted.event_location.find_first_crossing(self.core, 0, direction, 0.0, 1.0, side, 0.0)


@settings(max_examples=50, deadline=None)
@given(roots=st.lists(st.integers(1, 99), min_size=1, max_size=4, unique=True), direction=st.sampled_from([-1, 0, 1]))
def test_the_first_root_in_a_direction_is_found(interpreted, roots, direction):
    """h = (c - r1)(c - r2)... rises and falls in turn."""
    # No root is where a step is halved.
    roots = sorted(r / 101 for r in roots)
    step = Step(interpreted, "*".join(f"(c - {r!r})" for r in roots))
    side = 1 if len(roots) % 2 == 0 else -1
    rises = [-side * (-1) ** k for k in range(len(roots))]
    expected = [r for r, rise in zip(roots, rises, strict=True) if direction in (0, rise)]
    s, after = step.first(direction, side)
    if expected:
        # A small slope at the root makes a large error of a value that is rounded at 1e-17.
        slope = abs(math.prod(expected[0] - r for r in roots if r != expected[0]))
        assert s == pytest.approx(expected[0], abs=1e-14 + 1e-16 / slope)
        assert after in (-1, 1)
    else:
        assert (s, after) == (-1.0, side * (-1) ** len(roots))


@pytest.mark.parametrize(
    ("h", "side", "expected"),
    [
        ("c + 1", 1, -1.0),  # far from zero
        ("c*(c - 0.5)", 0, 0.5),  # begins on its zero
        ("c*(c + 1)", 0, -1.0),  # begins on its zero and leaves it
        ("(c - 0.5)**2", 1, -1.0),  # touches
        ("(c - 0.5)**3", -1, 0.5),  # crosses with no slope
        ("c**2 - 1e-12", -1, 1e-6),  # close to the beginning
        ("sin(20*c) - 0.3", -1, math.asin(0.3) / 20),  # many zeros
    ],
)
def test_zeros_of_every_kind(interpreted, h, side, expected):
    s, _ = Step(interpreted, h).first(0, side)
    assert s == pytest.approx(expected, abs=1e-5 if "**3" in h else 1e-13)


def test_a_function_that_varies_too_fast_is_not_resolved(interpreted):
    step = Step(interpreted, "sin(5000*c) + 0.1")
    step.first(0, 1)
    assert step.core.count[interpreted.places.UNRESOLVED] == 1


def test_the_bernstein_form_is_the_polynomial(interpreted):
    location = interpreted.event_location
    values = np.polynomial.Polynomial([1, -2, 0, 3, 0, 0, 0.5, 0, 4])(location.NODES)
    coefficients = location.TO_BERNSTEIN @ values
    assert location.AT_CHECKS @ coefficients == pytest.approx(
        np.polynomial.Polynomial([1, -2, 0, 3, 0, 0, 0.5, 0, 4])(location.CHECKS)
    )
    assert coefficients[[0, -1]] == pytest.approx(values[[0, -1]])


@pytest.mark.parametrize(
    ("direction", "expected"),
    [("any", np.arange(1, 1001)), ("falling", np.arange(1, 1001, 2)), ("rising", np.arange(2, 1001, 2))],
)
def test_no_zero_of_an_oscillating_event_is_lost_where_the_states_are_smooth(direction, expected):
    """The steps of c' = 1 grow without bound; sin(pi c) is then far from a polynomial along a step."""
    trajectory = trajectory_of(COUNTER.replace("H}", "sin(pi*c)}").replace("DIR", direction), 1000.5)
    assert len(trajectory.events) == len(expected)
    assert trajectory.events.t == pytest.approx(expected, abs=1e-10)


@pytest.mark.parametrize("per_period", [10, 100, 400])
def test_many_zeros_within_a_forcing_period(per_period):
    text = (
        "name: f\nstates: [n]\nparameters: {p: 2}\nforcing: {period: p}\nmodes: {m: {n': 0}}\nevents: {e: "
        "sin(W*pi*t)}\n"
        "resets: {add: {n: n + 1}}\nsegments: {s: {mode: m, event: e, direction: any, reset: add, to: m}}\n"
    )
    trajectory = trajectory_of(text.replace("W", str(per_period)), 10 + 0.5 / per_period)
    assert trajectory.events.t == pytest.approx(np.arange(1, 10 * per_period + 1) / per_period, abs=1e-11)


@pytest.mark.parametrize("overlap", [1e-2, 1e-4, 1e-6])
def test_a_double_crossing_within_a_step_is_found(overlap):
    text = COUNTER.replace("H}", f"(c - 3.3)**2 - {overlap**2!r}}}").replace("DIR", "any")
    trajectory = trajectory_of(text, 10.0)
    assert trajectory.events.t == pytest.approx([3.3 - overlap, 3.3 + overlap], abs=1e-13 / overlap + 1e-12)
    none = trajectory_of(COUNTER.replace("H}", f"(c - 3.3)**2 + {overlap**2!r}}}").replace("DIR", "any"), 10.0)
    assert len(none.events) == 0


def test_double_crossings_at_each_turn_of_an_oscillation():
    """x = cos 10 t exceeds 1 - 1e-8 for 2.8e-5 time units at each maximum."""
    text = (
        "name: d\nstates: [x, v, n]\nparameters: {p: 6}\nforcing: {period: p}\nmodes: {m: {x': v, v': -100*x, n': 0}}\n"
        "events: {e: x - 0.99999999}\nresets: {add: {n: n + 1}}\n"
        "segments: {s: {mode: m, event: e, direction: any, reset: add, to: m}}\ninitial: {x: 1}\n"
    )
    trajectory = trajectory_of(text, 20.0)
    half = math.acos(1 - 1e-8) / 10
    centres = np.arange(1, 32) * math.pi / 5
    # x passes the surface at the speed 10 sin(10 half) = 1.4e-3: an error of x becomes one of the time 700 times as
    # large.
    assert trajectory.events.t == pytest.approx(
        [half, *np.sort([*(centres - half), *(centres + half)])], abs=5e-11 / (10 * math.sin(10 * half))
    )


# Jumps that are read later.
JUMPS = (
    "name: j\nstates: [x, y, n, c]\nparameters: {tau: 1}\nmodes: {m: {x': 0, y': x(t - tau), n': 0, c': 1}}\n"
    "events: {tick: c - 1, seen: x(t - tau) - 0.5}\nresets: {flip: {x: 1 - x, c: 0}, count: {n: n + 1}}\nsegments:\n"
    "  tick: {mode: m, event: tick, direction: rising, reset: flip, to: m}\n"
    "  seen: {mode: m, event: seen, direction: any, reset: count, to: m}\n"
)


@pytest.mark.parametrize("tau", [0.1, 0.7, 1.0, 2.0, 3.3])
def test_an_event_sees_a_delayed_value_jump(tau):
    """x flips between 0 and 1 at every whole number, and its delayed value passes 1/2 at every whole number + tau."""
    numeric = numeric_from(JUMPS)
    trajectory = simulate(numeric, np.array([tau]), Direct(), 10.45, TIGHT)
    seen = trajectory.events.t[np.array(trajectory.events.segment) == "seen"]
    expected = np.arange(1, 11) + tau
    assert len(seen) == np.sum(expected < 10.45)
    assert seen == pytest.approx(expected[expected < 10.45], abs=1e-12)
    ones = sum(min(max(10.45 - tau - k, 0.0), 1.0) for k in range(1, 11, 2))
    assert trajectory(10.45)[1] == pytest.approx(ones, abs=1e-12)


def test_events_of_every_direction_are_seen():
    text = (
        "name: m\nstates: [x]\nparameters: {w: 1}\nforcing: {period: 2*pi/w}\nmodes: {m: {x': cos(w*t)}}\nevents: {e: "
        "x - 0.5}\n"
        "segments: {s: {mode: m, event: e, direction: DIRECTION, to: m}}\n"
    )
    rising, falling = math.asin(0.5), math.pi - math.asin(0.5)
    for direction, times in (("rising", [rising]), ("falling", [falling]), ("any", [rising, falling])):
        numeric = numeric_from(text.replace("DIRECTION", direction))
        trajectory = simulate(numeric, numeric.parameter_values, Chain(2, 15), 6.0, TIGHT)
        assert trajectory.events.t == pytest.approx(times, abs=1e-11)
