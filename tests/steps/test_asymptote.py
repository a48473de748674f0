"""Branches of orbits that run along an asymptote end there, and say what grows and where."""

import math

import numpy as np
import pytest

from pddecont.tables import describe_endings
from tests.bifurcation.runs import follow, settle
from tests.runs import monitor, parameter, run

# From x = p - 0.3 the motion leaves the saddle at 0 and is put back at 1: the period is -log(p - 0.3).
SADDLE = {
    "name": "saddle",
    "states": ["x"],
    "parameters": {"p": 0.5},
    "modes": {"up": {"x'": "x"}},
    "events": {"top": "x - 1"},
    "resets": {"down": {"x": "p - 0.3"}},
    "segments": {"up": {"mode": "up", "event": "top", "direction": "rising", "reset": "down", "to": "up"}},
    "initial": {"mode": "up", "x": 0.2},
}
# The amplitude is 1 / (1 - omega^2).
UNDAMPED = {
    "name": "undamped",
    "states": ["x", "v"],
    "parameters": {"omega": 0.63, "c": 0.0},
    "forcing": {"period": "2*pi/omega"},
    "modes": {"m": {"x'": "v", "v'": "cos(omega*t) - c*v - x"}},
    "initial": {"x": 1 / (1 - 0.63**2), "v": 0},
}
# Orbits lie on y^2/2 - x^2/2 + x^3/3 = p - q^2, around (1, 0) up to the homoclinic orbit where that is zero.
LOOP = {
    "name": "loop",
    "states": ["x", "y"],
    "parameters": {"p": -0.1, "q": 0.0},
    "modes": {"m": {"x'": "y", "y'": "x - x**2 + y*(p - q**2 - y**2/2 + x**2/2 - x**3/3)"}},
    "initial": {"x": 1.3, "y": 0},
}
# Hits x = 1 after the time log(1 / (y (p - 0.3)))  = 1 on the curve y = 1 / (e (p - 0.3)).
HYPERBOLA = {
    **SADDLE,
    "name": "hyperbola",
    "parameters": {"p": 1.0, "y": 0.5},
    "resets": {"down": {"x": "y*(p - 0.3)"}},
}


def limit_of(step, name, way=-1):
    """Return the limit of a parameter and its error, where a direction of a branch ended along an asymptote."""
    ending = step.endings[way]
    assert (ending.code, ending.values["detail"]) == ("asymptote", "grows")
    return ending.values[f"limit {name}"], ending.values[f"error {name}"]


@pytest.mark.parametrize("stability", [False, True])
def test_the_period_grows_to_a_saddle(tmp_path, stability):
    branch = follow("b", "o", {"p": [0, 1]}, direction="down", stability=stability)
    step = run({**SADDLE, "run": {"steps": [*settle(20), branch]}}, tmp_path / "a.h5").step("b")
    limit, error = limit_of(step, "p")
    assert abs(limit - 0.3) < 1e-8 and error < 1e-6
    assert step.points["period"] == pytest.approx(-np.log(step.points["parameters"][:, 0] - 0.3), rel=1e-9)
    assert step.labels[-1] == "EP1" and len(step) < 60
    (text,) = describe_endings(step)
    period = f"{step.points['period'][-1]:.8g}"
    assert text.startswith(
        f"down: runs along an asymptote (the period grows without bound, {period} here, while p tends "
    )


def test_the_amplitude_grows_to_a_resonance(tmp_path):
    branch = follow("b", "o", {"omega": [0.2, 2]}, direction="up")
    block = {"monitors": {"top": "max(x)"}, "steps": [*settle(100), branch]}
    step = run({**UNDAMPED, "run": block}, tmp_path / "a.h5").step("b")
    limit, error = limit_of(step, "omega")
    assert abs(limit - 1) < error < 1e-6
    omega = parameter(step, "omega")
    assert monitor(step, "top") == pytest.approx(1 / (1 - omega**2), rel=1e-6)
    assert "the state 'v' grows without bound" in describe_endings(step)[0]


def test_the_period_of_a_delayed_relay_grows_until_its_output_runs_away(tmp_path):
    """At a tau = ln 2 the output reaches the equilibrium of the other sign before the relay switches."""
    branch = follow("b", "o", {"a": [0, 2]}, direction="up")
    results = run({"model": "relay", "set": {"tau": 1.0, "a": 0.3}, "steps": [*settle(60), branch]}, tmp_path / "a.h5")
    limit, error = limit_of(results.step("b"), "a")
    assert abs(limit - math.log(2)) < error < 1e-6
    a, period = parameter(results.step("b"), "a"), results.step("b").points["period"]
    assert period == pytest.approx(2 * (1 - np.log(2 - np.exp(a)) / a), rel=1e-6)


def test_a_little_damping_ends_no_branch(tmp_path):
    branch = follow("b", "o", {"omega": [0.2, 2]}, direction="up", step={"max": 1}, max_points=120)
    changed = {**UNDAMPED, "parameters": {"omega": 0.63, "c": 0.05}}
    step = run({**changed, "run": {"steps": [*settle(600), branch]}}, tmp_path / "a.h5").step("b")
    assert step.endings[0].code == "range"
    assert np.max(np.abs(step.points["parameters"][:, 0])) == 2


def test_a_loop_grows_to_a_homoclinic_orbit_in_one_parameter_and_in_two(tmp_path):
    along = {"events_along": {"u": "p - 2*q + 0.05"}, "direction": "up"}
    branch = follow("b", "o", {"p": [-0.2, 0.2]}, stability=True, **along)
    curve = follow("c", ("b", "UF1"), {"p": [-0.2, 0.2], "q": [-1, 1]}, **along)
    results = run({**LOOP, "run": {"steps": [*settle(400), branch, curve]}}, tmp_path / "a.h5")
    limit, error = limit_of(results.step("b"), "p")
    assert abs(limit) < 1e-9 and error < 1e-7
    assert max(results.step("b").points["unexplained"]) == 0
    # Where p = q^2 on p = 2 q - 0.05.
    q = 1 - math.sqrt(0.95)
    for name, value in (("q", q), ("p", q**2)):
        limit, error = limit_of(results.step("c"), name)
        assert abs(limit - value) < error < 1e-6


def test_a_parameter_that_grows_along_a_curve_is_followed_to_the_end_of_its_range(tmp_path):
    branch = follow("b", "o", {"y": [0.3, 1]}, direction="up", events_along={"u": "y*(p - 0.3) - exp(-1)"})
    curve = follow(
        "c", ("b", "UF1"), {"p": [0, 2], "y": [0.1, 1e4]}, direction="up", events_along={"u": "y*(p - 0.3) - exp(-1)"}
    )
    step = run({**HYPERBOLA, "run": {"steps": [*settle(20), branch, curve]}}, tmp_path / "a.h5").step("c")
    p, y = parameter(step, "p"), parameter(step, "y")
    assert (p - 0.3) * y == pytest.approx(np.full(len(p), math.exp(-1)), rel=1e-8)
    assert step.endings[0].code == "range" and max(max(y), max(p)) in {2.0, 1e4}
