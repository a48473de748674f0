"""The state of an integration survives a row of numbers; times may be shifted; nothing else is accepted."""

import functools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.delay import Chain, Direct
from pddecont.native.integrator import FIRST, LAST_EVENT, MODE, N_PENDING, USED, T
from pddecont.simulate import Simulator, find_restart_time, pack, record_trajectory, shift_time, unpack
from tests.conftest import numeric_from, shipped

DELAYS = {"direct": Direct(), "chain": Chain(2, 3)}
# A delayed event is under way for 0.9 of each period of 1; the past reaches 2.5 back.
PULSED = (
    "name: p\nstates: [x, c, n]\nparameters: {tau: 2.5, d: 0.9}\nmodes: {m: {x': -x(t - tau)/3, c': 1, n': 0}}\n"
    "events: {e: c - 1, late: {after: e, delay: d}}\nresets: {r: {x: x + 1, c: 0}, add: {n: n + 1}}\n"
    "segments: {s: {mode: m, event: e, direction: rising, reset: r, to: m}, "
    "l: {mode: m, event: late, reset: add, to: m}}\n"
)


@functools.cache
def simulator_of(delay):
    return Simulator(numeric_from(PULSED), DELAYS[delay])


def state_at(simulator, t):
    values = simulator.values(simulator.numeric.parameter_values)
    state, _ = simulator.advance(values, simulator.start(values), t)
    return values, state


@settings(max_examples=20, deadline=None)
@given(st.sampled_from(sorted(DELAYS)), st.floats(0.01, 30.0))
def test_an_integration_goes_on_from_its_row_as_from_itself(delay, t):
    simulator = simulator_of(delay)
    values, state = state_at(simulator, t)
    row = pack(state)
    again = unpack(simulator.system, values, row)
    assert np.array_equal(pack(again)[:5], row[:5])
    p = simulator.numeric.parameter_values
    one, other = (record_trajectory(simulator, p, s, t + 8.0) for s in (state, again))
    for name in ("time", "length", "end", "value", "coefficients"):
        assert np.array_equal(getattr(one, name), getattr(other, name)), name
    assert np.array_equal(one.events.t, other.events.t)


@settings(max_examples=20, deadline=None)
@given(st.floats(0.01, 12.0), st.floats(-50.0, 50.0))
def test_a_shift_of_time_shifts_all_that_follows(t, to):
    simulator = simulator_of("direct")
    values, state = state_at(simulator, t)
    p = simulator.numeric.parameter_values
    shifted = shift_time(unpack(simulator.system, values, pack(state)), to)
    assert shifted.clock[T] == pytest.approx(to, abs=1e-12)
    one, other = record_trajectory(simulator, p, state, t + 6.0), record_trajectory(simulator, p, shifted, to + 6.0)
    assert other.events.segment == one.events.segment
    assert other.events.t - to == pytest.approx(one.events.t - t, abs=1e-9)
    assert other(to + 6.0)[0] == pytest.approx(one(t + 6.0)[0], abs=1e-8)


@given(st.floats(0.0, 1e4), st.floats(0.5, 3.0), st.floats(0.5, 3.0))
def test_a_restart_keeps_the_phase_of_the_forcing(t, before, after):
    numeric = numeric_from("name: m\nstates: [x]\nparameters: {p: 1}\nforcing: {period: p}\nmodes: {m: {x': 0}}\n")
    found = find_restart_time(numeric, np.array([before]), np.array([after]), t)
    assert 0.0 <= found < after
    difference = (found / after - t / before) % 1.0
    assert min(difference, 1 - difference) < 1e-11


def test_an_autonomous_model_restarts_at_zero():
    assert find_restart_time(shipped("wright"), np.array([1.0, 1.0]), np.array([2.0, 1.0]), 77.3) == 0.0


def test_a_larger_past_finds_its_place():
    simulator = simulator_of("direct")
    values, state = state_at(simulator, 9.7)
    assert state.count[USED] > 3
    assert state.count[N_PENDING] == 1
    again = unpack(simulator.system, values, pack(state))
    first, used = state.count[FIRST], state.count[USED]
    for number in range(first, first + used):
        i, j = number % len(state.past_time), number % len(again.past_time)
        assert state.past_time[i] == again.past_time[j]
        assert np.array_equal(state.past_coefficients[i], again.past_coefficients[j])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda row: row[:20], "is too short"),
        (lambda row: np.append(row, 1.0), "is not one of this model"),
        (lambda row: put(row, 5 + MODE, 7.0), "is not one of this model"),
        (lambda row: put(row, 5 + MODE, -1.0), "is not one of this model"),
        (lambda row: put(row, 5 + USED, 1e9), "is not one of this model"),
        (lambda row: put(row, 5 + FIRST, -1.0), "is not one of this model"),
        (lambda row: put(row, 5 + LAST_EVENT, 9.0), "is not one of this model"),
        (lambda row: put(row, 5 + USED, np.nan), "is not one of this model"),
        (lambda row: put(row, 5 + USED, np.inf), "is not one of this model"),
    ],
)
def test_a_row_that_is_no_state_is_refused(change, message):
    simulator = simulator_of("direct")
    values, state = state_at(simulator, 9.7)
    with pytest.raises(ValueError, match=message):
        unpack(simulator.system, values, change(pack(state)))


def put(row, place, number):
    row = row.copy()
    row[place] = number
    return row


def test_a_tangent_is_not_kept():
    numeric = numeric_from(PULSED)
    simulator = simulator_of("direct")
    values, state = state_at(simulator, 5.0)
    with_tangent = Simulator(numeric, Direct(), tangent=True)
    again = unpack(with_tangent.system, values, pack(state))
    n = numeric.n_states
    assert np.array_equal(again.y[:n], state.y)
    assert np.all(again.y[n:] == 0.0)
