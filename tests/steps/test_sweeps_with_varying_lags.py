"""Sweeps and basins of models whose delays vary."""

import numpy as np
import pytest

from pddecont.tables.attractors import list_attractors, read_label_map
from tests.runs import run

GAINS = [1.8, 2.2, 2.6]
LAG = {
    "name": "lag",
    "states": ["x"],
    "parameters": {"a": 2.0, "c": 0.3},
    "modes": {"m": {"x'": "-a*tanh(x(t - 1 - c*x))"}},
    "initial": {"x": 0.5},
}
WELLS = {
    "name": "wells",
    "states": ["x", "y"],
    "parameters": {"w": 1, "c": 0.2},
    "forcing": {"period": "2*pi/w"},
    "modes": {"m": {"x'": "x(t - 0.1 - c*x**2) - x**3", "y'": "cos(w*t) - y"}},
    "initial": {"x": 0.5, "y": 0.0},
}


def test_a_sweep_finds_the_orbits_that_a_branch_follows(tmp_path):
    sweep = {"over": {"a": [1.8, 2.6, 3]}, "transient": 80, "section": {"zero": "x", "direction": "rising"}}
    steps = [{"name": "diagram", "sweep": sweep}]
    for k, a in enumerate(GAINS):
        steps.append({"name": f"motion{k}", "set": {"a": a}, "simulate": {"t_end": 100}})
        steps.append({"name": f"orbit{k}", "set": {"a": a}, "orbit": {"from": f"motion{k}", "stability": True}})
    results = run({**LAG, "run": {"mesh": {"degree": 6, "tol": 1e-8}, "steps": steps}}, tmp_path / "a.h5")
    rows = list_attractors(results.steps["diagram"])
    assert [r["a"] for r in rows] == pytest.approx(GAINS)
    for k, row in enumerate(rows):
        orbit = results.steps[f"orbit{k}"]
        assert orbit.points["verified"][0] != 0
        assert orbit.points["stable"][0] == 1
        assert row["turn"] == pytest.approx(orbit.points["period"][0], rel=1e-7)


def test_wells_share_the_plane_at_zero_whatever_the_lag(tmp_path):
    """x' = x(t - 0.1 - c x^2) - x^3: where x was positive all along it stays so, and goes to 1; likewise to -1."""
    basin = {"over": {"x": [-1.5, 1.5, 8], "y": [-1, 1, 2]}, "transient": 200}
    results = run({**WELLS, "run": {"steps": [{"name": "map", "basin": basin}]}}, tmp_path / "b.h5")
    step = results.steps["map"]
    labels, xs = read_label_map(step), np.array(step.meta["x"])
    right = [i for i in range(len(step)) if step.labels[i] and step.orbit(i)["returns"][0, 0] > 0]
    number = [i for i in range(len(step)) if step.labels[i]].index(right[0])
    assert np.array_equal(labels == number, np.broadcast_to(xs > 0, labels.shape))
    assert [step.orbit(i)["returns"][0] for i in right] == [pytest.approx([1.0, 0.5], abs=1e-6)]
