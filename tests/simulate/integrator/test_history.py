"""Delayed values are those of the past, on the right side of every jump."""

import math

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.delay import Chain, Direct
from pddecont.model.expression import TIME
from pddecont.native.integrator import USED
from pddecont.simulate import Events, Trajectory, simulate
from tests.conftest import numeric_from, shipped
from tests.simulate.motions import TIGHT, trajectory_of

finite = st.floats(-10, 10)
DELAYED = "name: m\nstates: [x, y]\nparameters: {tau: 1}\nmodes: {m: {x': 1, y': x(t - tau)}}\n"


@given(st.lists(finite, min_size=8, max_size=8), st.floats(0, 1))
def test_an_extension_is_that_of_a_trajectory(interpreted, numbers, s):
    value, coefficients = numbers[0], np.array(numbers[1:])
    none = np.empty((0, 1))
    events = Events(np.empty(0), (), none, none, np.empty(0, np.int64))
    one, zero = np.array([1.0]), np.array([0.0])
    trajectory = Trajectory(
        zero, one, one, np.array([0]), ("m",), np.array([[value]]), coefficients[None, :, None], events, 1
    )
    evaluated = interpreted.ring.evaluate_extension(value, coefficients, 1, s)
    assert evaluated == pytest.approx(trajectory(s)[0], rel=1e-14, abs=1e-14)
    # At the ends it is the first value, and that plus the first coefficient.
    assert interpreted.ring.evaluate_extension(value, coefficients, 1, 0.0) == value
    assert interpreted.ring.evaluate_extension(value, coefficients, 1, 1.0) == value + coefficients[0]


@given(st.lists(finite, min_size=7, max_size=7), st.floats(0.001, 0.999))
def test_its_slope_is_its_derivative(interpreted, numbers, s):
    coefficients, step = np.array(numbers, dtype=complex), 1e-30
    value = interpreted.ring.evaluate_extension(0.0, coefficients, 1, s + 1j * step)
    slope = interpreted.ring.evaluate_extension_slope(coefficients.real, 1, s)
    assert slope == pytest.approx(value.imag / step, rel=1e-12, abs=1e-12)


def remember(interpreted, run, steps):
    """Record steps (beginning, end, arc) over which the first state is t."""
    c = run.core
    for t, end, arc in steps:
        c.count[interpreted.places.ARC] = arc
        c.y[0], c.extension[:] = t, 0.0
        c.extension[0] = end - t
        interpreted.history.record_step(c, t, end - t, end)


def test_the_past_is_what_was_recorded(interpreted):
    run = interpreted.start(DELAYED, [0.0, 0.0], longest=100.0)
    remember(interpreted, run, [(0, 1, 0), (1, 1.5, 0), (1.5, 3, 0)])
    history, c, xd = interpreted.history, run.core, np.zeros(2)
    history.choose_arcs(c, 3.2)
    for t in (1.0, 1.3, 2.0, 2.4, 2.5, 3.9):
        history.read_delayed(c, t, c.y, xd, 0)
        assert xd[0] == pytest.approx(t - 1, abs=1e-15)
        history.read_delayed_slopes(c, t, c.y, c.slope, xd)
        assert xd[0] == pytest.approx(1.0)
    assert [history.find_step_before(c, t, guess) for t in (0.5, 1.0, 2.9, 9.0) for guess in (0, 2)] == [
        0,
        0,
        1,
        1,
        2,
        2,
        2,
        2,
    ]


def test_a_step_reads_one_arc_whatever_its_ends_are(interpreted):
    """Arcs 0 and 1 meet at t = 1.5: a step whose middle is before it reads arc 0 beyond its end."""
    run = interpreted.start(DELAYED, [0.0, 0.0], longest=100.0)
    remember(interpreted, run, [(0, 1.5, 0), (1.5, 3, 1)])
    c, history = run.core, interpreted.history
    assert history.choose_arcs(c, 2.4)
    assert [history.find_step_in_arc(c, t, 0) for t in (0.0, 1.4, 1.6, 9.0)] == [0] * 4
    assert history.choose_arcs(c, 2.6)
    assert [history.find_step_in_arc(c, t, 0) for t in (0.0, 1.4, 1.6, 9.0)] == [1] * 4
    assert not history.choose_arcs(c, 2.7)
    history.choose_arcs(c, 0.5)
    assert c.reading[0] == -1


@settings(max_examples=40, deadline=None)
@given(st.floats(0.1, 5.0), st.lists(st.floats(0.05, 1.0), min_size=1, max_size=40))
def test_the_past_reaches_as_far_as_the_longest_delay_and_no_farther(interpreted, longest, lengths):
    run = interpreted.start(DELAYED, [0.0, 0.0], p=np.array([0.1]), longest=longest)
    ends = np.cumsum(lengths)
    for t, end in zip([0, *ends], ends, strict=False):
        if not interpreted.history.past_has_capacity(run.core):
            return
        remember(interpreted, run, [(t, end, 0)])
    used, first = run.core.count[USED], run.core.count[interpreted.places.FIRST]
    kept = [run.core.past_end[k & run.core.mask] for k in range(first, first + used)]
    assert kept[-1] == ends[-1]
    # The step before the last stays, however old it is.
    assert used <= 2 or kept[0] >= ends[-1] - longest - 1e-12
    assert first == 0 or ends[first - 1] < ends[-1] - longest


