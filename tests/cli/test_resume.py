"""A run of a delay equation on adaptive meshes, interrupted anywhere, goes on to the same numbers."""

import numpy as np
import pytest

from pddecont.orbit.serialise import mesh_from_row
from pddecont.results import read_results
from pddecont.steps.execution import continuation
from pddecont.tables import describe_endings
from tests.cli.test_cli import QUICK, call
from tests.runs import add_step, change, to_yaml

ADAPTIVE = change(QUICK, "run.mesh", {"degree": 5, "tol": 1e-7})
DELAYED = {
    **change(ADAPTIVE, "run.steps.2.continue", {"from": "orbit", "free": ["tau"], "range": {"tau": [0.3, 2.4]}}),
    "parameters": {**QUICK["parameters"], "K": 0.2, "tau": 0.7},
    "modes": {"free": {"x'": "v", "v'": "cos(omega*t) - c*v - x + K*(v(t - tau) - v)"}},
}
DELAYED = change(DELAYED, "run.steps.2.continue.step", {"max": 0.05})
SMOOTH = {
    "name": "wright",
    "states": ["x"],
    "parameters": {"alpha": 2, "tau": 1},
    "modes": {"growth": {"x'": "-alpha*x(t - tau)*(1 + x)"}},
    "initial": {"x": 0.1},
    "run": {
        "mesh": {"degree": 5, "tol": 1e-06},
        "steps": [
            {"name": "transient", "simulate": {"t_end": 60}},
            {"name": "orbit", "orbit": {"from": "transient"}},
            {
                "name": "branch",
                "continue": {"from": "orbit", "free": ["alpha"], "range": {"alpha": [1.8, 2.4]}, "step": {"max": 0.05}},
            },
        ],
    },
}
# Down in the wall's place impacts are added one by one; then a curve of impacts of speed zero.
SIGNATURES = change(
    ADAPTIVE,
    "run.steps.2.continue",
    {
        "from": "orbit",
        "free": ["wall"],
        "range": {"wall": [-1, 0.6]},
        "max_points": 60,
        "stability": True,
        "step": {"max": 0.05},
    },
)
UP = {"from": "orbit", "free": ["wall"], "range": {"wall": [0.15, 0.6]}, "stability": True, "direction": "up"}
PLANE = {"wall": [0.15, 0.6], "r": [0.3, 0.9]}
CURVE = add_step(
    change(ADAPTIVE, "run.steps.2", {"name": "first", "continue": UP}),
    {
        "name": "branch",
        "continue": {
            "from": {"step": "first", "point": "PD1"},
            "free": ["wall", "r"],
            "range": PLANE,
            "stability": True,
        },
    },
)
RUNS = {"delayed": DELAYED, "smooth": SMOOTH, "signatures": SIGNATURES, "curve": CURVE}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    for name, made in RUNS.items():
        (folder / f"{name}.yaml").write_text(to_yaml(made))
        code, _, err = call("run", folder / f"{name}.yaml", "-o", folder / f"{name}.h5", "-q")
        assert code == 0, err
    return {name: read_results(folder / f"{name}.h5").step("branch") for name in RUNS}


@pytest.mark.parametrize("name", RUNS)
@pytest.mark.parametrize("share", [0.05, 0.4, 0.9])
def test_resume(whole, tmp_path, monkeypatch, name, share):
    keep = max(1, int(share * len(whole[name])))
    record, count = continuation._Branch.record, []

    def stop(self, point):
        error = record(self, point)
        count.extend([1] * (self.step.name == "branch"))
        if len(count) == keep:
            raise KeyboardInterrupt
        return error

    (tmp_path / "m.yaml").write_text(to_yaml(RUNS[name]))
    with monkeypatch.context() as patch:
        patch.setattr(continuation._Branch, "record", stop)
        assert call("run", tmp_path / "m.yaml", "-o", tmp_path / "m.h5", "-q")[0] == 130
    assert len(read_results(tmp_path / "m.h5").step("branch")) == keep
    assert call("run", tmp_path / "m.yaml", "-o", tmp_path / "m.h5", "--resume", "-q")[0] == 0
    resumed = read_results(tmp_path / "m.h5").step("branch")
    for key, values in whole[name].points.items():
        assert np.array_equal(values, resumed.points[key], equal_nan=values.dtype.kind == "f"), key
    assert np.array_equal(whole[name].orbits["states"], resumed.orbits["states"])
    assert describe_endings(whole[name]) == describe_endings(resumed)


def test_the_branch_changes_its_signature_and_the_curve_is_one(whole):
    names = {whole["signatures"].orbit(i)["signature"].tobytes() for i in range(len(whole["signatures"]))}
    assert len(names) > 2
    assert whole["curve"].meta["curve"] == "PD"
    assert len(whole["curve"]) > 10


def test_the_branch_crosses_breaking_points(whole):
    step = whole["delayed"]
    meshes = [mesh_from_row(step.orbit(i)["mesh"]) for i in range(len(step))]
    orders = {tuple(tuple(piece.start) for piece in mesh.pieces) for mesh in meshes}
    assert len(orders) > 2
