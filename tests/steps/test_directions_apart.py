"""Both directions of a branch at once: the same file as one after the other, whatever becomes of the other process."""

import math
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from pddecont.errors import ConvergenceError, RunError
from pddecont.results import read_results
from pddecont.simulate import Workers, begin_apart, other_process
from pddecont.steps.execution import continuation, execute
from tests.bifurcation.runs import follow, settle
from tests.cli.test_resume import RUNS
from tests.runs import plan
from tests.steps.test_closed_branch import ISLAND


def follow_with(run, path, workers):
    execute(plan(run), path, workers=workers)
    return path.read_bytes()


def watch(monkeypatch):
    """Return what lists the directions that were followed apart and taken in."""
    taken, take_in = [], continuation._Branch.take_in

    def watched(self, followed):
        taken.append(len(followed.rows))
        return take_in(self, followed)

    monkeypatch.setattr(continuation._Branch, "take_in", watched)
    return taken


@pytest.mark.parametrize("name", RUNS)
def test_the_file_is_the_same_byte_for_byte(monkeypatch, tmp_path, name):
    alone = follow_with(RUNS[name], tmp_path / "a.h5", 1)
    taken = watch(monkeypatch)
    assert follow_with(RUNS[name], tmp_path / "b.h5", 2) == alone
    assert len(taken) == 1 and taken[0] > 3


def test_where_the_other_process_is_lost_its_work_is_done_here(monkeypatch, tmp_path):
    alone = follow_with(RUNS["smooth"], tmp_path / "a.h5", 1)
    monkeypatch.setattr(other_process.sys, "executable", "/bin/false")
    taken = watch(monkeypatch)
    assert follow_with(RUNS["smooth"], tmp_path / "b.h5", 2) == alone
    assert len(taken) == 1


def test_a_branch_that_closes_needs_no_other_direction(monkeypatch, tmp_path):
    run = {**ISLAND, "run": {"steps": [*settle(100), follow("c", "o", {"m": [-1, 1]})]}}
    alone = follow_with(run, tmp_path / "a.h5", 1)
    taken = watch(monkeypatch)
    assert follow_with(run, tmp_path / "b.h5", 2) == alone
    assert not taken and len(read_results(tmp_path / "b.h5").step("c").endings) == 2


def test_what_goes_wrong_apart_is_told_after_the_points_before_it(monkeypatch, tmp_path):
    """An error of the program on the way down, after some points."""
    record = continuation._Branch.record

    def fail(self, point):
        if point.state.arclength < -0.1:
            raise ConvergenceError("nothing goes on from here")
        record(self, point)

    monkeypatch.setattr(continuation._Branch, "record", fail)
    # The other process knows nothing of this: the work is done here.
    monkeypatch.setattr(other_process.sys, "executable", "/bin/false")
    lengths = []
    for workers in (1, 2):
        with pytest.raises(ConvergenceError, match="nothing goes on"):
            follow_with(RUNS["smooth"], tmp_path / f"{workers}.h5", workers)
        step = read_results(tmp_path / f"{workers}.h5").step("branch")
        lengths.append(sorted(step.points["arclength"]))
    assert lengths[0] == lengths[1] and lengths[0][0] < 0.0


def test_an_error_keeps_its_places_on_its_way_from_another_process():
    with begin_apart(Workers(2), RunError.at, "a.yaml:1") as wait, pytest.raises(TypeError):
        wait()
    with begin_apart(Workers(2), make_error, "m.yaml") as wait:
        error = wait()
    assert str(error) == str(make_error("m.yaml")) and error.problems == make_error("m.yaml").problems


def make_error(path):
    return RunError.at(path, 3, 4, "is wrong")


def test_a_result_comes_from_another_process():
    with begin_apart(Workers(2), math.sqrt, 2.0) as wait:
        assert wait() == math.sqrt(2.0)
    with begin_apart(Workers(2), find_process, None) as wait:
        assert wait() != os.getpid()


def find_process(_):
    return os.getpid()


def test_modules_of_the_folder_it_runs_in_are_none_of_its_own(monkeypatch, tmp_path):
    """A file beside the model named like a module must not be run."""
    (tmp_path / "pickle.py").write_text("raise SystemExit('run by mistake')")
    (tmp_path / "numpy.py").write_text("raise SystemExit('run by mistake')")
    monkeypatch.chdir(tmp_path)
    with begin_apart(Workers(2), find_process, None) as wait:
        assert wait() != os.getpid()


KILLED = """
import subprocess, time
from pddecont.simulate import Workers, begin_apart, other_process

class Told(subprocess.Popen):
    def __init__(self, *args, **options):
        super().__init__(*args, **options)
        print(self.pid, flush=True)

other_process.subprocess.Popen = Told
with begin_apart(Workers(2), time.sleep, 600):
    time.sleep(600)
"""


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="processes are looked for in /proc")
def test_the_other_process_ends_with_one_that_is_killed():
    with subprocess.Popen([sys.executable, "-c", KILLED], stdout=subprocess.PIPE, text=True) as process:
        pid = int(process.stdout.readline())
        time.sleep(1.0)
        assert is_running(pid)
        process.kill()
    deadline = time.monotonic() + 20
    while is_running(pid) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not is_running(pid)


def is_running(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False