def test_chains_keep_no_past(interpreted):
    run = interpreted.start(DELAYED, [0.0, 0.0], delay=Chain(2, 3))
    remember(interpreted, run, [(0, 1, 0)])
    assert run.core.count[USED] == 0


def test_a_history_that_differs_from_the_state_at_the_start():
    """x' = -x(t - 1), x = 1 before 0 and x(0) = 3: polynomials by the method of steps."""
    trajectory = trajectory_of(
        "name: h\nstates: [x]\nmodes: {m: {x': -x(t - 1)}}\n", 2.0, initial=[3.0], history=(sympy.Integer(1),)
    )
    t = np.array([0.0, 0.5, 1.0, 1.5, 2.0])
    assert trajectory(t)[:, 0] == pytest.approx(np.where(t <= 1, 3 - t, 2 - 3 * (t - 1) + (t - 1) ** 2 / 2), abs=1e-13)


def test_an_event_through_a_delayed_history():
    """x = t for t < 0: x(t - 1) = t - 1 passes -0.25 at 0.75, before the state itself has gone anywhere."""
    text = (
        "name: h\nstates: [x]\nmodes: {m: {x': 0}}\nevents: {e: x(t - 1) + 0.25}\nresets: {r: {x: 7}}\n"
        "segments: {s: {mode: m, event: e, direction: rising, reset: r, to: m}}\n"
    )
    events = trajectory_of(text, 3.0, history=(TIME,)).events
    assert events.t == pytest.approx([0.75], abs=1e-13)


def test_steps_that_begin_at_a_breaking_point_read_the_side_they_come_from():
    """Bolus: u1' = -1.5 u1, u2' = 1.5 u1(t - 10) - u2/30, u1 += 20 at t = 12, u(0) = (10, 0), no history: closed form
    by convolution.
    """
    numeric = numeric_from(
        "name: bolus\nstates: [u1, u2, clock]\nparameters: {tau: 10}\n"
        "modes: {m: {u1': -1.5*u1, u2': 1.5*u1(t - tau) - u2/30, clock': 1}}\nevents: {dose: clock - 12}\n"
        "resets: {add: {u1: u1 + 20}}\n"
        "segments: {s: {mode: m, event: dose, direction: rising, reset: add, to: m}}\n"
    )
    trajectory = simulate(numeric, numeric.parameter_values, Direct(), 24.0, TIGHT, initial=[10.0, 0.0, 0.0])
    a, b = 1.5, 1 / 30

    def part(dose, at):
        return dose * a / (a - b) * (math.exp(-b * (24 - at - 10)) - math.exp(-a * (24 - at - 10)))

    assert trajectory(24.0)[1] == pytest.approx(part(10, 0) + part(20, 12), abs=1e-10)
    assert trajectory(24.0)[1] == pytest.approx(24.5304093870, abs=1e-9)
    # No step is wasted at the breaking points at t = 10 and 22.
    assert trajectory.n_steps < 250


@pytest.mark.parametrize("tau", [1.0, 2.0, 0.5, 1 / 3, 7.0, 13.37])
def test_a_field_reads_jumps_a_delay_equal_to_or_unlike_their_spacing_later(tau):
    """x = floor(t), y' = x(t - tau)."""
    numeric = numeric_from(
        "name: r\nstates: [x, y, c]\nparameters: {tau: 1}\nmodes: {m: {x': 0, y': x(t - tau), c': 1}}\n"
        "events: {e: c - 1}\n"
        "resets: {up: {x: x + 1, c: 0}}\nsegments: {s: {mode: m, event: e, direction: rising, reset: up, "
        "to: m}}\n"
    )
    whole, part = divmod(50.5 - tau, 1.0)
    trajectory = simulate(numeric, np.array([tau]), Direct(), 50.5, TIGHT)
    assert trajectory(50.5)[1] == pytest.approx(whole * (whole - 1) / 2 + whole * part, abs=1e-10)
    assert trajectory.n_steps < 400


def test_a_reset_reads_the_value_before_a_jump_that_it_meets():
    """x' = 1, x -> 10 x(t - 1) at whole numbers: the event belongs to the arc that ends, and so does what it reads."""
    events = trajectory_of(
        "name: r\nstates: [x, c]\nmodes: {m: {x': 1, c': 1}}\nevents: {e: c - 1}\nresets: {b: {x: 10*x(t - 1), c: 0}}\n"
        "segments: {s: {mode: m, event: e, direction: rising, reset: b, to: m}}\n",
        4.5,
    ).events
    assert events.before[:, 0] == pytest.approx([1, 1, 11, 11], abs=1e-12)
    assert events.after[:, 0] == pytest.approx([0, 10, 10, 110], abs=1e-11)


def test_a_bolus_is_seen_a_delay_later():
    trajectory = trajectory_of(shipped("bolus"), 24.0, initial=[10.0, 0.0, 0.0])
    assert trajectory.events.t[0] == pytest.approx(12.0, abs=1e-13)
    assert trajectory(24.0)[1] == pytest.approx(24.5304093870, abs=1e-10)
