"""An exploration on two workers, killed at random sizes of its file: no process is left, --resume goes on."""

import os
import random
import subprocess
import sys
import time
from pathlib import Path

import pytest

from pddecont.results import read_results
from tests.cli.test_cli import call
from tests.conftest import ROOT
from tests.faults.test_early_steps_ended import find_others, is_running
from tests.steps.test_explore import holds_same

WORDS = (
    "explore",
    "bouncing_ball",
    "--over",
    "G=0.3:1.2",
    "--starts",
    8,
    "--check",
    8,
    "--depth",
    2,
    "--workers",
    2,
    "-q",
)


def size_of(path):
    """Return a file's size in bytes, 0 where there is none."""
    return path.stat().st_size if path.exists() else 0


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="processes are looked for in /proc")
def test_it_goes_on_to_the_same_steps(tmp_path, tally):
    whole, path, rng, seen = tmp_path / "whole.h5", tmp_path / "a.h5", random.Random(3), set()
    codes = []
    assert call(*WORDS, "-o", whole)[0] == 0
    # How much of the file is there when the process is killed: what says so at any speed of the machine.
    for part in sorted(rng.uniform(0.05, 0.9) for _ in range(3)):
        how = ["--resume"] if path.exists() else []
        command = [sys.executable, "-m", "pddecont", *map(str, WORDS), "-o", str(path), *how]
        process = subprocess.Popen(command, cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(ROOT)})
        while process.poll() is None and size_of(path) < part * size_of(whole):
            seen |= find_others(process.pid)
            time.sleep(0.01)
        process.kill()
        codes.append(process.wait())
    # A file is made smaller at times: what is asked for last may come with the end.
    assert seen and path.exists() and codes[0] == -9
    assert call(*WORDS, "-o", path, "--resume")[0] == 0
    assert holds_same(read_results(path), read_results(whole))
    deadline = time.monotonic() + 20
    while any(map(is_running, seen)) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not any(map(is_running, seen))
    tally("faults", "SIGKILL while an exploration has two workers", "no process is left, the same steps", 1)
