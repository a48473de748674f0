"""What follows from the ordered segments alone."""

import numpy as np
import pytest
import scipy.linalg
import scipy.optimize
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.delay import DiscontinuitySources
from pddecont.errors import SignatureError
from pddecont.orbit import Signature, is_rotation, make_eventless
from pddecont.orbit.signature import WatchedEvent, link_delayed_events
from tests.conftest import numeric_from, shipped
from tests.runs import multipliers, run

NAMES = st.lists(st.sampled_from("ab"), max_size=6)


@settings(max_examples=50, deadline=None, derandomize=True)
@given(NAMES, st.integers(0, 10))
def test_a_rotation_is_one(names, turn):
    turned = names[turn % max(len(names), 1) :] + names[: turn % max(len(names), 1)]
    assert is_rotation(names, turned)
    assert is_rotation(turned, names)
    assert not is_rotation(names, [*turned, "a"])


@settings(max_examples=50, deadline=None, derandomize=True)
@given(NAMES, NAMES)
def test_only_rotations_are(a, b):
    assert is_rotation(a, b) == (len(a) == len(b) and "".join(a) in "".join([*b, *b]))


def test_what_a_signature_says():
    numeric = shipped("impact_oscillator")
    segments = numeric.model.segments
    contact = Signature(numeric, (segments["NC"], segments["C"]))
    assert (len(contact), contact.names) == (2, ["NC", "C"])
    assert contact.has_events
    assert not contact.needs_phase_reference
    assert contact.discontinuity_sources == DiscontinuitySources((1, 1), (0,))
    free = Signature(numeric, (make_eventless(numeric.model, "NC"),))
    assert (free.names, free.has_events) == (["(NC)"], False)
    # A forced orbit begins at a time that is given; one of an autonomous model anywhere.
    assert not free.needs_phase_reference
    assert Signature(
        shipped("mackey_glass"), (make_eventless(shipped("mackey_glass").model, "blood"),)
    ).needs_phase_reference


def test_segments_watch_the_events_that_end_their_mode():
    numeric = numeric_from("""
name: m
states: [x]
parameters: {a: 1}
modes: {one: {x': a}, two: {x': -a}}
events: {high: x - 1, low: x + 1, late: {after: high, delay: a}}
segments:
  up: {mode: one, event: high, direction: rising, to: two}
  down: {mode: one, event: low, direction: any, to: two}
  back: {mode: two, event: low, direction: falling, to: one}
  wait: {mode: two, event: late, to: one}
""")
    segments = numeric.model.segments
    signature = Signature(numeric, (segments["up"], segments["back"], segments["wait"]))
    # Each direction once, and no event without a function.
    assert signature.list_watched_events(0) == (WatchedEvent("high", "rising", True), WatchedEvent("low", "any", False))
    assert signature.list_watched_events(1) == (WatchedEvent("low", "falling", True),)
    assert signature.list_watched_events(2) == (WatchedEvent("low", "falling", False),)
    assert signature.list_watched_events(0) is signature.list_watched_events(0)


@pytest.mark.parametrize(("tau", "wraps"), [(0.4, 0), (0.4 + 1.1, 1), (0.4 + 5 * 1.1, 5)])
def test_a_delayed_event_is_linked_to_what_started_it(tau, wraps):
    """A spike at the end of a period of 1.1, and a pulse 0.4 after it."""
    numeric = shipped("spiking_neuron")
    p = numeric.parameter_values.copy()
    p[numeric.parameter_index("tau")] = tau
    segments = numeric.model.segments
    signature = Signature(numeric, (segments["pulse"], segments["spike"]))
    (link,) = link_delayed_events(signature, p, np.array([0.4, 0.7]))
    # The spike at the end of the period is one period after that at its start.
    assert (link.segment, link.source, link.wraps) == (0, 1, wraps + 1)


