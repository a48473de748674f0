"""Steps end where jumps come back through delays and where delayed events happen; no pulse is lost."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.delay import Chain, Direct
from pddecont.native.integrator import LEVELS, N_BREAKING, N_PENDING
from pddecont.simulate import Simulator, simulate
from tests.conftest import numeric_from
from tests.simulate.motions import TIGHT, trajectory_of

TWO_DELAYS = "name: m\nstates: [x]\nmodes: {m: {x': -x(t - 1) - x(t - 2.5)}}\n"


def test_a_jump_comes_back_after_every_sum_of_delays_up_to_the_order_of_the_method(interpreted):
    run = interpreted.start(TWO_DELAYS, [1.0])
    breaking, c, stops = interpreted.breaking, run.core, []
    while c.count[N_BREAKING] and len(stops) < 100:
        stops.append(breaking.find_next_stop(c, np.inf))
        breaking.pass_breaking_points(c, stops[-1])
    sums = {i + 2.5 * j for i in range(LEVELS + 1) for j in range(LEVELS + 1) if 0 < i + j <= LEVELS}
    assert stops == pytest.approx(sorted(sums))


@settings(max_examples=40, deadline=None)
@given(times=st.lists(st.floats(0, 100), max_size=8), seed=st.integers(0, 9))
def test_breaking_points_are_in_order_and_none_is_there_twice(interpreted, times, seed):
    run, rng = interpreted.start(TWO_DELAYS, [1.0]), np.random.default_rng(seed)
    c, breaking, tolerance = run.core, interpreted.breaking, interpreted.ring.time_tolerance
    for t in times:
        breaking.add_breaking_points(c, t + rng.choice([0.0, 1e-15]), int(rng.integers(0, LEVELS)))
    kept = c.breaking_time[: c.count[N_BREAKING]]
    assert all(b - a > tolerance(a) for a, b in itertools.pairwise(kept))
    for t in [0.0, *times]:
        for tau in (1.0, 2.5):
            assert np.min(np.abs(kept - (t + tau))) <= tolerance(t + tau)


def test_the_lower_level_of_two_that_meet_stays(interpreted):
    run = interpreted.start(TWO_DELAYS, [1.0])
    for level in (5, 2, 4):
        interpreted.breaking.add_breaking_points(run.core, 10.0, level)
    place = list(run.core.breaking_time[: run.core.count[N_BREAKING]]).index(11.0)
    assert run.core.breaking_level[place] == 3


@settings(max_examples=40, deadline=None)
@given(times=st.lists(st.floats(0, 50), min_size=1, max_size=12), data=st.data())
def test_delayed_events_under_way_are_in_order_and_removed_one_by_one(interpreted, times, data):
    run = interpreted.start(TWO_DELAYS, [1.0])
    c, breaking = run.core, interpreted.breaking
    for k, t in enumerate(times):
        breaking.add_pending(c, t, k, -t)
    order = sorted(range(len(times)), key=lambda k: times[k])
    while c.count[N_PENDING]:
        n = c.count[N_PENDING]
        assert list(c.pending_event[:n]) == order
        assert list(c.pending_time[:n]) == [times[k] for k in order] == [-x for x in c.pending_shift[:n]]
        place = data.draw(st.integers(0, n - 1))
        breaking.remove_pending(c, place)
        del order[place]


def test_a_chain_has_no_breaking_points(interpreted):
    assert interpreted.start(TWO_DELAYS, [1.0], delay=Chain(2, 3)).core.count[N_BREAKING] == 0


def test_queues_are_full_before_they_overflow(interpreted):
    run = interpreted.start(TWO_DELAYS, [1.0])
    c, breaking, added = run.core, interpreted.breaking, 0
    while breaking.queues_have_capacity(c, 1):
        breaking.add_breaking_points(c, 100.0 + 10 * added, 0)
        added += 1
    assert added > 5
    assert c.count[N_BREAKING] < len(c.breaking_time)


def test_every_step_ends_at_the_next_breaking_point_at_the_latest():
    trajectory = trajectory_of(TWO_DELAYS, 12.0, initial=[1.0])
    sums = [i + 2.5 * j for i in range(8) for j in range(8) if 0 < i + j <= LEVELS and i + 2.5 * j < 12]
    for stop in sums:
        assert np.min(np.abs(trajectory.end - stop)) < 1e-13


# No pulse is lost.
LAGS = "x': -0.1*x(t - 0.2) - 0.2*x(t - 4)"


FORCED = (
    "name: p\nstates: [x, n]\nparameters: {p: PERIOD}\nforcing: {period: p}\nmodes: {m: {"
    + LAGS
    + ", n': 0}}\nevents: {e: H}\n"
    "resets: {add: {x: x + 1, n: n + 1}}\nsegments: {s: {mode: m, event: e, direction: DIR, reset: add, to: "
    "m}}\ninitial: {x: 1}\n"
)


CLOCK = (
    "name: p\nstates: [x, n, c]\nmodes: {m: {"
    + LAGS
    + ", n': 0, c': 1}}\nevents: {e: c - 1}\nresets: {add: {x: x + 1, "
    "n: n + 1, c: 0}}\n"
    "segments: {s: {mode: m, event: e, direction: rising, reset: add, to: m}}\ninitial: {x: 1}\n"
)


def forced(h, direction, period):
    return FORCED.replace("H}", h + "}").replace("DIR", direction).replace("PERIOD", str(period))


@pytest.mark.parametrize(
    "text", [forced("sin(2*pi*t)", "rising", 1), forced("sin(pi*t)", "any", 2), CLOCK], ids=["once", "twice", "clock"]
)
def test_no_pulse_is_lost_between_short_and_long_lags(text):
    trajectory = trajectory_of(text, 1000.5)
    assert trajectory.events.t == pytest.approx(np.arange(1, 1001), abs=1e-11)
    assert trajectory(1000.5)[1] == 1000.0
    assert trajectory(999.9)[0] == pytest.approx(trajectory_of(CLOCK, 1000.5)(999.9)[0], abs=1e-10)


@pytest.mark.parametrize(("delay", "expected"), [(100.5, 199), (100, 200), (1000.5, 0)])
def test_many_delayed_events_under_way(delay, expected):
    numeric = numeric_from(
        "name: k\nstates: [c, n]\nparameters: {tau: 1}\nmodes: {m: {c': 1, n': 0}}\n"
        "events: {tick: c - 1, kick: {after: tick, delay: tau}}\nresets: {zero: {c: 0}, add: {n: n + 1}}\nsegments:\n"
        "  tick: {mode: m, event: tick, direction: rising, reset: zero, to: m}\n"
        "  kick: {mode: m, event: kick, reset: add, to: m}\n"
    )
    p = np.array([float(delay)])
    assert simulate(numeric, p, Direct(), 300.25, TIGHT)(300.25)[1] == expected
    simulator = Simulator(numeric, Direct(), TIGHT)
    values = simulator.values(p)
    state, _ = simulator.advance(values, simulator.start(values), 300.25)
    assert state.count[N_PENDING] == 300 - expected


def test_a_delayed_event_comes_after_its_delay():
    numeric = numeric_from(
        "name: m\nstates: [x, y]\nparameters: {tau: 2.5}\nmodes: {m: {x': 1, y': 0}}\n"
        "events: {tick: x - 1, kick: {after: tick, delay: tau}}\nresets: {zero: {x: 0}, add: {y: y + 1}}\n"
        "segments:\n  tick: {mode: m, event: tick, direction: rising, reset: zero, to: m}\n"
        "  kick: {mode: m, event: kick, reset: add, to: m}\n"
    )
    trajectory = simulate(numeric, numeric.parameter_values, Chain(2, 15), 6.2)
    kicks = trajectory.events.t[np.array(trajectory.events.segment) == "kick"]
    assert kicks == pytest.approx([3.5, 4.5, 5.5], abs=1e-12)
    assert trajectory(6.2)[1] == 3.0
