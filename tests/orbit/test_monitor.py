"""Monitors read from text: their values on known orbits, and what is said of texts that are none."""

import numpy as np
import pytest

from pddecont.model import ExpressionError
from pddecont.orbit import parse_monitor
from tests.known_orbits import impact_oscillator
from tests.orbit.exact import TURN, circle

ORBIT = circle("s", level=0.5)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("period", TURN),
        ("2*max(x) + level", 2.5),
        ("min(y)/amplitude(x) - mean(x*x)", -1.5),
        ("at(s, y)**2", 0.25),
        ("time_in(m)/period", 1.0),
        ("max(x(t - tau)) - tau", 0.0),
        ("3", 3.0),
        (7.5, 7.5),
        ("sqrt(max(x) + max(x))", np.sqrt(2)),
    ],
)
def test_values(text, value):
    monitor = parse_monitor(ORBIT.numeric, "a", text)
    assert monitor.name == "a"
    assert monitor.evaluate(ORBIT) == pytest.approx(value, abs=1e-9)


def test_the_event_functions_extremum():
    orbit = circle(level=1.5)
    assert parse_monitor(orbit.numeric, "a", "extremum(e)").evaluate(orbit) == pytest.approx(-0.5, abs=1e-10)
    assert np.isnan(parse_monitor(ORBIT.numeric, "a", "extremum(e)").evaluate(ORBIT))


def test_monitors_name_others():
    numeric = ORBIT.numeric
    others = {"swing": parse_monitor(numeric, "swing", "max(x) - min(x)")}
    assert parse_monitor(numeric, "a", "swing**2 + swing", others).evaluate(ORBIT) == pytest.approx(6.0)


def test_free_parameters_count_with_their_values_on_the_orbit():
    orbit = circle(level=1.25, free=("level",))
    assert parse_monitor(orbit.numeric, "a", "level - max(y)").evaluate(orbit) == pytest.approx(0.25)


def test_only_what_the_text_needs_is_measured():
    """The period is always at hand; it is not measured for a text without it."""
    monitor = parse_monitor(ORBIT.numeric, "a", "max(x) + 0*min(y)")
    assert [measure is not None for measure in monitor.measures] == [False, True, False]


@pytest.mark.parametrize(
    ("text", "message", "offset"),
    [
        ("x + 1", r"state 'x' varies along the orbit: write max\(x\), mean\(x\), or at\(segment, x\)", 0),
        ("1 + max(x, y)", "max takes one argument, found 2", 4),
        ("at(s)", "at takes a segment and an expression", 0),
        ("at(q, x)", r"'q' is not a segment.*segments: s", 3),
        ("time_in(walk)", r"'walk' is not a mode.*modes: m", 8),
        ("extremum(hit)", r"'hit' is not an event.*events: e", 9),
        ("max(z)", "z", 4),
        ("x(t - tau)", r"a state varies along the orbit: write max\(\.\.\.\)", 0),
    ],
)
def test_texts_that_write_none(text, message, offset):
    with pytest.raises(ExpressionError, match=message) as failure:
        parse_monitor(ORBIT.numeric, "a", text)
    assert failure.value.offset == offset


def test_speed_at_the_wall():
    """At the end of the flight the oscillator is at the wall."""
    orbit = impact_oscillator()
    assert parse_monitor(orbit.numeric, "a", "at(NC, x) - e").evaluate(orbit) == pytest.approx(0, abs=1e-11)
