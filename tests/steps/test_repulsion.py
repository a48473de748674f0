"""Motions that nothing decides, in sweeps, basins and along branches: they are recorded, and the others go on."""

import numpy as np
import pytest

from pddecont.tables import describe_endings
from pddecont.tables.attractors import list_attractors, read_label_map
from tests.runs import change, parameter, run

# x = 0 repels as long as |a| < 1: to the right x is drawn to 1 + .., to the left to -1 + ...
WELLS = {
    "name": "wells",
    "states": ["x", "y"],
    "parameters": {"a": 0.1},
    "forcing": {"period": "2*pi"},
    "equations": {"x'": "sign(x) - x + a*cos(t)", "y'": "-y"},
    "initial": {"x": 0.5},
    "run": {"steps": [{"name": "map", "basin": {"over": {"x": [-1, 1, 5], "y": [0, 1, 2]}, "transient": 400}}]},
}
AWAY = "both fields point away from it (its rate is -0.9 below and 1.1 above)"


def test_in_a_basin_starts_on_the_surface_are_failures_of_their_own(tmp_path):
    step = run(WELLS, tmp_path / "b.h5").steps["map"]
    rows = list_attractors(step)
    assert sorted(r["label"] or "none" for r in rows) == ["A1", "A2", "none"]
    cells = read_label_map(step)
    assert np.array_equal(cells[0], cells[1])
    assert [len(set(cells[0][:2])), len(set(cells[0][3:])), len(set(cells[0]))] == [1, 1, 3]
    assert (
        f"none (at t = 0 the motion is on the surface x = 0 of switch 'x' at x = 0, y = 0, and {AWAY}"
        in (describe_endings(step)[0])
    )
    assert describe_endings(step)[0].count("20.00 %") == 1


@pytest.mark.parametrize("carried", [True, False])
def test_a_sweep_goes_on_where_a_start_is_decided(carried, tmp_path):
    """From x = 0 nothing decides for |a| < 1; beyond the motion crosses the surface and all go to one cycle."""
    body = {"over": {"a": [0.5, 1.5, 3]}, "initial": [{"x": 0}, {"x": 0.5}], "transient": 400}
    body |= {"carry": "up"} if carried else {}
    model = change(WELLS, "run.steps", [{"name": "sweep", "sweep": body}])
    step = run(model, tmp_path / "s.h5").steps["sweep"]
    found = [(round(float(step.points["parameters"][i, 0]), 9), step.reason(i).code) for i in range(len(step))]
    assert ("repelled" in [code for a, code in found if a == 0.5]) and (0.5, "") in found
    assert all(code == "" for a, code in found if a > 1.01)


# Every T the jump puts x on 0. It slides for m > 1, goes on above with rate 1 - m for -1 < m < 1; below, 0 repels it.
PUT = {
    "name": "put",
    "states": ["x", "y"],
    "parameters": {"m": 0.5, "T": 2},
    "forcing": {"period": "T"},
    "equations": {"x'": "1 - m*sign(x)", "y'": "x - y"},
    "initial": {"x": 0.1},
    "jumps": {"put": {"every": "T", "reset": {"x": 0}}},
    "run": {
        "steps": [
            {"name": "transient", "simulate": {"t_end": 80}},
            {"name": "orbit", "orbit": {"from": "transient"}},
            {"name": "branch", "continue": {"from": "orbit", "free": ["m"], "range": {"m": [-2, 2]}}},
        ]
    },
}


@pytest.mark.parametrize("verify", [True, False])
def test_a_branch_ends_where_its_orbit_is_put_on_a_surface_that_repels(verify, tmp_path):
    branch = run(change(PUT, "run.steps.2.continue.verify", verify), tmp_path / "b.h5").steps["branch"]
    assert parameter(branch, "m", "MC1") == pytest.approx(-1, abs=1e-12)
    assert "of switch 'x', and both fields point away from it (its rate is" in describe_endings(branch)[0]
    assert np.min(parameter(branch, "m")) == pytest.approx(-1, abs=1e-12)