def test_a_delayed_event_needs_its_source():
    numeric = shipped("spiking_neuron")
    signature = Signature(numeric, (numeric.model.segments["pulse"],))
    with pytest.raises(SignatureError, match="'pulse', which comes after 'spike', but no segment of this orbit ends"):
        link_delayed_events(signature, numeric.parameter_values, np.array([1.0]))


def test_the_nearest_of_several_sources_is_taken():
    numeric = shipped("spiking_neuron")
    segments = numeric.model.segments
    signature = Signature(numeric, (segments["spike"], segments["spike"], segments["pulse"]))
    # Spikes at 1.0 and 1.7, a pulse at 2.1: with a delay of 0.4 that of the second.
    (link,) = link_delayed_events(signature, numeric.parameter_values, np.array([1.0, 0.7, 0.4]))
    assert (link.segment, link.source, link.wraps) == (2, 1, 0)


# A converter whose comparator answers tau late: the clock's jump comes back tau later and opens the switch.
LATE = {
    "name": "buck",
    "states": ["v", "i", "s"],
    "parameters": {"E": 22, "R": 22, "C": 47e-6, "L": 0.02, "T": 4e-4, "gamma": 11.75238, "eta": 1309.524, "tau": 2e-6},
    "modes": {
        "idle": {"v'": "(i - v/R)/C", "i'": "-v/L", "s'": 1},
        "feed": {"v'": "(i - v/R)/C", "i'": "(E - v)/L", "s'": 1},
    },
    "events": {"compare": "v(t - tau) - gamma - eta*s(t - tau)", "tick": "s - T"},
    "resets": {"restart": {"s": 0}},
    "segments": {
        "close": {"mode": "idle", "event": "compare", "direction": "falling", "to": "feed"},
        "clock_idle": {"mode": "idle", "event": "tick", "direction": "rising", "reset": "restart", "to": "idle"},
        "clock": {"mode": "feed", "event": "tick", "direction": "rising", "reset": "restart", "to": "feed"},
        "open": {"mode": "feed", "event": "compare", "direction": "rising", "to": "idle"},
    },
    "initial": {"mode": "idle", "v": 12, "i": 0.5},
    "run": {
        "monitors": {"v_max": "max(v)"},
        "steps": [
            {"name": "t", "simulate": {"t_end": "200*T", "record": {"from": "190*T"}}},
            {"name": "o", "orbit": {"from": "t", "stability": True}},
        ],
    },
}


def follow_late_converter(x, E=22.0, R=22.0, C=47e-6, L=0.02, T=4e-4, gamma=11.75238, eta=1309.524, tau=2e-6):
    """Return (v, i) a clock period after they were ``x``, by matrix exponentials."""
    A = np.array([[-1 / (R * C), 1 / C], [-1 / L, 0]])
    fed = -np.linalg.solve(A, [0.0, E / L])
    opened = fed + scipy.linalg.expm(A * tau) @ (x - fed)
    met = scipy.optimize.brentq(
        lambda t: (scipy.linalg.expm(A * (t - tau)) @ opened)[0] - gamma - eta * t, tau, T - tau, xtol=1e-18
    )
    closed = scipy.linalg.expm(A * met) @ opened
    return fed + scipy.linalg.expm(A * (T - met - tau)) @ (closed - fed)


def test_an_event_that_a_jump_makes_ends_its_segment_where_the_jump_comes_back(tmp_path):
    step = run(LATE, tmp_path / "a.h5").step("o")
    states = step.orbit(0)["states"]
    x = states[np.argmin(np.abs(states[:, 2])), :2]
    for _ in range(300):
        x = follow_late_converter(x)
    apart = 1e-5 * np.eye(2)
    monodromy = [(follow_late_converter(x + d) - follow_late_converter(x - d)) / 2e-5 for d in apart]
    exact = np.sort_complex(np.linalg.eigvals(np.transpose(monodromy)))
    assert np.sort_complex(multipliers(step)[:2]) == pytest.approx(exact, abs=1e-6)
    assert np.min(np.max(np.abs(states[:, :2] - x), axis=1)) < 1e-8
