"""The side of a surface on which a motion is: from the search, or from the value where a step is cut."""

import numpy as np
import pytest

from pddecont.delay import Direct
from pddecont.simulate import Method, Simulator
from tests.conftest import numeric_from
from tests.simulate.motions import COUNTER, trajectory_of


@pytest.fixture
def run(interpreted):
    run = interpreted.start(COUNTER.replace("H}", "c - 1}").replace("DIR", "any"), [0.0, 0.0])
    run.sides = interpreted.event_sides
    return run


@pytest.mark.parametrize(("c", "side"), [(0.5, -1), (1.5, 1), (1.0, 0), (1.0 + 1e-15, 0), (1.0 + 1e-9, 1)])
def test_an_arc_begins_on_a_side_or_on_the_surface(run, c, side):
    run.core.y[0] = c
    run.core.side[0] = 7
    run.sides.note_sides(run.core, 0.0)
    assert run.core.side[0] == side
    assert run.core.count[8] == 0  # the arc is not fresh any more


def test_a_whole_step_keeps_what_the_search_found(run):
    run.core.y[0], run.core.found_side[0] = 0.5, 1
    run.sides.update_side(run.core, 0, 0, 0.0, True)
    assert run.core.side[0] == 1


@pytest.mark.parametrize(("c", "side"), [(0.5, -1), (1.5, 1), (1.0, -1)])
def test_a_cut_step_keeps_the_sign_there_and_none_where_it_is_zero(run, c, side):
    run.core.y[0], run.core.found_side[0], run.core.side[0] = c, 7, -1
    run.sides.update_side(run.core, 0, 0, 0.0, False)
    assert run.core.side[0] == side


# A converter whose comparator switches while the ramp goes up and down (Hamill, Deane 1990).
CONVERTER = """
name: buck
states: [v, i, r]
parameters: {E: 22, R: 22, C: 47.0e-6, L: 0.02, T: 4.0e-4, gamma: 11.75238, rise: 0.5238096, Tf: 4.0e-7}
modes:
  idle_up:   {v': (i - v/R)/C, i': -v/L,      r': 1/(T - Tf)}
  feed_up:   {v': (i - v/R)/C, i': (E - v)/L, r': 1/(T - Tf)}
  idle_down: {v': (i - v/R)/C, i': -v/L,      r': -1/Tf}
  feed_down: {v': (i - v/R)/C, i': (E - v)/L, r': -1/Tf}
events: {compare: v - gamma - rise*r, top: r - 1, bottom: r}
segments:
  on_up:     {mode: idle_up,   event: compare, direction: falling, to: feed_up}
  cut_up:    {mode: feed_up,   event: compare, direction: rising,  to: idle_up}
  on_down:   {mode: idle_down, event: compare, direction: falling, to: feed_down}
  cut_down:  {mode: feed_down, event: compare, direction: rising,  to: idle_down}
  top_idle:  {mode: idle_up,   event: top, direction: rising, to: idle_down}
  top_feed:  {mode: feed_up,   event: top, direction: rising, to: feed_down}
  low_idle:  {mode: idle_down, event: bottom, direction: falling, to: idle_up}
  low_feed:  {mode: feed_down, event: bottom, direction: falling, to: feed_up}
initial: {mode: idle_up, v: 12, i: 0.5, r: 0}
"""


@pytest.mark.parametrize("E", [30.0, 33.0, 34.0, 36.0])
def test_a_converter_is_on_the_side_of_its_ramp_that_its_mode_says(E):
    trajectory = trajectory_of(CONVERTER, 400 * 4e-4, Method(1e-8, 1e-10), E=E)
    for t, end, arc, mode in zip(trajectory.time, trajectory.end, trajectory.arc, trajectory.mode, strict=True):
        v, _, r = trajectory.evaluate_arc(int(arc), np.array([0.5 * (t + end)]))[0]
        above = v - 11.75238 - 0.5238096 * r
        assert (above > 0) == mode.startswith("idle") or abs(above) < 1e-9, (t / 4e-4, mode, above)
    gaps = np.diff(trajectory.events.t)
    assert not any(
        gap == 0 and {a, b} == {"on_up", "cut_up"}
        for gap, a, b in zip(gaps, trajectory.events.segment, trajectory.events.segment[1:], strict=False)
    )


