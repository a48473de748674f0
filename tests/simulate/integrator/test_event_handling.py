"""Events at one moment come in declared order; starts on a surface are no crossings."""

import math

import numpy as np
import pytest

from pddecont.delay import Direct
from pddecont.simulate import Method, Simulator, record_trajectory, simulate
from tests.conftest import numeric_from, shipped
from tests.simulate.motions import TIGHT, trajectory_of


# Events at one moment.
@pytest.mark.parametrize(("first", "second"), [("a", "b"), ("b", "a")])
@pytest.mark.parametrize("other", ["2*c - 2", "c**2 - 1", "exp(c) - exp(1)"])
def test_events_at_one_moment_come_in_the_order_of_their_segments(first, second, other):
    text = (
        "name: o\nstates: [x, c]\nmodes: {m: {x': 0, c': 1}}\nevents: {a: c - 1, b: OTHER}\nresets: {p: {x: 2*x + 1}, "
        "q: {x: 3*x}}\n"
        f"segments:\n  A: {{mode: m, event: {first}, direction: rising, reset: p, to: m}}\n"
        f"  B: {{mode: m, event: {second}, direction: rising, reset: q, to: m}}\n"
    ).replace("OTHER", other)
    trajectory = trajectory_of(text, 2.0)
    assert trajectory.events.segment == ("A", "B")
    assert trajectory.events.t == pytest.approx([1, 1], abs=1e-13)
    assert trajectory(2.0)[0] == 3.0


def test_a_reset_may_undo_an_event_at_the_same_moment():
    """At t = 1 both a and b are due, but the reset of A takes x away from b's surface."""
    text = (
        "name: o\nstates: [x, c]\nmodes: {m: {x': 1, c': 1}}\nevents: {a: c - 1, b: x - 1}\n"
        "resets: {p: {x: x - 5}, q: {x: 100}}\n"
        "segments:\n  A: {mode: m, event: a, direction: rising, reset: p, to: m}\n"
        "  B: {mode: m, event: b, direction: rising, reset: q, to: m}\n"
    )
    trajectory = trajectory_of(text, 3.0)
    assert trajectory.events.segment == ("A",)
    assert trajectory(3.0)[0] == pytest.approx(-2.0)


def test_a_mode_ends_by_its_own_segments_only():
    text = (
        "name: o\nstates: [c]\nmodes: {m: {c': 1}, n: {c': 2}}\nevents: {a: c - 1, b: c - 2}\n"
        "segments:\n  A: {mode: m, event: a, direction: rising, to: n}\n"
        "  B: {mode: n, event: b, direction: rising, to: m}\n"
    )
    trajectory = trajectory_of(text, 4.0)
    assert trajectory.events.segment == ("A", "B")
    assert trajectory.events.t == pytest.approx([1.0, 1.5])
    assert list(dict.fromkeys(trajectory.mode)) == ["m", "n"]


def test_an_event_of_either_mode_does_not_come_twice():
    """An identity reset leaves the state on the surface, to rounding on either side of it, also late."""
    numeric = shipped("impact_oscillator")
    simulator = Simulator(numeric, Direct(), Method())
    values = simulator.values(numeric.parameter_values)
    counts = []
    for turns in (0, 10_000, 1_000_000):
        t = turns * 2 * math.pi / 0.8
        trajectory = record_trajectory(simulator, numeric.parameter_values, simulator.start(values, t=t), t + 500.0)
        assert all(a != b for a, b in zip(trajectory.events.segment, trajectory.events.segment[1:], strict=False))
        counts.append(len(trajectory.events))
    assert counts[0] > 40
    assert len(set(counts)) == 1


@pytest.mark.parametrize(
    ("direction", "v", "expected"),
    [("rising", 1.0, [2 * math.pi]), ("falling", 1.0, [math.pi]), ("any", -1.0, [math.pi, 2 * math.pi])],
)
def test_a_start_on_a_surface_is_no_crossing(direction, v, expected):
    text = (
        "name: s\nstates: [x, v]\nmodes: {m: {x': v, v': -x}}\nevents: {e: x}\nresets: {n: {}}\n"
        f"segments: {{s: {{mode: m, event: e, direction: {direction}, reset: n, to: m}}}}\n"
    )
    assert trajectory_of(text, 7.0, initial=[0.0, v]).events.t == pytest.approx(expected, abs=1e-11)


@pytest.mark.parametrize(
    ("direction", "reset", "expected"), [("falling", "v: -r*v", 1), ("any", "v: -r*v", 1), ("falling", "v: v", 0)]
)
def test_a_motion_that_starts_into_a_wall_is_turned_round(direction, reset, expected):
    text = (
        "name: ball\nstates: [y, v]\nparameters: {r: 0.8}\nmodes: {m: {y': v, v': -1}}\nevents: {hit: y}\n"
        f"resets: {{bounce: {{{reset}}}}}\nsegments: {{s: {{mode: m, event: hit, direction: {direction}, reset: "
        f"bounce, to: m}}}}\n"
    )
    trajectory = simulate(numeric_from(text), np.array([0.8]), Direct(), 1.0, TIGHT, initial=[0.0, -1.0])
    assert len(trajectory.events) == expected
    assert trajectory(1.0)[0] == pytest.approx(0.8 - 0.5 if expected else -1.5, abs=1e-12)
