"""Starters and completion scripts."""

import os
import shutil
import subprocess
import sys

import pytest

from pddecont.cli.new import KINDS
from pddecont.results import read_results
from tests.cli.test_cli import call


@pytest.mark.parametrize("kind", KINDS)
def test_a_starter_runs_as_written(kind, in_folder):
    code, _, err = call("new", "mine", "--kind", kind)
    assert code == 0 and "model: mine.yaml" in err
    assert call("check", "mine.yaml")[1] == "mine.yaml: no errors, 0 warning(s); 3 steps on model 'mine'\n"
    assert call("run", "mine.yaml", "-q")[0] == 0
    step = list(read_results("mine.h5").steps.values())[-1]
    assert step.labels.count("EP1") == step.labels.count("EP2") == 1
    assert set(step.points["stable"]) == {1}
    assert set(step.points["admissible"]) == {1}
    assert step.meta["units"]
    text = (in_folder / "mine.yaml").read_text()
    assert text.count("#") >= 10
    assert max(map(len, text.splitlines())) < 125


def test_a_file_that_exists_is_left_alone(in_folder):
    (in_folder / "my_model.yaml").write_text("mine")
    code, _, err = call("new")
    assert code == 1 and "exists already and is left as it is" in err
    assert (in_folder / "my_model.yaml").read_text() == "mine"
    assert call("new", "-o", "other.yaml")[0] == 0
    assert "name: my_model\n" in (in_folder / "other.yaml").read_text()
    code, _, err = call("new", "3 bad")
    assert code == 1 and "is not a name" in err
    code, _, err = call("new", "-o", "no/folder.yaml")
    assert code == 1 and "cannot be written" in err


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_script_is_one_that_the_shell_reads(shell):
    code, out, _ = call("completion", shell)
    assert code == 0 and "_PDDECONT_COMPLETE" in out
    if shutil.which(shell):
        assert subprocess.run([shell, "-n"], input=out, text=True, check=False, capture_output=True).returncode == 0
    assert call("completion", "tcsh")[0] == 2


def test_commands_and_options_are_completed():
    def completed(words):
        environment = os.environ | {
            "_PDDECONT_COMPLETE": "bash_complete",
            "COMP_WORDS": words,
            "COMP_CWORD": str(words.count(" ")),
        }
        code = "from pddecont.cli import main; main()"
        return subprocess.run(
            [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False
        ).stdout.split()

    assert completed("pddecont re") == ["plain,report"]
    assert "plain,--overwrite" in completed("pddecont run --o")
    assert "plain,impact_oscillator" in completed("pddecont run impact_")
