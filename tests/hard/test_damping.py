"""Damping to zero."""

import numpy as np
import pytest

from pddecont.errors import ConvergenceError
from pddecont.tables import describe_endings
from pddecont.tables.endings import list_warnings
from tests.runs import add_step, change, multipliers, parameter, run

DOWN = {"from": "o", "free": ["c"], "range": {"c": [0, 0.3]}, "direction": "down"}
DRIVEN = {
    "name": "driven",
    "states": ["x", "v"],
    "parameters": {"w": 0.7, "c": 0.3},
    "forcing": {"period": "2*pi/w"},
    "modes": {"m": {"x'": "v", "v'": "cos(w*t) - c*v - x"}},
    "run": {
        "mesh": {"degree": 8, "tol": 1e-11},
        "monitors": {"amp": "amplitude(x)"},
        "steps": [{"name": "t", "simulate": {"t_end": "40*2*pi"}}, {"name": "o", "orbit": {"from": "t"}}],
    },
}


def test_a_driven_oscillator(tmp_path, record):
    model = add_step(DRIVEN, {"name": "c", "continue": {**DOWN, "stability": True}})
    step = run(model, tmp_path / "a.h5").step("c")
    c = parameter(step, "c")
    assert c[0] == 0.0
    exact = 1 / np.hypot(1 - 0.49, 0.7 * c)
    record(
        "amplitude, damping 0.3 to 0",
        "closed form",
        np.max(np.abs(step.points["monitors"][step.order, 0] - exact)),
        1e-10,
    )
    found = multipliers(step, step.row("EP1"))
    record("multipliers without damping", "on the unit circle", np.max(np.abs(np.abs(found) - 1)), 1e-11)
    # Nobody is told that orbits without damping are stable, or unstable.
    stable = step.points["stable"]
    assert stable[step.row("EP1")] == -1 and step.points["n_unstable"][step.row("EP1")] == 0
    assert np.all(stable[step.order][c > 0.01] == 1)
    assert any("one lies on the unit circle" in warning for warning in list_warnings(step))


def test_of_one_orbit_without_damping_it_is_said(tmp_path):
    model = change(DRIVEN, "run.steps.1.orbit.stability", True)
    still = {"name": "still", "set": {"c": 0}, "orbit": {"from": "o", "stability": True}}
    results = run(add_step(model, still), tmp_path / "a.h5")
    assert "; stable, leading" in describe_endings(results.step("o"))[0]
    assert "no multiplier outside the unit circle but at least one on it" in describe_endings(results.step("still"))[0]


def test_resonance_without_damping_is_refused(tmp_path, record):
    """At the resonance orbits without damping do not exist: the amplitude grows like 1/c, and the branch must not
    invent one at c = 0.
    """
    model = add_step(change(DRIVEN, "parameters.w", 1), {"name": "c", "continue": {**DOWN, "max_points": 60}})
    step = run(model, tmp_path / "a.h5").step("c")
    c, amplitude = parameter(step, "c"), step.points["monitors"][step.order, 0]
    assert c[0] > 0.0
    record(
        "amplitude at resonance, relative, as far as the branch goes", "1/c", np.max(np.abs(amplitude * c - 1)), 1e-9
    )
    assert "max_points" in describe_endings(step)[0]


def test_families_of_orbits_are_refused(tmp_path, record):
    """The pendulum without damping has an orbit of every size: no Newton step tells which, and none is made up."""
    pendulum = {
        "name": "pendulum",
        "states": ["x", "v"],
        "parameters": {"c": 0},
        "modes": {"m": {"x'": "v", "v'": "-sin(x) - c*v"}},
        "initial": {"x": 1, "v": 0},
        "run": {
            "mesh": {"degree": 8, "tol": 1e-10},
            "monitors": {"amp": "amplitude(x)"},
            "steps": [{"name": "t", "simulate": {"t_end": 200}}, {"name": "o", "orbit": {"from": "t"}}],
        },
    }
    with pytest.raises(ConvergenceError, match="no periodic orbit near the guess"):
        run(pendulum, tmp_path / "a.h5")
    record("one orbit out of a family", "refused", 0, 0)