@pytest.mark.parametrize("height", [1e-4, 1e-6, 1e-9])
def test_a_motion_that_leaves_a_surface_by_little_comes_back_to_it_once(height):
    """From the surface x = 1000 the arc rises by v^2/2 and is back after 2 v."""
    v = (2 * height) ** 0.5
    text = (
        "name: hop\nstates: [x, v, n]\nparameters: {w: 1}\n"
        "modes: {up: {x': 1, v': 0, n': 0}, hop: {x': v, v': -1, n': 0}, end: {x': 0, v': 0, n': 0}}\n"
        "events: {e: x - 1000}\nresets: {leave: {v: w}, land: {n: n + 1}}\nsegments:\n"
        "  a: {mode: up, event: e, direction: rising, reset: leave, to: hop}\n"
        "  b: {mode: hop, event: e, direction: falling, reset: land, to: end}\ninitial: {mode: up, x: 999.3}\n"
    )
    trajectory = trajectory_of(text, 2.0, w=v)
    assert trajectory.events.segment == ("a", "b")
    # x is known to the rounding of 1000, and it passes the surface at the speed v.
    assert np.diff(trajectory.events.t) == pytest.approx([2 * v], abs=1e-12 / v)


def test_two_functions_that_a_delayed_value_carries_over_zero_at_once_both_cross():
    """x jumps from 0 to 1 at t = 1 and its delayed value passes 0.3 and 0.6 at t = 1.5."""
    text = (
        "name: j\nstates: [x, a, b, c]\nparameters: {tau: 0.5}\nmodes: {m: {x': 0, a': 0, b': 0, c': 1}}\n"
        "events: {now: c - 1, low: x(t - tau) - 0.3, high: x(t - tau) - 0.6}\n"
        "resets: {step: {x: 1}, count_a: {a: a + 1}, count_b: {b: b + 1}}\nsegments:\n"
        "  now: {mode: m, event: now, direction: rising, reset: step, to: m}\n"
        "  low: {mode: m, event: low, direction: rising, reset: count_a, to: m}\n"
        "  high: {mode: m, event: high, direction: rising, reset: count_b, to: m}\n"
    )
    trajectory = trajectory_of(text, 3.0)
    assert trajectory.events.segment == ("now", "low", "high")
    assert trajectory(3.0) == pytest.approx([1, 1, 1, 3])


@pytest.mark.parametrize(("first", "second"), [("clock", "cross"), ("cross", "clock")])
def test_a_function_that_is_turned_back_where_it_is_zero_has_not_crossed(first, second):
    """x rises to 1 at t = 1, where the clock lets it fall: it touches, and whether it counts the order says.

    Where the crossing comes first, x is above in mode ``above``, falls back there and has crossed twice.
    """
    clock = {"below": "falls", "above": "falls_above"}
    lines = []
    for event in (first, second):
        for mode, to in clock.items() if event == "clock" else ():
            lines.append(f"  clock_{mode}: {{mode: {mode}, event: clock, direction: rising, to: {to}}}")
        if event == "cross":
            lines.append("  cross: {mode: below, event: cross, direction: rising, to: above}")
            lines.append("  late: {mode: falls, event: cross, direction: rising, to: falls_above}")
            lines.append("  back: {mode: falls_above, event: cross, direction: falling, to: falls}")
    text = (
        "name: t\nstates: [x, c]\nmodes:\n  below: {x': 1, c': 1}\n  above: {x': 1, c': 1}\n"
        "  falls: {x': -1, c': 1}\n  falls_above: {x': -1, c': 1}\nevents: {clock: c - 1, cross: x - 1}\nsegments:\n"
        + "\n".join(lines)
        + "\ninitial: {mode: below}\n"
    )
    trajectory = trajectory_of(text, 3.0)
    expected = ("clock_below",) if first == "clock" else ("cross", "clock_above", "back")
    assert trajectory.events.segment == expected
    assert trajectory.mode[-1] == "falls"
    assert trajectory.events.t == pytest.approx(np.ones(len(expected)), abs=1e-13)


@pytest.mark.parametrize("phase", [0.0, 0.25])
def test_no_event_is_lost_where_steps_begin_and_end_on_zeros(phase):
    """No step is longer than half a forcing period: at phase 0 steps begin and end at zeros of sin(2 pi t)."""
    text = (
        "name: t\nstates: [n]\nparameters: {w: 1}\nforcing: {period: w}\nmodes: {m: {n': 0}}\n"
        f"events: {{tick: sin(2*pi*(t - {phase}))}}\nresets: {{add: {{n: n + 1}}}}\n"
        "segments: {s: {mode: m, event: tick, direction: rising, reset: add, to: m}}\n"
    )
    numeric = numeric_from(text)
    simulator = Simulator(numeric, Direct(), Method())
    values = simulator.values(numeric.parameter_values)
    state = simulator.start(values)
    for k in range(1, 1001):
        state, _ = simulator.advance(values, state, 0.5 * k)
    assert state.y[0] in (499, 500) if phase == 0.0 else state.y[0] == 500
    assert state.segment_counts[0] == state.y[0]
