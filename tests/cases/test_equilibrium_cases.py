"""The smooth cases once more, from their equilibria: Hopf points, the orbits born there, and back to a Hopf point.

References: characteristic equations. A Hopf point at which orbits shrink is the equilibrium's own.
"""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.cases.test_cases import load
from tests.runs import labels, parameter, run

# Two calculations of one Hopf point.
SAME = 1e-9


def from_rest(name, tmp_path, free, rest, span, start, orbits=None, more=()):
    """Return the results of a case's model, from its equilibrium over a parameter to the orbits of its first HB."""
    born = {"from": {"step": "at_rest", "point": "HB1"}, "branch": "switch", "free": [free], "range": {free: span}}
    steps = [
        {"name": "rest", "set": {free: start}, "equilibrium": {"from": rest}},
        {"name": "at_rest", "continue": {"from": "rest", "free": [free], "range": {free: span}}},
        {"name": "orbits", "continue": born | (orbits or {})},
        *more,
    ]
    return run({**load(name), "run": {"steps": steps}}, tmp_path / "a.h5")


def steps_of(name, last, **changed):
    """Return a case's own steps up to one of them, whose keys are ``changed``."""
    steps = load(name)["run"]["steps"]
    own = steps[: [step["name"] for step in steps].index(last) + 1]
    return [*own[:-1], {**own[-1], "continue": {**own[-1]["continue"], **changed}}]


@pytest.mark.parametrize(
    ("name", "free", "rest", "start", "span", "place"),
    [
        ("hopf_wright", "tau", {"x": 1}, 1.2, [1.0, 2.1], math.pi / 2),
        ("hopf_normal_form", "m", {"x": 0, "y": 0}, -0.5, [-1, 1], 0.0),
    ],
)
def test_orbits_of_a_simulation_shrink_to_the_equilibriums_own_hopf_point(
    name, free, rest, start, span, place, tmp_path
):
    results = from_rest(name, tmp_path, free, rest, span, start, more=steps_of(name, "down"))
    at_rest, orbits, down = (results.step(step) for step in ("at_rest", "orbits", "down"))
    assert parameter(at_rest, free, "HB1") == pytest.approx(place, abs=1e-12)
    assert parameter(down, free, "HB1") == pytest.approx(parameter(at_rest, free, "HB1"), abs=SAME)
    assert at_rest.reason(at_rest.row("HB1")).values["nature"] == "supercritical"
    # The orbits are born on the side on which the simulation found one.
    assert max(parameter(orbits, free)) == span[1]
    assert np.all(parameter(orbits, free) > place)


def test_neurons_begin_to_fire_at_one_hopf_point_from_both_sides(tmp_path):
    results = from_rest(
        "neuron",
        tmp_path,
        "a21",
        {"x1": 0, "x2": 0},
        [0.3, 2.3],
        0.5,
        {"stability": True},
        steps_of("neuron", "br", range={"a21": [0.7, 1.6]}, direction="down"),
    )
    at_rest = results.step("at_rest")

    def gain(w):
        """(l + kappa - beta exp(-l taus)) exp(l (tau1 + tau2)/2) at l = i w, whose square is a12 a21."""
        return (1j * w + 0.5 + np.exp(-1.5j * w)) * np.exp(0.2j * w)

    w = brentq(lambda w: gain(w).imag, 0.6, 0.9, xtol=1e-15)
    assert parameter(at_rest, "a21", "HB1") == pytest.approx(gain(w).real ** 2, abs=1e-12)
    assert at_rest.points["frequency"][at_rest.row("HB1")] == pytest.approx(w, abs=1e-12)
    assert parameter(at_rest, "a21", "BP1") == pytest.approx(2.25, abs=1e-12)
    assert parameter(results.step("br"), "a21", "HB1") == pytest.approx(gain(w).real ** 2, abs=SAME)
    orbits = results.step("orbits")
    assert parameter(orbits, "a21", "EP1") == 2.3
    assert np.all(orbits.points["stable"][orbits.order][1:] == 1)


def hopf_of_duffing(fast, a=0.5, b=0.6, d=0.05):
    """Return delay and frequency at which i w is a root of l^2 + d l + a + b = b exp(-l tau)."""
    half = a + b - d**2 / 2
    square = half + (1 if fast else -1) * math.sqrt(half**2 - (a + b) ** 2 + b**2)
    w = math.sqrt(square)
    return math.atan2(-d * w, a + b - square) % (2 * math.pi) / w, w


def test_orbits_of_a_hardening_spring_lead_from_one_hopf_point_to_the_other(tmp_path):
    results = from_rest("duff", tmp_path, "tau", {"x": 0, "v": 0}, [0.3, 20], 1.0)
    at_rest, orbits = results.step("at_rest"), results.step("orbits")
    (begin, w_begin), (end, w_end) = hopf_of_duffing(True), hopf_of_duffing(False)
    for label, place, w in (("HB1", begin, w_begin), ("HB3", end, w_end)):
        assert parameter(at_rest, "tau", label) == pytest.approx(place, abs=1e-11)
        assert at_rest.points["frequency"][at_rest.row(label)] == pytest.approx(w, abs=1e-12)
    assert [label for label in labels(orbits) if label.startswith(("HB", "LP"))] == ["LP1", "HB1"]
    assert orbits.points["period"][0] == pytest.approx(2 * math.pi / w_begin, rel=1e-2)
    assert parameter(orbits, "tau", "HB1") == pytest.approx(parameter(at_rest, "tau", "HB3"), abs=SAME)
    assert orbits.points["period"][orbits.row("HB1")] == pytest.approx(2 * math.pi / w_end, abs=SAME)
