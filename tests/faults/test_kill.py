"""Runs of each kind killed at random instants, and around every call to the system that changes a file."""

import json
import os
import subprocess
import sys

import pytest

from tests.conftest import ROOT
from tests.faults.runs import KINDS

# `make reliability` does all 200.
NUMBER, SEED = int(os.environ.get("PDDECONT_KILLS", "25")), 20201120


def kill(kind, way, folder):
    """Return what ``tests.faults.kill`` found in a process of its own: forks of one with threads are unreliable."""
    folder.mkdir()
    done = subprocess.run(
        [sys.executable, "-W", "error", "-m", "tests.faults.kill", kind, way, str(NUMBER), str(SEED), str(folder)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return json.loads(done.stdout.splitlines()[-1])


@pytest.mark.parametrize("kind", KINDS)
def test_a_run_killed_at_random_instants_goes_on_to_the_same_file(kind, tmp_path, tally):
    found = kill(kind, "random", tmp_path / kind)
    assert not found["failures"], "\n".join(found["failures"])
    assert found["killed"] == NUMBER
    # Instants are spread over the whole step, so that many fall where its file is being written.
    assert found["had_written"] > 0
    tally(
        "faults",
        f"{kind} killed at a random instant",
        "file opens, all finished points there, --resume gives the same file",
        NUMBER,
    )


@pytest.mark.parametrize("kind", ["simulate", "sweep", "basin"])
def test_a_run_killed_around_every_write_goes_on_to_the_same_file(kind, tmp_path, tally):
    if kind != "simulate" and NUMBER < 200:
        pytest.skip("`make reliability` does the longer ones")
    found = kill(kind, "calls", tmp_path / kind)
    assert not found["failures"], "\n".join(found["failures"])
    assert found["killed"] == 3 * found["calls"]
    assert found["calls"] > 20
    tally(
        "faults",
        f"{kind} killed before, within or after a write",
        "file opens, all finished points there, --resume gives the same file",
        found["killed"],
    )
