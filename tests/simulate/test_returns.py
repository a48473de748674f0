"""Where and when returns are counted."""

import numpy as np
import pytest

from pddecont.delay import Direct
from pddecont.simulate import Method, ReturnSection, ReturnSettings, Simulator, find_attractor
from tests.conftest import shipped

PERIOD = 2 * np.pi / 0.8


def find(section, forcing_period, phase=0.0, n_kept=20):
    numeric = shipped("impact_oscillator")
    simulator = Simulator(numeric, Direct(), Method(), section)
    values = simulator.values(numeric.parameter_values)
    settings = ReturnSettings(forcing_period, phase, 300 * PERIOD, 8, n_kept)
    return find_attractor(simulator, values, simulator.start(values), settings)


@pytest.mark.parametrize("phase", [0.0, 0.3])
def test_by_the_forcing_at_a_phase(phase):
    found = find(ReturnSection(), PERIOD, phase)
    assert found.times / PERIOD % 1 == pytest.approx(np.full(found.period, phase), abs=1e-9)
    assert found.turn == pytest.approx(found.period * PERIOD)


def test_at_an_event_of_the_model():
    numeric = shipped("impact_oscillator")
    event = next(iter(numeric.model.events))
    found = find(ReturnSection(event=event), 0.0)
    forced = find(ReturnSection(), PERIOD)
    # Every segment of the model ends at that event.
    assert found.period == sum(forced.segment_counts.values())
    assert found.turn == pytest.approx(forced.turn, rel=1e-6)


@pytest.mark.parametrize("direction", ["rising", "falling"])
def test_where_an_expression_crosses_zero(direction):
    numeric = shipped("impact_oscillator")
    v = numeric.model.state_symbols[1]
    found = find(ReturnSection(expr=v, direction=direction), 0.0)
    assert found.states[:, 1] == pytest.approx(np.zeros(found.period), abs=1e-9)
    assert np.all(np.sign(found.slopes[:, 1]) == (1 if direction == "rising" else -1))
