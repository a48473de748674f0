"""Delayed events that no segment of an orbit ends at: when they come, and whether they happen."""

import numpy as np
import pytest

from pddecont.orbit.admissibility import find_violations
from pddecont.orbit.clocks import Clock, list_started_events, list_unlisted_clocks
from tests.orbit.test_verification import REFRACTORY, with_parameters
from tests.orbits import settle_to_orbit

# In closed form: from 0.1, a rest of R that lets it decay, then up to 1.
PERIOD = 0.4 + np.log((1.5 - 0.1 * np.exp(-0.4)) / 0.5)


def test_a_clock_comes_so_long_after_what_starts_it():
    orbit = settle_to_orbit(REFRACTORY)
    assert orbit.period == pytest.approx(PERIOD, abs=1e-9)
    assert [clock.event for clock in list_unlisted_clocks(orbit)] == ["kick"]
    spike = orbit.event_times[1 + orbit.signature.names.index("rest")]
    started = [(t, since) for t, since, name in list_started_events(orbit) if name == "kick" and 0 <= since < PERIOD]
    assert started == [(pytest.approx(spike % PERIOD + 0.2), pytest.approx(spike % PERIOD))]


@pytest.mark.parametrize(
    ("tau", "inside"),
    # The kick counts from the end of the rest, R after the firing, to the next firing, again and again.
    [(0.1, -0.1), (0.3, -0.1), (0.39, -0.01), (0.45, 0.05), (PERIOD - 0.02, 0.02), (PERIOD + 0.05, -0.05)],
)
def test_a_delayed_event_happens_inside_modes_that_it_ends(tau, inside):
    orbit = with_parameters(settle_to_orbit(REFRACTORY), tau=tau)
    (clock,) = list_unlisted_clocks(orbit)
    assert clock.measure(orbit) == pytest.approx(inside / PERIOD, abs=1e-9)
    found = [reason.code for reason in find_violations(orbit)]
    assert found == (["happens"] if inside > 0 else [])
    assert clock.explain(orbit).values["segment"] == "rest"


def test_a_clock_that_a_segment_ends_at_is_listed():
    orbit = settle_to_orbit(REFRACTORY, {"tau": 0.6})
    assert "hit" in orbit.signature.names
    assert list_unlisted_clocks(orbit) == []


def test_two_clocks_that_run_as_long_come_together_and_tell_nothing():
    """The rest ends as the kick comes, whatever R is: no change of sign says anything of it."""
    events = {**REFRACTORY["events"], "kick": {"after": "spike", "delay": "R"}}
    segments = {**REFRACTORY["segments"], "hit": {**REFRACTORY["segments"]["hit"], "mode": "ref"}}
    orbit = settle_to_orbit({**REFRACTORY, "events": events, "segments": segments})
    assert sorted(orbit.signature.names) == ["refr", "rest"]
    assert list_unlisted_clocks(orbit) == []
    later = {**events, "kick": {"after": "spike", "delay": "R + 0.1"}}
    orbit = settle_to_orbit({**REFRACTORY, "events": later, "segments": segments})
    assert list_unlisted_clocks(orbit) == [Clock("kick", orbit.signature.names.index("rest"))]
