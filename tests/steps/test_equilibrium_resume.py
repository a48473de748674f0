"""Branches and curves of equilibria that are interrupted anywhere go on to the same numbers."""

import numpy as np
import pytest

from pddecont.results import read_results
from pddecont.steps.execution import equilibrium_branch
from pddecont.tables import describe_endings
from tests.runs import run
from tests.steps.test_equilibrium_curves import TAKENS, ZERO_HOPF_DELAYED, follow, make_model

# Rests on a surface along which it slides between a = -0.62 and 0.92.
RELAY = {
    "name": "relay",
    "states": ["x", "y"],
    "parameters": {"a": 0.5, "k": 0.3},
    "equations": {"x'": "y - k*x - sign(x - a)", "y'": "-x - y + 0.2"},
    "initial": {"x": 0.3, "y": 0},
    "run": {
        "steps": [
            {"name": "rest", "equilibrium": {"from": {"x": 0.3, "y": 0}}},
            {"name": "branch", "continue": {"from": "rest", "free": ["a"], "range": {"a": [-2, 2]}}},
        ]
    },
}
RUNS = {
    "modes": RELAY,
    "folds": make_model(ZERO_HOPF_DELAYED, [follow(ZERO_HOPF_DELAYED, "branch", "along", "LP1")]),
    "hopf": make_model(ZERO_HOPF_DELAYED, [follow(ZERO_HOPF_DELAYED, "branch", "along", "HB1")]),
    "takens": make_model(TAKENS, [follow(TAKENS, "folds", "along", "LP1"), follow(TAKENS, "branch", "folds", "BT1")]),
}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    return {name: run(made, folder / f"{name}.h5").step("branch") for name, made in RUNS.items()}


@pytest.mark.parametrize("name", RUNS)
@pytest.mark.parametrize("share", [0.0, 0.3, 0.6, 0.95])
def test_resume(whole, tmp_path, monkeypatch, name, share):
    keep = max(1, int(share * len(whole[name])))
    record, count = equilibrium_branch._Branch.record, []

    def stop(self, point):
        record(self, point)
        count.extend([1] * (self.step.name == "branch"))
        if len(count) == keep:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(equilibrium_branch._Branch, "record", stop)
        with pytest.raises(KeyboardInterrupt):
            run(RUNS[name], tmp_path / "m.h5")
    assert len(read_results(tmp_path / "m.h5").step("branch")) == keep
    resumed = run(RUNS[name], tmp_path / "m.h5", resume=True).step("branch")
    for key, values in whole[name].points.items():
        assert np.array_equal(values, resumed.points[key], equal_nan=values.dtype.kind == "f"), key
    for row in range(len(resumed)):
        for key, values in whole[name].orbit(row).items():
            assert np.array_equal(values, resumed.orbit(row)[key]), (row, key)
    assert describe_endings(whole[name]) == describe_endings(resumed)


def test_the_branch_goes_through_three_modes(whole):
    step = whole["modes"]
    assert len({step.orbit(i)["signature"].tobytes() for i in range(len(step))}) == 3
