"""Logs, buffers of returns and workspaces have the shapes that they say."""

import numpy as np

from pddecont.delay import Chain
from pddecont.native.integrator import N_COEFFICIENTS
from pddecont.simulate import Simulator
from pddecont.simulate.integrator import make_log, make_return_buffer, make_workspace
from tests.conftest import shipped


def test_a_log_has_room_for_steps_and_events():
    log = make_log(3, 7, 5)
    assert log.value.shape == (7, 3)
    assert log.coefficients.shape == (7, N_COEFFICIENTS, 3)
    assert log.before.shape == log.after.shape == (5, 3)
    assert list(log.n) == [0, 0]


def test_a_log_of_no_length_records_nothing():
    numeric = shipped("impact_oscillator")
    simulator = Simulator(numeric, Chain(2, 3))
    values = simulator.values(numeric.parameter_values)
    log = make_log(numeric.n_states, 0, 0)
    state, _ = simulator.advance(values, simulator.start(values), 50.0, log)
    assert state.segment_counts.sum() > 2
    assert list(log.n) == [0, 0]


def test_a_full_log_is_emptied_in_between():
    numeric = shipped("impact_oscillator")
    simulator = Simulator(numeric, Chain(2, 3))
    values = simulator.values(numeric.parameter_values)
    log, times = make_log(numeric.n_states, 20, 100), []

    def empty(full):
        times.extend(full.time[: full.n[0]])
        full.n[:] = 0

    simulator.advance(values, simulator.start(values), 50.0, log, on_log_full=empty)
    empty(log)
    assert len(times) > 100
    assert np.all(np.diff(times) > 0)


def test_a_return_buffer_is_under_way_to_nothing():
    numeric = shipped("impact_oscillator")
    buffer = make_return_buffer(Simulator(numeric, Chain(2, 3)).system, 9, 4)
    assert buffer.states.shape == (9, 2 * numeric.n_states)
    assert buffer.distances.shape == (9, 5)
    assert np.isnan(buffer.stop[0])


def test_a_workspace_holds_the_chain_and_its_tangent():
    system = Simulator(shipped("impact_oscillator"), Chain(2, 3), tangent=True).system
    work = make_workspace(system)
    assert system.n_full == 2 + 2 * 3
    assert work.stages.size == 16 * 2 * system.n_full
