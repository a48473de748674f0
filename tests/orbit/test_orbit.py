"""An orbit as a value: its parts, what it reads anywhere, and what is kept with it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.collocation import MeshRule
from pddecont.orbit import Orbit
from tests.known_orbits import impact_oscillator, mackey_glass
from tests.orbit.exact import TURN, circle


def test_parts():
    orbit = circle("s", "s", level=0.5, free=("tau",))
    assert orbit.durations == pytest.approx([TURN, TURN])
    assert orbit.period == pytest.approx(2 * TURN)
    assert orbit.event_times == pytest.approx([0, TURN, 2 * TURN])
    assert orbit.start == pytest.approx(np.pi / 6)
    assert orbit.free.tolist() == [1.0]
    assert orbit.theta == pytest.approx([TURN, TURN, 1.0])
    assert orbit.values.shape == (orbit.mesh.n_base, 2)
    # Unknowns count before the problem's own values.
    other = Orbit(orbit.problem, orbit.x + np.eye(len(orbit.x))[-1])
    assert other.parameters.tolist() == [0.5, 2.0, 1.0]
    assert other.theta[-1] == 2.0
    assert orbit.problem.parameters.tolist() == [0.5, 1.0, 1.0]


@settings(max_examples=25, deadline=None, derandomize=True)
@given(sigma=st.lists(st.floats(0.0, 1.0), min_size=1, max_size=4), tau=st.floats(0.0, 30.0))
def test_reads_anywhere(sigma, tau):
    """States, delayed states and times of the circle, at any fraction of every interval."""
    orbit = circle("s", level=0.5, tau=tau, rule=MeshRule(10, intervals=40))
    points = orbit.mesh.grid(np.array(sigma))
    reads = orbit.read(points)
    assert np.allclose(reads.t, orbit.start + orbit.mesh.times(points) @ orbit.theta)
    assert np.allclose(reads.x, [np.cos(reads.t), np.sin(reads.t)], atol=1e-7)
    exact = {0: np.cos(reads.t - tau), 1: np.sin(reads.t - tau)}
    delayed = orbit.numeric.model.delayed
    assert np.allclose(reads.xd, [exact[read.state] for read in delayed], atol=1e-7)
    without = orbit.read(points, delays=False)
    assert not np.any(without.xd)
    assert without.operators == []
    assert np.array_equal(without.x, reads.x)


def test_other_free_parameters_are_the_same_orbit():
    orbit = impact_oscillator()
    other = orbit.with_free(("K", "tau_d"))
    assert other.problem.free == ("K", "tau_d")
    assert len(other.x) == len(orbit.x) + 2
    assert np.array_equal(other.values, orbit.values)
    assert other.theta == pytest.approx(orbit.theta)
    moved = Orbit(other.problem, other.x + 0.25 * np.eye(len(other.x))[-1])
    assert moved.with_free(()).theta[-1] == pytest.approx(4.05)
    assert moved.with_free(()).parameters == pytest.approx(moved.parameters)


def test_the_reference_of_its_phase():
    orbit = mackey_glass()
    moved = Orbit(orbit.problem, orbit.x * 1.01)
    assert np.array_equal(moved.with_phase_reference().problem.reference, moved.values)
    forced = impact_oscillator()
    assert forced.with_phase_reference() is forced


def test_what_is_worked_out_is_kept_with_the_orbit():
    orbit, calls = circle(), []

    def find():
        calls.append(1)
        return object()

    assert orbit.once("key", find) is orbit.once("key", find)
    assert len(calls) == 1
    Orbit(orbit.problem, orbit.x).once("key", find)
    assert len(calls) == 2
    assert orbit.equation_reads is orbit.equation_reads
