"""Two runs on one file: the second is refused at once; readers may look on."""

import fcntl
import json
import multiprocessing
import os
import re
import signal
import subprocess
import sys
import time

import pytest

from pddecont.errors import ResultsError
from pddecont.results import StepWriter, hold_lock, read_results
from pddecont.steps.execution import execute
from tests.cli.test_cli import call
from tests.conftest import ROOT
from tests.faults.runs import contents, is_beginning, plan_of, text_of


@pytest.mark.parametrize("option", ["--resume", "--overwrite", "-q"])
def test_a_second_run_is_refused_and_the_first_goes_on(tmp_path, monkeypatch, option, tally):
    (tmp_path / "quick.yaml").write_text(text_of("continue"))
    execute(plan_of("continue"), tmp_path / "whole.h5")
    append, seen = StepWriter.append, []

    def meanwhile(self, *rows):
        append(self, *rows)
        if len(seen) < 3:
            before = (tmp_path / "q.h5").read_bytes()
            seen.append(call("run", tmp_path / "quick.yaml", "-o", tmp_path / "q.h5", option))
            assert (tmp_path / "q.h5").read_bytes() == before

    with monkeypatch.context() as patch:
        patch.setattr(StepWriter, "append", meanwhile)
        execute(plan_of("continue"), tmp_path / "q.h5")
    assert [(code, out) for code, out, _ in seen] == [(1, "")] * 3
    assert all(f"is being written by another run (process {os.getpid()})" in err for _, _, err in seen)
    assert contents(tmp_path / "q.h5") == contents(tmp_path / "whole.h5")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["q.h5", "quick.yaml", "whole.h5"]
    tally("faults", f"second run on the same file, {option}", "refused, the first goes on")


def test_a_lock_file_that_a_killed_run_left_is_in_nobody_s_way(tmp_path):
    (tmp_path / ".q.h5.lock").write_text("123")
    (tmp_path / ".q.h5.part").write_bytes(b"half a file")
    execute(plan_of("simulate"), tmp_path / "q.h5")
    assert [p.name for p in tmp_path.iterdir()] == ["q.h5"]


def test_the_lock_of_a_killed_process_is_released(tmp_path, tally):
    path = tmp_path / "q.h5"
    code = f"""
from pathlib import Path
from pddecont.results import hold_lock
with hold_lock(Path({str(path)!r})):
    print(1, flush=True)
    input()
"""
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    with subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment
    ) as holder:
        assert holder.stdout.readline()
        held = f"{path} is being written by another run (process {holder.pid}); wait until it ends, or give another -o"
        with pytest.raises(ResultsError, match=re.escape(held)), hold_lock(path):
            pass
        holder.kill()
    assert holder.returncode == -signal.SIGKILL
    assert (tmp_path / ".q.h5.lock").read_text() == str(holder.pid)
    with hold_lock(path):
        assert (tmp_path / ".q.h5.lock").read_text() == str(os.getpid())
    assert list(tmp_path.iterdir()) == []
    tally("faults", "a process that holds the lock is killed", "the next run is let in")


def test_a_lock_file_is_not_followed_where_a_link_leads(tmp_path):
    (tmp_path / "precious").write_text("precious")
    for name in (".q.h5.lock", ".q.h5.part"):
        (tmp_path / name).symlink_to(tmp_path / "precious")
        if name.endswith("lock"):
            with pytest.raises(ResultsError, match="cannot be written"):
                execute(plan_of("simulate"), tmp_path / "q.h5")
            (tmp_path / name).unlink()
        else:
            execute(plan_of("simulate"), tmp_path / "q.h5")
    assert (tmp_path / "precious").read_text() == "precious"


def contend(path, log, number):
    """Take the lock so many times, in turns with others; write down whenever someone else holds it at the same time."""
    taken = 0
    while taken < number:
        try:
            with hold_lock(path), open(log, "a") as stream:
                try:
                    fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
                except BlockingIOError:
                    stream.write("two\n")
                stream.write("one\n")
                taken += 1
        except ResultsError:
            time.sleep(0.0)


def test_the_lock_is_never_held_twice(tmp_path):
    processes = [
        multiprocessing.get_context("spawn").Process(target=contend, args=(tmp_path / "q.h5", tmp_path / "log", 150))
        for _ in range(3)
    ]
    for process in processes:
        process.start()
    for process in processes:
        process.join()
        assert process.exitcode == 0
    lines = (tmp_path / "log").read_text().splitlines()
    assert lines == ["one"] * 450


def test_readers_may_look_on_while_a_run_writes(tmp_path, monkeypatch, tally):
    execute(plan_of("continue"), tmp_path / "whole.h5")
    whole, append, counts = read_results(tmp_path / "whole.h5"), StepWriter.append, []
    path = tmp_path / "q.h5"

    def watched(self, *rows):
        append(self, *rows)
        step = read_results(path).step(self.name)
        counts.append(len(step) == self.n and is_beginning(step, whole.steps[self.name]))
        if self.n == 5:
            assert json.loads(call("info", path, "--json")[1])["steps"][-1]["n_points"] == 5
            assert len(call("export", path)[1].splitlines()) == 6
            assert call("plot", path, "-o", tmp_path / "p.png")[0] == 0

    monkeypatch.setattr(StepWriter, "append", watched)
    execute(plan_of("continue"), path)
    assert len(counts) == sum(map(len, whole.steps.values()))
    assert all(counts)
    assert contents(path) == contents(tmp_path / "whole.h5")
    tally("faults", "info, export and plot while a run writes", "every finished point is read")
