"""Surfaces at which both vector fields may point: how fast an orbit leaves them."""

import numpy as np
import pytest

from pddecont.orbit import find_violation
from pddecont.orbit.leaving import find_leaving_rate, list_sliding_ends
from tests.orbit.test_verification import FRICTION, follow
from tests.orbits import settle_to_orbit


def find_force(orbit, s):
    """Return what pulls the block on at its turn, less the friction that holds it: the acceleration just after."""
    t = orbit.start + orbit.event_times[s + 1]
    at = orbit.mesh.locate(orbit.theta, orbit.event_times[[s]] + orbit.durations[s] * (1 - 1e-14), segment=s)[0]
    x = orbit.mesh.interpolate(orbit.values, at)[0, 0]
    om, f0 = orbit.parameters
    mode = orbit.signature.segments[(s + 1) % 2].mode
    return f0 * np.cos(om * t) - x + (1.0 if mode == "minus" else -1.0)


def test_the_rate_is_the_acceleration_after_the_turn_in_the_direction_of_the_turn():
    orbit = settle_to_orbit(FRICTION, {"om": 0.9}, 400)
    assert list_sliding_ends(orbit.signature) == [0, 1]
    for s in (0, 1):
        sign = -1.0 if orbit.signature.names[s] == "P" else 1.0
        assert find_leaving_rate(orbit, s) == pytest.approx(sign * find_force(orbit, s), abs=1e-9)
        assert find_leaving_rate(orbit, s) > 0.0


@pytest.mark.parametrize(("om", "leaves"), [(0.72, False), (0.723, True), (1.2357, True), (1.236, False)])
def test_the_rate_changes_its_sign_where_sticking_begins(om, leaves):
    """The block sticks outside [0.7226791944, 1.2357471523]; nobody simulates here."""
    orbit = follow(settle_to_orbit(FRICTION, {"om": 0.9}, 400), "om", om)
    assert min(find_leaving_rate(orbit, s) for s in (0, 1)) * (1 if leaves else -1) > 0.0
    assert find_violation(orbit, None).code == ("" if leaves else "slides")
