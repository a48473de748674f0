"""Pairs that cross the axis and come back within a step of a branch, and pairs that cross in opposite directions."""

import numpy as np
import pytest

from pddecont.equilibrium import crossings
from tests.runs import run

ZETA, W = 0.02, 0.3
TOOL = {
    "name": "tool",
    "states": ["x", "v"],
    "parameters": {"tau": 0.3, "w": W, "zeta": ZETA},
    "equations": {"x'": "v", "v'": "w*(x(t - tau) - x) - 2*zeta*v - x"},
}


def find_crossings(low, high):
    """Return where 1 + W - s^2 + 2 ZETA s i = W exp(-i s tau), in order: frequencies do not depend on the delay."""
    squares = np.roots([1.0, 4.0 * ZETA**2 - 2.0 * (1.0 + W), (1.0 + W) ** 2 - W**2])
    found = []
    for s in np.sqrt(squares):
        turn = -np.angle((1.0 + W - s**2 + 2j * ZETA * s) / W)
        delays = (turn + 2.0 * np.pi * np.arange(-2, 100)) / s
        found += delays[(delays > low) & (delays < high)].tolist()
    return sorted(found)


@pytest.mark.parametrize("largest", [0.1, 0.01])
def test_every_crossing_is_found_whatever_the_step(tmp_path, largest):
    """A step of a tenth of the range is some fourteen units of the delay long, and two crossings are .08 apart."""
    branch = {"from": "rest", "free": ["tau"], "range": {"tau": [0.2, 140]}, "max_points": 2000}
    branch["step"] = {"initial": 0.01, "max": largest}
    steps = [{"name": "rest", "equilibrium": {"from": {"x": 0}}}, {"name": "in_tau", "continue": branch}]
    step = run({**TOOL, "run": {"steps": steps}}, tmp_path / "r.h5").step("in_tau")
    at = np.array(step.points["kind"]) == b"HB"
    exact = find_crossings(0.2, 140.0)
    assert len(exact) == 50
    assert np.allclose(np.sort(step.points["parameters"][at, 0]), exact, rtol=1e-11)


def test_a_pair_that_stays_on_the_axis_crosses_it_nowhere(tmp_path, monkeypatch):
    """Without damping roots are +-i all along; steps are not cut in search of crossings."""
    looked = []
    whole = crossings._find_speeds
    monkeypatch.setattr(crossings, "_find_speeds", lambda *args: looked.append(1) or whole(*args))
    spring = {"name": "o", "states": ["x", "v"], "parameters": {"f": 0.5}, "equations": {"x'": "v", "v'": "f - x"}}
    branch = {"from": "rest", "free": ["f"], "range": {"f": [0, 1]}, "step": {"max": 0.05}}
    steps = [{"name": "rest", "equilibrium": {"from": {"x": 0.4}}}, {"name": "b", "continue": branch}]
    step = run({**spring, "run": {"steps": steps}}, tmp_path / "r.h5").step("b")
    assert set(step.points["kind"].tolist()) == {b"", b"EP"}
    assert 0 < len(looked) <= 3 * len(step)
