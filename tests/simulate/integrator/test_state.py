"""The state of an integration grows without losing what it holds, and stays as small as it can."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.delay import Direct
from pddecont.native.integrator import FIRST, USED, Status
from pddecont.simulate import Method, Simulator, simulate
from pddecont.simulate.integrator import enlarge, make_log, make_state, run
from tests.conftest import numeric_from

PULSES = (
    "name: p\nstates: [x, c]\nmodes: {m: {x': -x(t - 50)/50, c': 1}}\nevents: {e: c - 100}\n"
    "resets: {r: {x: x + 1, c: 0}}\n"
    "segments: {s: {mode: m, event: e, direction: rising, reset: r, to: m}}\n"
)


def new_state():
    numeric = numeric_from(PULSES)
    simulator = Simulator(numeric, Direct())
    return make_state(simulator.system, simulator.values(numeric.parameter_values))


def test_a_new_state_holds_nothing_and_reads_the_history():
    state = new_state()
    assert state.count[USED] == 0
    assert len(state.past_time) & (len(state.past_time) - 1) == 0
    assert np.all(state.reading == -1)
    assert np.all(np.isneginf(state.accumulation[:, 0]))


@settings(max_examples=25, deadline=None)
@given(first=st.integers(0, 10**9), used=st.integers(0, 32), seed=st.integers(0, 99))
def test_a_larger_state_keeps_every_step_at_its_number(interpreted, first, used, seed):
    state, rng = interpreted.prepare(PULSES).state, np.random.default_rng(seed)
    old = len(state.past_time)
    state.count[FIRST], state.count[USED] = first, used
    rings = ("past_time", "past_length", "past_end", "past_arc", "past_shift", "past_value", "past_coefficients")
    for name in rings:
        ring = getattr(state, name)
        ring[...] = rng.integers(0, 100, ring.shape)
    state.pending_time[:], state.breaking_level[:] = np.arange(old), np.arange(old)
    larger = enlarge(state)
    assert len(larger.past_time) == 2 * old
    for number in range(first, first + used):
        for name in rings:
            assert np.array_equal(getattr(larger, name)[number % (2 * old)], getattr(state, name)[number % old]), name
    assert np.array_equal(larger.pending_time[:old], np.arange(old))
    assert np.array_equal(larger.breaking_level[:old], np.arange(old))
    assert larger.y is state.y
    assert larger.count is state.count


def test_memory_stays_flat_over_a_million_time_units():
    numeric = numeric_from(PULSES)
    simulator = Simulator(numeric, Direct(), Method())
    values = simulator.values(numeric.parameter_values)
    state, log = simulator.start(values), make_log(2, 0, 0)
    sizes = []
    for t in (1e4, 1e6):
        while (status := run(simulator.system, values, state, log, simulator.work, t, 1 << 40)) == Status.CAPACITY:
            state = enlarge(state)
        assert status == Status.REACHED
        sizes.append(sum(a.nbytes for a in state))
    assert sizes[1] == sizes[0] < 100_000
    assert state.segment_counts[0] in (9999, 10000)
    late = simulate(numeric, numeric.parameter_values, Direct(), 1e5, keep_from=1e5 - 250)
    assert len(late.events) in (2, 3)
    assert late.t0 > 1e5 - 350
