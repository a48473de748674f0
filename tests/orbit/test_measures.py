"""What is measured on a circle, in closed form."""

import numpy as np
import pytest

from pddecont.collocation import MeshRule
from pddecont.model import parse_expression
from pddecont.orbit.measures import (
    measure_amplitude,
    measure_approach,
    measure_at,
    measure_maximum,
    measure_mean,
    measure_minimum,
    measure_time_in,
)
from tests.known_orbits import impact_oscillator
from tests.orbit.exact import TURN, circle


def expression(orbit, text):
    """Return an expression of the states, times and delayed states as a function."""
    model = orbit.numeric.model
    scope = model.scope("a test", delayed=model.delayed_value)
    return orbit.numeric.function([parse_expression(text, scope)])


@pytest.mark.parametrize(
    ("text", "highest", "lowest", "mean"),
    [
        ("x", 1, -1, 0),
        ("3*y - 2", 1, -5, -2),
        ("x**2", 1, 0, 0.5),
        ("x*y", 0.5, -0.5, 0),
        ("x + x(t - tau)", 2 * np.cos(0.5), -2 * np.cos(0.5), 0),
        ("x*x(t - tau)", np.cos(0.5) ** 2, np.cos(0.5) ** 2 - 1, 0.5 * np.cos(1)),
        ("x*cos(t)", 1, 0, 0.5),
        ("tau", 1, 1, 1),
    ],
)
@pytest.mark.parametrize("names", [(), ("s",)])
def test_extremes_and_means(text, highest, lowest, mean, names):
    orbit = circle(*names, level=1.5 if not names else 0.5, rule=MeshRule(12, intervals=10))
    function = expression(orbit, text)
    assert measure_maximum(orbit, function) == pytest.approx(highest, abs=1e-9)
    assert measure_minimum(orbit, function) == pytest.approx(lowest, abs=1e-9)
    assert measure_amplitude(orbit, function) == pytest.approx((highest - lowest) / 2, abs=1e-9)
    assert measure_mean(orbit, function) == pytest.approx(mean, abs=1e-9)


def test_values_at_the_ends_of_segments():
    orbit = circle("s", level=0.5)
    assert measure_at(orbit, "s", expression(orbit, "y")) == pytest.approx(0.5, abs=1e-12)
    assert measure_at(orbit, "s", expression(orbit, "x + t")) == pytest.approx(
        np.sqrt(0.75) + np.pi / 6 + TURN, abs=1e-12
    )
    assert measure_at(orbit, "s", expression(orbit, "y(t - tau)")) == pytest.approx(np.sin(np.pi / 6 - 1), abs=1e-9)
    assert np.isnan(measure_at(circle(level=1.5), "s", expression(orbit, "y")))


def test_time_in_a_mode():
    orbit = impact_oscillator()
    assert measure_time_in(orbit, "C") == orbit.durations[1]
    assert measure_time_in(orbit, "C") + measure_time_in(orbit, "NC") == pytest.approx(orbit.period)
    assert measure_time_in(orbit, "none") == 0.0
    assert measure_time_in(circle("s", "s"), "m") == pytest.approx(2 * TURN)


def test_how_near_an_event_comes():
    assert measure_approach(circle(level=1.5), "e") == pytest.approx(-0.5, abs=1e-10)
    assert np.isnan(measure_approach(circle("s", level=0.5), "e"))
