"""One orbit in all the ways in which it can be written."""

import numpy as np
import pytest

from pddecont.orbit import Orbit, PeriodicOrbitSystem, list_images, measure_orbit
from tests.bifurcation.runs import FREE, NORMAL_FORM
from tests.orbits import settle_to_orbit


def unknowns_of(orbit):
    """Return an orbit's unknowns that no mesh changes."""
    return orbit.x[PeriodicOrbitSystem(orbit.problem, measure_orbit(orbit)).mesh_independent_index]


def test_an_orbit_is_among_its_own_images():
    for orbit in (
        settle_to_orbit(NORMAL_FORM),
        settle_to_orbit(FREE, t_end=300),
        settle_to_orbit("bouncing_ball", t_end="200*2*pi"),
    ):
        (image,) = list_images(orbit, orbit)
        assert image == pytest.approx(unknowns_of(orbit), abs=1e-12)


def test_an_autonomous_orbit_begins_where_the_other_does():
    orbit = settle_to_orbit(NORMAL_FORM)
    angle = 1.234
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    x = orbit.x.copy()
    x[orbit.problem.unknowns.values] = (orbit.values @ turn.T).ravel()
    later = Orbit(orbit.problem, x)
    (image,) = list_images(orbit, later)
    assert image == pytest.approx(unknowns_of(later), abs=1e-9)


def test_an_orbit_with_events_begins_at_any_of_its_segments_of_the_name():
    """A ball of three hops of different lengths, and the same begun with the second."""
    orbit = settle_to_orbit("bouncing_ball", {"G": 1.1, "r": 0.8}, "400*2*pi")
    n, n_states = len(orbit.signature), orbit.numeric.n_states
    images = list_images(orbit, orbit)
    assert len(images) == n == 3
    assert images[0] == pytest.approx(unknowns_of(orbit), abs=1e-12)
    assert images[1][n_states * n :][:n] == pytest.approx(np.roll(orbit.durations, -1))
    assert images[1][:n_states] == pytest.approx(orbit.values[orbit.mesh.first_base[1]])
    begin, unit = images[1][n_states * n + n], orbit.period / orbit.problem.n_periods
    turns = (orbit.start + orbit.durations[0] - begin) / unit
    assert turns == pytest.approx(round(turns), abs=1e-12)
    assert abs(begin - orbit.start) <= 0.5 * unit + 1e-12


def test_orbits_of_other_signatures_have_no_image():
    ball, free = settle_to_orbit("bouncing_ball", t_end="200*2*pi"), settle_to_orbit(NORMAL_FORM)
    assert list_images(ball, free) == list_images(free, ball) == []
