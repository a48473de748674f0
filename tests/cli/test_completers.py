"""What a shell offers: from the file that stands before on the line."""

import pytest
import yaml
from click.shell_completion import ShellComplete

from pddecont.cli import group
from pddecont.cli.completers import _offer
from tests.cli.test_cli import QUICK, QUICK_TEXT, call


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    found = tmp_path_factory.mktemp("completed")
    (found / "quick.yaml").write_text(QUICK_TEXT)
    run = {"model": "quick.yaml", "steps": QUICK["run"]["steps"]}
    (found / "run.yaml").write_text(yaml.safe_dump(run))
    assert call("run", found / "quick.yaml", "-o", found / "quick.h5", "-q")[0] == 0
    return found


@pytest.fixture
def complete(folder, monkeypatch):
    monkeypatch.chdir(folder)

    def offered(*words):
        shell = ShellComplete(group, {}, "pddecont", "_PDDECONT_COMPLETE")
        *before, last = words
        return [item.value for item in shell.get_completions(before, last)]

    return offered


def test_steps_and_labels_of_a_results_file(complete):
    assert complete("plot", "quick.h5", "--step", "") == ["transient", "orbit", "branch"]
    assert complete("plot", "quick.h5", "--step", "b") == ["branch"]
    assert complete("export", "quick.h5", "--step", "o") == ["orbit"]
    assert complete("plot", "quick.h5", "--label", "E") == ["EP1", "EP2"]
    assert complete("export", "quick.h5", "--step", "orbit", "--label", "") == []


def test_what_axes_show(complete):
    offered = complete("plot", "quick.h5", "--step", "branch", "-y", "")
    assert {"wall", "omega", "top", "speed", "period", "x", "v"} <= set(offered)
    assert complete("plot", "quick.h5", "-x", "wa") == ["wall"]


@pytest.mark.parametrize("file", ["quick.yaml", "run.yaml"])
def test_what_a_run_takes(complete, file):
    assert complete("run", file, "--until", "") == ["transient", "orbit", "branch"]
    assert complete("run", file, "--set", "w") == ["wall="]
    assert complete("run", file, "--without", "d") == ["damping"]
    assert complete("info", file, "--without", "w") == ["wall"]


def test_what_an_exploration_takes(complete):
    assert complete("explore", "quick.yaml", "--over", "om") == ["omega="]
    assert complete("explore", "quick.yaml", "--box", "") == ["x=", "v="]
    assert complete("run", "duffing", "--set", "o") == ["omega="]


def test_styles(complete):
    assert "ggplot" in complete("plot", "quick.h5", "--style", "gg")


@pytest.mark.parametrize(
    "words",
    [
        ("plot", "nothing.h5", "--step", ""),
        ("plot", "quick.yaml", "--label", ""),
        ("plot", "--step", ""),
        ("run", "nothing.yaml", "--set", ""),
        ("run", "quick.h5", "--only", ""),
    ],
)
def test_what_cannot_be_read_offers_nothing(complete, words):
    assert complete(*words) == []


def test_names_that_mean_something_to_a_shell_are_not_offered():
    names = ["good", "a$(touch x)", "b;c", "two words", "line\nbreak", "`d`", "x1", "good"]
    assert [item.value for item in _offer(names, "")] == ["good", "x1"]
