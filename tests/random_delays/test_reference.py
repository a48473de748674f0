"""The calculations apart tell orbits that are right from those that are not."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from tests.random_delays.reference import Past, check_own_past, check_smooth
from tests.random_models.formula import Formula, States, name
from tests.random_models.random_model import RandomModel, Segment
from tests.random_models.recorded import RecordedOrbit
from tests.random_models.test_comparison import exact_orbit

TURN = 2 * np.pi


def record(function, edges, names, ends, parameters, degree=12):
    """Return an orbit of a function of time by polynomials of a degree between edges."""
    places = 0.5 - 0.5 * np.cos(np.pi * np.arange(degree + 1) / degree)
    nodes = [a + (b - a) * places for a, b in pairwise(edges)]
    values = [np.array([function(t, 0.5 * (n[0] + n[-1])) for t in n]) for n in nodes]
    return RecordedOrbit(
        edges[0], edges[-1] - edges[0], names, np.array(ends), list(edges[:-1]), nodes, values, 1e-12, parameters
    )


def sine_model(python):
    """Return the forced model x' = what a formula says."""
    return RandomModel(
        seed=0, family="sine", states=("x",), parameters={"q": 0.1}, delays=(),
        modes={"m": {"x": Formula("", python)}}, initial={}, free="q", span=(0.0, 1.0), period=name("pi") * 2,
    )  # fmt: skip


# x = sin t obeys each: a lag that varies, a rate, an integral between limits, one over all the past.
SINES = [
    "cos(t) + read(1 + q*z[0], 0)[0] - sin(t - 1 - q*z[0])",
    "-0.5*read(pi, 1)[0] + 0.5*cos(t) - z[0] + sin(t)",
    "integrate(lambda s, u: u[0], 0, pi) + 3*cos(t) + sin(t) - z[0]",
    "remember(lambda u: u[0], 1.0, 0) + 0.5*(3*cos(t) - sin(t)) + sin(t) - z[0]",
]


@pytest.mark.parametrize("python", SINES)
def test_a_sine_is_found_and_a_moved_one_is_told_apart(python):
    model = sine_model(python)
    edges = np.linspace(0, TURN, 9)
    for factor, low, high in ((1.0, 0.0, 1e-8), (1.001, 5e-4, 1e-2)):
        orbit = record(lambda t, _, f=factor: [f * np.sin(t)], edges, ["(m)"], [TURN], {"q": 0.1})
        assert low <= check_smooth(model, orbit).deviation <= high


def tooth(reset="d"):
    """Return x' = 1 from d to 1, y' = -y + x(t - tau), with x a delay ago read by a lag that is written as varying."""
    x = States(("x", "y"))
    return RandomModel(
        seed=0, family="tooth", states=("x", "y"), parameters={"d": 0.2, "tau": 0.3}, delays=(),
        modes={"go": {"x": 0 * x["x"] + 1, "y": Formula("", "read(tau + 0*z[0], 0)[0] - z[1]")}}, initial={},
        free="d", span=(0.1, 0.3), events={"top": x["x"] - 1}, resets={"back": {"x": name(reset)}},
        segments={"rise": Segment("go", "top", "rising", "back", "go")},
    )  # fmt: skip


def test_an_orbit_with_events_is_what_its_own_past_makes_of_it():
    orbit = exact_orbit()
    n = max(len(nodes) for nodes in orbit.nodes)
    alike = [np.linspace(nodes[0], nodes[-1], n) for nodes in orbit.nodes]
    values = [np.array([orbit(t, 1 if t < nodes[-1] else -1) for t in nodes]) for nodes in alike]
    orbit = replace(orbit, nodes=alike, values=values)
    verdict = check_own_past(tooth(), orbit)
    assert verdict.fault == ""
    assert verdict.deviation < 1e-9
    moved = replace(orbit, values=[v + np.array([0.0, 1e-4]) for v in values])
    assert check_own_past(tooth(), moved).deviation > 1e-5
    assert check_own_past(tooth(reset="tau"), orbit).deviation > 1e-2


def test_rates_of_the_past_are_derivatives():
    orbit = record(lambda t, _: [np.sin(t), np.cos(2 * t)], np.linspace(0, TURN, 17), ["(m)"], [TURN], {})
    t = np.linspace(-20, 20, 101)
    assert Past(orbit)(t) == pytest.approx(np.array([np.sin(t), np.cos(2 * t)]), abs=1e-10)
    assert Past(orbit)(t, 1) == pytest.approx(np.array([np.cos(t), -2 * np.sin(2 * t)]), abs=1e-8)
