"""A model's record holds its modes, events and segments by number."""

import numpy as np

from pddecont.delay import Chain, Direct
from pddecont.simulate import ReturnSection, Simulator
from tests.conftest import numeric_from, shipped


def test_segments_by_number():
    system = Simulator(shipped("impact_oscillator"), Direct()).system
    model = shipped("impact_oscillator").model
    modes = list(model.modes)
    assert [modes[i] for i in system.segment_mode] == [s.mode for s in model.segments.values()]
    assert [modes[i] for i in system.segment_to] == [s.to for s in model.segments.values()]
    assert system.n_modes == len(modes)
    assert system.n == system.n_full == 2


def test_a_delayed_event_follows_another():
    numeric = numeric_from(
        "name: m\nstates: [x]\nparameters: {d: 0.5}\nmodes: {m: {x': 1}}\nevents: {a: x - 1, b: {after: a, delay: d}}\n"
        "segments: {s: {mode: m, event: a, direction: falling, to: m}, r: {mode: m, event: b, to: m}}\n"
    )
    simulator = Simulator(numeric, Direct(), section=ReturnSection(expr=numeric.model.state_symbols[0]))
    system, values = simulator.system, simulator.values(np.array([0.25]))
    assert list(system.after) == [-1, 0, -1]
    assert list(system.segment_direction) == [-1, 0]
    assert (system.section, system.stop_event) == (2, -1)
    assert list(values.event_delay) == [0.0, 0.25, 0.0]


def test_only_states_that_are_read_delayed_are_kept():
    system = Simulator(shipped("impact_oscillator"), Direct()).system
    assert [shipped("impact_oscillator").model.states[i] for i in system.kept] == ["v"]
    assert list(system.place) == [-1, 0]
    chain = Simulator(shipped("impact_oscillator"), Chain(2, 4)).system
    assert (chain.chain_order, chain.chain_n, chain.n_full) == (2, 4, 2 + 2 * 4)
