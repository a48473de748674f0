"""Margins to what a branch cannot pass, their derivatives against differences, and what is said where one is met."""

import numpy as np
import pytest

from pddecont.orbit import DelayBoundary, DurationBoundary, Orbit, RangeBoundary
from tests.known_orbits import impact_oscillator

RANGES = ((0.1, 0.2), (3.0, 5.0))


def at(orbit):
    """Return an orbit in the place of an evaluation that holds it."""
    return type("At", (), {"orbit": orbit, "x": orbit.x})()


def free_orbit():
    return impact_oscillator().with_free(("K", "tau_d"))


def delays():
    orbit = free_orbit()
    return DelayBoundary(orbit.numeric, orbit.parameters, orbit.problem.free_index)


def ranges():
    return RangeBoundary(("K", "tau_d"), RANGES)


@pytest.mark.parametrize("boundary", [ranges(), delays(), DurationBoundary()])
def test_gradients_are_derivatives_of_margins(boundary):
    orbit = free_orbit()
    found = boundary.gradients(at(orbit))
    assert found.shape == (len(boundary.margins(at(orbit))), len(orbit.x))
    moving = np.arange(orbit.problem.unknowns.durations.start - 2, len(orbit.x))
    assert not np.any(found[:, : moving[0]])
    for k in moving:
        step = 1e-6 * np.eye(len(orbit.x))[k]
        ahead, behind = (boundary.margins(at(Orbit(orbit.problem, orbit.x + s))) for s in (step, -step))
        assert found[:, k] == pytest.approx((ahead - behind) / 2e-6, abs=1e-8)


def test_the_range_has_two_ends_for_each_parameter():
    boundary, orbit = ranges(), free_orbit()
    assert boundary.margins(at(orbit)) == pytest.approx([0.02, 0.8, 0.08, 1.2])
    reasons = [boundary.reason(at(orbit), k) for k in range(4)]
    assert [(r.values["parameter"], r.values["value"]) for r in reasons] == [
        ("K", 0.1),
        ("tau_d", 3.0),
        ("K", 0.2),
        ("tau_d", 5.0),
    ]
    assert {r.code for r in reasons} == {"range"}


def test_a_delay_that_becomes_negative_is_named_with_its_parameters():
    boundary, orbit = delays(), free_orbit()
    assert boundary.margins(at(orbit)) == pytest.approx([3.8])
    reason = boundary.reason(at(orbit), 0)
    assert (reason.code, reason.values["delay"]) == ("negative_delay", "tau_d")
    # A delay that is a parameter itself is zero where it ends, whatever rounding left; others are not mentioned.
    assert {k: v for k, v in reason.values.items() if k != "delay"} == {"at tau_d": 0.0}


def test_a_segment_vanishes():
    boundary, orbit = DurationBoundary(), impact_oscillator()
    assert boundary.margins(at(orbit)) == pytest.approx(orbit.durations, rel=1e-10)
    reason = boundary.reason(at(orbit), 1)
    assert (reason.code, reason.values["number"], reason.values["segment"]) == ("segment_vanishes", 2, "C")
