"""Jumps that come back through a delay: whether they carry an event function over its zero."""

import numpy as np
import pytest

from pddecont.delay import Chebyshev
from pddecont.model import parse_document
from pddecont.orbit import find_violation
from pddecont.orbit.carried_events import list_carried_events, list_unlisted_carried_events
from tests.orbit.exact import circle
from tests.orbit.test_verification import ECHO, with_parameters
from tests.orbits import settle_to_orbit
from tests.runs import to_yaml


def test_a_jump_that_falls_short_of_a_level():
    """x jumps from 1 to d; read tau later it is above 0.5 on both sides, by (d - 0.5) of (1 - 0.5) + (d - 0.5)."""
    orbit = settle_to_orbit(ECHO, {"d": 0.7})
    (event,) = list_unlisted_carried_events(orbit)
    assert (event.event, event.direction, event.segment) == ("echo", "falling", None)
    assert event.find_time(orbit) == pytest.approx(0.3, abs=1e-12)
    assert event.measure(orbit) == pytest.approx(-0.2 / 0.7, abs=1e-10)
    assert list_carried_events(orbit) == []


def test_a_jump_that_carries_the_function_over_ends_a_segment():
    """For d = 0.3 it carries the function from 0.5 above its zero to 0.2 below; moved to d = 0.6 it would not."""
    orbit = settle_to_orbit(ECHO, {"d": 0.3})
    (event,) = list_carried_events(orbit)
    assert orbit.signature.names[event.segment] == "hit"
    assert event.measure(orbit) == pytest.approx(0.2 / 0.7, abs=1e-10)
    assert list_unlisted_carried_events(orbit) == []
    assert find_violation(orbit, None).code == ""
    values = orbit.values.copy()
    first = orbit.mesh.base_index[np.flatnonzero(orbit.mesh.segment == (event.source + 1) % 2)[0], 0]
    values[first, 0] = 0.6
    moved = type(orbit)(orbit.problem, orbit.problem.unknowns.join(values, orbit.durations, orbit.start, orbit.free))
    assert event.measure(moved) == pytest.approx(-0.1 / 0.6, abs=1e-10)
    assert event.explain(moved).code == "missing"


def test_where_a_delay_line_smooths_jumps_none_carries_anything():
    orbit = circle("s", method=Chebyshev(12))
    assert list_carried_events(orbit) == list_unlisted_carried_events(orbit) == []


def test_an_unlisted_event_is_told_with_its_time():
    orbit = settle_to_orbit(ECHO, {"d": 0.7})
    (event,) = list_unlisted_carried_events(orbit)
    found = event.explain(with_parameters(orbit, tau=0.2))
    assert (found.code, found.values["event"], found.values["instead"]) == ("happens", "echo", "hit")
    assert found.values["time"] == pytest.approx(0.2)


def test_a_jump_read_by_a_delay_that_varies():
    """The lag is 0.3 + 0.05 y; the jump from 1 to d = 0.7 comes back at b = 0.3 + 0.05 y(b) and stays above 0.5."""
    text = to_yaml(ECHO).replace("t - tau", "t - tau - 0.05*y")
    orbit = settle_to_orbit(parse_document(text, "m").data, {"d": 0.7})
    (event,) = list_unlisted_carried_events(orbit)
    assert (event.event, event.direction, event.segment) == ("echo", "falling", None)
    time = event.find_time(orbit)
    place = orbit.mesh.locate(orbit.theta, np.array([time]))[0]
    assert time == pytest.approx(0.3 + 0.05 * orbit.mesh.interpolate(orbit.values, place)[0, 1], abs=1e-11)
    assert event.measure(orbit) == pytest.approx(-0.2 / 0.7, abs=1e-10)
    assert find_violation(orbit, None).code == ""
    moved = with_parameters(orbit, d=0.3)
    # Where the reset leads is a value of the orbit: of the one that jumps to 0.3 the event is one that happens.
    values = moved.values.copy()
    values[moved.mesh.base_index[0, 0], 0] = 0.3
    moved = type(orbit)(moved.problem, moved.problem.unknowns.join(values, moved.durations, moved.start, moved.free))
    assert event.measure(moved) == pytest.approx(0.2 / 0.7, abs=1e-10)
