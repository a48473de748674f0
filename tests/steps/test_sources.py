"""What a step starts from is looked for before anything is written."""

import pytest

from pddecont.errors import ResultsError, RunError
from pddecont.model import parse_document
from pddecont.results import read_results
from pddecont.steps import load_run_plan
from pddecont.steps.execution import execute
from tests.runs import change, to_yaml

MODEL = {
    "name": "m",
    "states": ["x"],
    "parameters": {"K": 0.5},
    "forcing": {"period": "2*pi"},
    "modes": {"only": {"x'": "-x + K*sin(x) + cos(t)"}},
    "run": {
        "mesh": {"degree": 6, "tol": 1e-06},
        "steps": [
            {"name": "transient", "simulate": {"t_end": 60}},
            {"name": "orbit", "orbit": {"from": "transient"}},
            {"name": "in_K", "continue": {"from": "orbit", "free": ["K"], "range": {"K": [0.4, 0.6]}, "max_points": 3}},
        ],
    },
}


def planned(model, folder):
    """Return the plan of a model that lies in a folder."""
    return load_run_plan(parse_document(to_yaml(model), str(folder / "m.yaml")))


def test_a_step_without_its_source_leaves_the_file_as_it_is(tmp_path):
    plan, path = planned(MODEL, tmp_path), tmp_path / "a.h5"
    execute(plan, path)
    before = path.read_bytes()
    for name, keep in ((path, True), (tmp_path / "new.h5", False)):
        with pytest.raises(
            RunError, match="step 'in_K' starts from step 'orbit', which is not done in this run; give --resume"
        ):
            execute(plan, name, only="in_K", overwrite=True)
        assert name.exists() == keep
    assert path.read_bytes() == before


def test_only_one_step_of_a_file_that_holds_its_source(tmp_path):
    plan, path = planned(MODEL, tmp_path), tmp_path / "a.h5"
    with pytest.raises(RunError, match="give --resume"):
        execute(plan, path, only="in_K", resume=True)
    assert not path.exists()
    execute(plan, path, until="transient")
    with pytest.raises(ResultsError, match=r"has no step 'orbit' \(steps: transient\)"):
        execute(plan, path, only="in_K", resume=True)
    execute(plan, path, only="orbit", overwrite=True)  # it simulates what it starts from
    execute(plan, path, only="in_K", resume=True)
    assert read_results(path).names == ("orbit", "in_K")


@pytest.mark.parametrize(
    ("step", "output", "error", "message"),
    [
        ({"step": "in_K", "point": "LP7"}, "b.h5", ResultsError, "has no point 'LP7'"),
        ({"step": "in_J", "index": 0}, "b.h5", ResultsError, "has no step 'in_J'; did you mean 'in_K'"),
        (
            {"step": "in_K", "index": 0},
            "a.h5",
            RunError,
            "step 'again' starts from .*a.h5, which this run would replace; give another -o",
        ),
    ],
)
def test_what_another_file_lacks_is_known_before_anything_is_written(tmp_path, step, output, error, message):
    execute(planned(MODEL, tmp_path), tmp_path / "a.h5")
    execute(planned(MODEL, tmp_path), tmp_path / "b.h5", until="transient")
    before = (tmp_path / output).read_bytes()
    other = change(MODEL, "run.steps", [{"name": "again", "orbit": {"from": {"file": "a.h5", **step}}}])
    with pytest.raises(error, match=message):
        execute(planned(other, tmp_path), tmp_path / output, overwrite=True)
    assert (tmp_path / output).read_bytes() == before
