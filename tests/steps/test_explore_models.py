"""Every shipped model is explored, with a small budget, over the range of its own first branch."""

import numpy as np
import pytest
import yaml

from pddecont.data import find_shipped_folders
from pddecont.results import read_results
from pddecont.steps import Budget
from pddecont.steps.execution import execute
from pddecont.tables import describe_endings, describe_exploration_lines, list_branches, make_table
from tests.runs import plan

SMALL = {"starts": 4, "check": 4, "max_branches": 3, "depth": 1, "max_points": 40}
# A motion is not interrupted, nor a step along a branch.
SECONDS = 30.0
# Those that take two seconds or so; the others are slow.
QUICK = (
    *("act_and_wait", "bouncing_ball", "enso_relay", "relay", "relay_sliding"),
    *("rimless_wheel", "thermostat", "wall_oscillator", "wright"),
)


def list_ranges():
    """Return a parameter and its range of each model: those of its first branch."""
    found = {}
    for path in sorted(find_shipped_folders()[0].glob("*.yaml")):
        data = yaml.safe_load(path.read_text())
        branches = [step["continue"] for step in (data.get("run") or {}).get("steps", []) if "continue" in step]
        alone = [branch for branch in branches if len(branch["free"]) == 1]
        if alone:
            (name,) = alone[0]["free"]
            found[path.stem] = {name: alone[0]["range"][name]}
    return found


RANGES = list_ranges()


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[] if name in QUICK else [pytest.mark.slow]) for name in RANGES]
)
def test_a_shipped_model_is_explored(name, tmp_path):
    run = plan({"model": name, "steps": [{"name": "all", "explore": {"over": RANGES[name], **SMALL}}]})
    path = tmp_path / "a.h5"
    execute(run, path, budget=Budget(seconds=SECONDS))
    results = read_results(path)
    step = results.steps["all"]
    (ending,) = step.endings
    assert describe_endings(step)
    assert describe_exploration_lines(step)
    branches = [row for row in list_branches(step) if row["points"]]
    assert len(branches) == ending.values["n_branches"]
    (parameter,) = RANGES[name]
    for row in branches:
        low, high = RANGES[name][parameter]
        assert low - 1e-9 * abs(low) <= row["low"] <= row["high"] <= high + 1e-9 * abs(high)
    explained = [row for row in make_table(step, "motions") if row["branch"]]
    assert len(explained) == ending.values["n_explained"]
    for row in explained:
        beside = results.steps[row["branch"]].points
        column = list(results.steps[row["branch"]].meta["parameters"]).index(parameter)
        assert np.min(beside["parameters"][:, column]) <= row[parameter] + 1e-6 * (high - low)
        assert np.any(beside["stable"] == 1)
