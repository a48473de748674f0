"""Basins of attraction: one whose border is known, and the paper's."""

import numpy as np
import pytest

from pddecont.results import read_results
from pddecont.steps.execution import basin as basin_step
from pddecont.steps.execution import execute
from pddecont.tables import describe_endings
from pddecont.tables.attractors import estimate_shares, list_attractors, list_cells, read_label_map
from tests.conftest import shipped
from tests.runs import break_after, plan, run
from tests.steps.test_sweep import same

WELLS = {
    "name": "wells",
    "states": ["x", "y"],
    "parameters": {"w": 1},
    "forcing": {"period": "2*pi/w"},
    "modes": {"m": {"x'": "x - x**3", "y'": "cos(w*t) - y"}},
    "run": {"steps": [{"name": "map", "basin": {"over": {"x": [-2, 2, 40], "y": [-1, 1, 10]}, "transient": 200}}]},
}


@pytest.fixture(scope="module")
def wells(tmp_path_factory):
    return run(WELLS, tmp_path_factory.mktemp("basin") / "w.h5")


def test_two_wells_share_the_plane_at_zero(wells):
    """x' = x - x^3: whatever y does, x goes to 1 from x > 0 and to -1 from x < 0."""
    step = wells.steps["map"]
    labels, xs = read_label_map(step), np.array(step.meta["x"])
    right = [i for i in range(len(step)) if step.labels[i] and step.orbit(i)["returns"][0, 0] > 0]
    number = [i for i in range(len(step)) if step.labels[i]].index(right[0])
    assert labels.shape == (10, 40)
    assert np.array_equal(labels == number, np.broadcast_to(xs > 0, labels.shape))
    # y at whole periods is that of y' = cos t - y: 1/2.
    assert [step.orbit(i)["returns"][0] for i in right] == [pytest.approx([1.0, 0.5], abs=1e-6)]


def test_shares_have_confidence_intervals(wells):
    shares = list(estimate_shares(wells.steps["map"]).values())
    assert [s for s, _, _ in shares] == [0.5, 0.5]
    # Wilson's interval for 200 of 400.
    assert shares[0][1:] == pytest.approx((0.4512, 0.5488), abs=1e-4)
    rows = list_attractors(wells.steps["map"])
    assert [r["label"] for r in rows] == ["A1", "A2"]
    assert "50.00 %" in describe_endings(wells.steps["map"])[0]


def test_cells_are_a_table(wells):
    rows = list_cells(wells.steps["map"])
    assert len(rows) == 400
    assert {(r["x"] > 0, r["label"]) for r in rows} in ({(True, "A1"), (False, "A2")}, {(True, "A2"), (False, "A1")})
    assert all(0 < r["settling"] < 200 for r in rows)


PAPER = {
    "model": "impact_oscillator",
    "effects": {"off": ["feedback"]},
    "steps": [
        {"name": "map", "basin": {"over": {"x": [-2, 1.26, 24], "v": [-2, 2, 20]}, "transient": "400*2*pi/omega"}}
    ],
}


def test_the_basin_of_the_orbit_with_two_impacts_is_what_single_runs_say(tmp_path):
    """The map's labels against runs from single states, followed to the end and recognised there by their last
    segments.
    """
    from pddecont.delay import Direct
    from pddecont.simulate import detect_period, simulate

    step = run(PAPER, tmp_path / "p.h5").steps["map"]
    rows = list_attractors(step)
    assert sorted(r["n_NC"] for r in rows) == [1, 2]
    labels = read_label_map(step)
    numeric = shipped("impact_oscillator")
    p = numeric.parameter_values.copy()
    p[numeric.parameter_index("K")] = 0.0
    rng = np.random.default_rng(3)
    for j, i in zip(rng.integers(0, 20, 12), rng.integers(0, 24, 12), strict=True):
        initial = [step.meta["x"][i], step.meta["y"][j]]
        trajectory = simulate(numeric, p, Direct(), 300 * 2 * np.pi / 0.8, initial=initial, constant=True)
        assert len(detect_period(numeric, p, trajectory).signature) == 2 * rows[labels[j, i]]["n_NC"]


@pytest.mark.parametrize("broken_after", [0, 4])
def test_a_broken_run_goes_on_to_the_same_map(wells, tmp_path, monkeypatch, broken_after):
    checked = plan(WELLS)
    whole = break_after(monkeypatch, basin_step, broken_after)
    with pytest.raises(KeyboardInterrupt):
        execute(checked, tmp_path / "r.h5")
    monkeypatch.setattr(basin_step, "map_in_order", whole)
    execute(checked, tmp_path / "r.h5", resume=True, workers=2)
    assert same(wells, read_results(tmp_path / "r.h5"), "map")


def test_attractors_that_no_first_look_finds_are_found_all_the_same(tmp_path):
    """Wells at 1, 2 and 3, that at 2 from 1.98 to 2.02 only: two of the grid's columns lie in it, none of those looked
    at first.
    """
    text = {
        "name": "wells",
        "states": ["x", "y"],
        "parameters": {"w": 1},
        "forcing": {"period": "2*pi/w"},
        "modes": {"m": {"x'": "-100*(x - 1)*(x - 1.98)*(x - 2)*(x - 2.02)*(x - 3)", "y'": "cos(w*t) - y"}},
        "run": {
            "steps": [{"name": "map", "basin": {"over": {"x": [0.91, 3.31, 101], "y": [0, 1, 2]}, "transient": 4000}}]
        },
    }
    step = run(text, tmp_path / "n.h5").steps["map"]
    found = {label: step.orbit(i)["returns"][0, 0] for i, label in enumerate(step.labels) if label}
    assert found == {
        "A1": pytest.approx(1.0, abs=1e-5),
        "A2": pytest.approx(3.0, abs=1e-5),
        "A3": pytest.approx(2.0, abs=1e-5),
    }
    assert np.array_equal(np.sum(read_label_map(step) == 2, axis=1), [2, 2])


def test_each_attractor_is_as_large_as_it_is(tmp_path):
    """x' = -(x^2 - 0.04) x below 1, a well at 1e4 above it; v dies away: three attractors, each with its own basin."""
    text = {
        "name": "wells",
        "states": ["x", "v"],
        "parameters": {"w": 1},
        "forcing": {"period": "2*pi/w"},
        "modes": {
            "low": {"x'": "-x*(x**2 - 0.04) + 1e-6*cos(w*t)", "v'": "-v"},
            "high": {"x'": "1e4 - x + cos(w*t)", "v'": "-v"},
        },
        "events": {"up": "x - 1"},
        "segments": {"leave": {"mode": "low", "event": "up", "direction": "rising", "to": "high"}},
        "initial": {"mode": "low"},
        "run": {
            "steps": [
                {"name": "a", "basin": {"over": {"x": [-0.5, 0.5, 10], "v": [-1, 1, 3]}, "transient": 2000}},
                {
                    "name": "b",
                    "basin": {
                        "over": {"x": [-0.5, 0.5, 10], "v": [-1, 1, 3]},
                        "initial": {"mode": "high"},
                        "transient": 2000,
                    },
                },
            ]
        },
    }
    results = run(text, tmp_path / "w.h5")
    step = results.steps["a"]
    found = [step.orbit(i)["returns"][0, 0] for i in range(len(step)) if step.labels[i]]
    assert sorted(found) == pytest.approx([-0.2, 0.2], abs=1e-4)
    assert [share for share, _, _ in estimate_shares(step).values()] == [0.5, 0.5]
    assert len([i for i in range(len(results.steps["b"])) if results.steps["b"].labels[i]]) == 1
