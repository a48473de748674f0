"""Motions that go on from an orbit's past, and what they do there as guesses."""

from dataclasses import replace

import numpy as np
import pytest

from pddecont.collocation import MeshRule
from pddecont.errors import SignatureError
from pddecont.orbit import Orbit, guess_from_motion
from pddecont.orbit.motion import list_started_events, simulate_onwards
from tests.orbit.exact import TURN, circle
from tests.orbits import settle_to_orbit

# A neuron that fires, each time followed by a kick.
KICKED = {
    "name": "kicked",
    "states": ["x"],
    "parameters": {"I": 1.5, "tau": 0.5, "J": 0.05},
    "modes": {"go": {"x'": "I - x"}},
    "events": {"spike": "x - 1", "kick": {"after": "spike", "delay": "tau"}},
    "resets": {"fire": {"x": 0}, "push": {"x": "x + J"}},
    "segments": {
        "rest": {"mode": "go", "event": "spike", "direction": "rising", "reset": "fire", "to": "go"},
        "hit": {"mode": "go", "event": "kick", "reset": "push", "to": "go"},
    },
    "initial": {"x": 0},
}


@pytest.mark.parametrize("names", [("s",), ("s", "s")])
def test_at_the_orbits_own_parameters_the_motion_is_the_orbit(names):
    orbit = circle(*names)
    trajectory = simulate_onwards(orbit, orbit.parameters, 2.0)
    t = np.linspace(trajectory.t0, trajectory.t_end, 60)
    assert trajectory.t_end - trajectory.t0 == pytest.approx(2.0 * orbit.period)
    assert np.max(np.abs(trajectory(t) - np.stack([np.cos(t), np.sin(t)], axis=1))) < 1e-7
    assert set(trajectory.events.segment) == {"s"}


def test_delayed_events_under_way_are_listed_with_their_starts():
    orbit = settle_to_orbit(KICKED)
    fired = orbit.event_times[1 + orbit.signature.names.index("rest")]
    times, starts, names = zip(*list_started_events(orbit), strict=True)
    assert set(names) == {"kick"}
    assert np.allclose(np.subtract(times, starts), 0.5, atol=1e-14)
    assert np.allclose((np.array(starts) - fired) % orbit.period % orbit.period, 0.0, atol=1e-12) or np.allclose(
        np.minimum((np.array(starts) - fired) % orbit.period, orbit.period - (np.array(starts) - fired) % orbit.period),
        0.0,
        atol=1e-12,
    )
    assert min(times) < 0.0 < orbit.period < max(times)


def test_a_motion_of_the_same_signature_is_no_other_one():
    with pytest.raises(SignatureError, match="same signature"):
        guess_from_motion(circle("s"), 1.6, MeshRule(8, tol=1e-8))


def test_beyond_the_circle_nothing_is_crossed_and_within_it_something_is():
    """Where the level leaves the circle its motion has no events; where it comes back it has one a turn."""
    rule = MeshRule(8, tol=1e-8)
    outside, inside = circle("s"), circle(level=1.5)
    beyond = replace(outside.problem, parameters=inside.parameters)
    guess = guess_from_motion(Orbit(beyond, outside.x), 2.6, rule)
    assert not guess.signature.has_events
    assert guess.period == pytest.approx(TURN)
    within = replace(inside.problem, parameters=outside.parameters)
    guess = guess_from_motion(Orbit(within, inside.x), 2.6, rule)
    assert guess.signature.names == ["s"]
    assert guess.period == pytest.approx(TURN, abs=1e-6)
