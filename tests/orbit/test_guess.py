"""From the last cycle of a simulation to unknowns."""

from dataclasses import replace

import numpy as np
import pytest

from pddecont.collocation import MeshRule
from pddecont.delay import Direct
from pddecont.errors import SignatureError
from pddecont.orbit import guess_from_cycle
from pddecont.simulate import detect_period, simulate
from tests.conftest import shipped

RULE = MeshRule(6, intervals=12)


def cycle_of(name, t_end):
    numeric = shipped(name)
    p = numeric.parameter_values
    trajectory = simulate(numeric, p, Direct(), t_end)
    return numeric, p, trajectory, detect_period(numeric, p, trajectory)


@pytest.fixture(scope="module")
def impacts():
    return cycle_of("impact_oscillator", 400)


def test_the_guess_is_the_motion_itself(impacts):
    numeric, p, trajectory, cycle = impacts
    guess = guess_from_cycle(numeric, p, Direct(), cycle, RULE)
    assert guess.signature.names == list(cycle.signature)
    assert sorted(guess.signature.names) == ["C", "NC"]
    assert guess.durations == pytest.approx(np.diff(cycle.times))
    assert guess.problem.n_periods == cycle.n_periods
    # A forced motion starts where the simulation's segment did, less whole periods of the forcing.
    period = 2 * np.pi / 0.8
    assert 0 <= guess.start < period
    turns = (cycle.times[0] - guess.start) / period
    assert turns == pytest.approx(round(turns), abs=1e-9)
    # Away from the segments' ends, where the trajectory has one value.
    mesh, theta = guess.mesh, guess.theta
    times = cycle.times[0] + mesh.base_times(theta)
    inside = np.setdiff1d(np.arange(mesh.n_base), [*mesh.first_base, *mesh.last_base])
    exact = np.array([trajectory(t) for t in times[inside]])
    assert guess.values[inside] == pytest.approx(exact, abs=1e-9)
    # And at the ends the position is that of the wall.
    assert guess.values[mesh.last_base, 0] == pytest.approx([1.26, 1.26], abs=1e-7)


def test_an_autonomous_motion_is_the_reference_of_its_own_phase():
    numeric, p, _, cycle = cycle_of("van_der_pol", 60)
    guess = guess_from_cycle(numeric, p, Direct(), cycle, RULE)
    assert guess.signature.names == ["(swing)"] or not guess.signature.has_events
    assert guess.start == 0.0
    assert np.array_equal(guess.problem.reference, guess.values)


def test_delayed_events_are_linked():
    numeric, p, _, cycle = cycle_of("spiking_neuron", 60)
    guess = guess_from_cycle(numeric, p, Direct(), cycle, RULE)
    (link,) = guess.problem.links
    assert guess.signature.names[link.segment] == "pulse"
    assert guess.signature.names[link.source] == "spike"


def test_segments_that_do_not_follow_one_another_are_refused(impacts):
    numeric, p, _, cycle = impacts
    torn = replace(cycle, signature=(cycle.signature[0],) * len(cycle.signature))
    with pytest.raises(SignatureError):
        guess_from_cycle(numeric, p, Direct(), torn, RULE)
