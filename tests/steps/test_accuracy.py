"""Method, degree and mesh chosen for an accuracy: the error is met, the choice is kept and the same each time."""

import json

import pytest

from pddecont.errors import RunError
from pddecont.results import read_results
from tests.cli.test_cli import call
from tests.runs import run, to_yaml

RELAY = {
    "model": "relay",
    "set": {"a": 0.5},
    "monitors": {"size": "amplitude(x)"},
    "steps": [
        {"name": "transient", "simulate": {"t_end": 60}},
        {"name": "orbit", "orbit": {"from": "transient"}},
        {"name": "branch", "continue": {"from": "orbit", "free": ["a"], "range": {"a": [0.4, 0.6]}}},
    ],
}
IMPACT = {
    "model": "impact_oscillator",
    "monitors": {"v": "at(NC, v)"},
    "steps": [
        {"name": "transient", "simulate": {"t_end": "300*2*pi/omega"}},
        {"name": "orbit", "orbit": {"from": "transient"}},
    ],
}


@pytest.mark.parametrize("accuracy", [1e-2, 1e-4, 1e-6, 1e-8, 1e-10])
def test_the_error_is_met_without_paying_for_much_more(accuracy, tmp_path):
    step = run({**IMPACT, "accuracy": accuracy}, tmp_path / "i.h5").step("orbit")
    # 0.734426370925 is an independent prototype's; the velocity's size along the orbit is about one.
    error = abs(step.points["monitors"][0, 0] - 0.734426370925)
    assert error <= accuracy
    if accuracy >= 1e-8:
        unknowns = {1e-2: 140, 1e-4: 220, 1e-6: 320, 1e-8: 420}[accuracy]
        assert step.points["n_unknowns"][0] < unknowns


def test_a_closed_form_and_a_branch_that_goes_on_with_the_choice(tmp_path):
    results = run({**RELAY, "accuracy": 1e-6}, tmp_path / "r.h5")
    orbit, branch = results.step("orbit"), results.step("branch")
    assert orbit.points["period"][0] == pytest.approx(6.1847010803, rel=1e-6)
    choice = json.loads(orbit.meta["choice"])
    assert choice["delay"]["method"] == "direct"
    assert branch.meta["choice"] == orbit.meta["choice"]
    again = run({**RELAY, "accuracy": 1e-6}, tmp_path / "again.h5").step("orbit")
    assert again.meta["choice"] == orbit.meta["choice"]


def test_the_command_says_what_it_chose_and_resumes_with_it(in_folder):
    (in_folder / "r.yaml").write_text(to_yaml(RELAY))
    code, _, err = call("run", "r.yaml", "--accuracy", "1e-7", "--until", "orbit")
    assert code == 0
    assert "accuracy of 1e-07: the delay equation itself, degree" in err and "estimated error" in err
    before = read_results("r.h5").step("orbit").meta["choice"]
    assert call("run", "r.yaml", "--accuracy", "1e-7", "--resume")[0] == 0
    results = read_results("r.h5")
    assert results.step("branch").meta["choice"] == before == results.step("orbit").meta["choice"]
    assert call("run", "r.yaml", "--accuracy", "1e-3", "--resume")[0] == 1


def test_what_it_excludes(tmp_path):
    with pytest.raises(RunError, match="leave 'mesh' out"):
        run({**RELAY, "accuracy": 1e-6, "mesh": {"degree": 4}}, tmp_path / "r.h5")
