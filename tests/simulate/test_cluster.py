"""A run on a real Dask cluster: directions and steps at once, a sweep whose worker is lost in mid-run."""

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from pddecont.results import read_results
from pddecont.tables import describe_endings
from tests.cli.test_resume import SMOOTH
from tests.conftest import ROOT
from tests.runs import change, to_yaml
from tests.steps.test_early_steps import RUN as EARLY

pytest.importorskip("distributed")
RUN = {
    "model": f"{ROOT}/models/impact_oscillator.yaml",
    "steps": [
        {
            "name": "diagram",
            "sweep": {
                "over": {"K": [0.05, 0.2, 121]},
                "initial": [{"x": 0}, {"x": -0.26, "v": 1.74}],
                "transient": "500*2*pi/omega",
            },
        }
    ],
}


@pytest.fixture
def processes():
    started = []
    yield started
    for process in started:
        if process.poll() is None:
            process.kill()
        process.wait()


def start(processes, *arguments, log):
    with open(log, "w") as stream:
        process = subprocess.Popen([sys.executable, "-m", *arguments], stdout=stream, stderr=stream)
    processes.append(process)
    return process


def wait_for(condition, seconds, what):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        found = condition()
        if found:
            return found
        time.sleep(0.05)
    pytest.fail(f"{what} took longer than {seconds} s")
    return None


def rows(path):
    try:
        return len(read_results(path).steps["diagram"])
    except Exception:
        return 0


def start_cluster(processes, folder):
    """Return the address of a scheduler with two workers, and the workers."""
    address_file = folder / "scheduler.json"
    start(
        processes,
        "distributed.cli.dask_scheduler",
        "--host",
        "127.0.0.1",
        "--port",
        "0",
        "--no-dashboard",
        "--scheduler-file",
        str(address_file),
        log=folder / "scheduler.log",
    )
    wait_for(address_file.exists, 60, "the scheduler")
    workers = [
        start(
            processes,
            "distributed.cli.dask_worker",
            "--scheduler-file",
            str(address_file),
            "--nthreads",
            "1",
            "--no-nanny",
            "--no-dashboard",
            "--local-directory",
            str(folder),
            log=folder / f"worker{k}.log",
        )
        for k in range(2)
    ]
    for k in range(2):
        wait_for(lambda k=k: "Registered to" in (folder / f"worker{k}.log").read_text(), 60, "a worker")
    return json.loads(address_file.read_text())["address"], workers


@pytest.mark.parametrize("run", [SMOOTH, EARLY], ids=["both directions of a branch", "steps of many kinds"])
def test_what_does_not_depend_on_each_other_is_computed_at_once(tmp_path, processes, run):
    (tmp_path / "run.yaml").write_text(to_yaml(run))
    command = [sys.executable, "-m", "pddecont", "run", str(tmp_path / "run.yaml"), "-q", "-o"]
    subprocess.run([*command, str(tmp_path / "serial.h5")], check=True, timeout=200)
    address, _ = start_cluster(processes, tmp_path)
    subprocess.run([*command, str(tmp_path / "cluster.h5"), "--scheduler", address], check=True, timeout=200)
    assert (tmp_path / "cluster.h5").read_bytes() == (tmp_path / "serial.h5").read_bytes()


def test_a_lost_worker_changes_nothing(tmp_path, processes):
    (tmp_path / "run.yaml").write_text(to_yaml(RUN))
    command = [sys.executable, "-m", "pddecont", "run", str(tmp_path / "run.yaml"), "-q", "-o"]
    subprocess.run([*command, str(tmp_path / "serial.h5")], check=True, timeout=200)
    address, workers = start_cluster(processes, tmp_path)
    with open(tmp_path / "run.log", "w") as log:
        run = subprocess.Popen([*command, str(tmp_path / "cluster.h5"), "--scheduler", address], stderr=log)
    processes.append(run)
    wait_for(lambda: rows(tmp_path / "cluster.h5") > 4, 100, "the first results")
    assert run.poll() is None, "the run was over before a worker could be ended"
    os.kill(workers[0].pid, signal.SIGKILL)
    workers[0].wait()
    assert run.wait(timeout=200) == 0, (tmp_path / "run.log").read_text()
    serial, cluster = (read_results(tmp_path / name).steps["diagram"] for name in ("serial.h5", "cluster.h5"))
    assert describe_endings(cluster) == describe_endings(serial)
    for group in ("points", "orbits"):
        for key, column in getattr(serial, group).items():
            assert np.array_equal(column, getattr(cluster, group)[key], equal_nan=column.dtype.kind == "f"), key


def test_a_scheduler_that_does_not_answer_is_named(tmp_path):
    (tmp_path / "run.yaml").write_text(to_yaml(change(RUN, "steps.0.sweep.over.K", [0.05, 0.2, 2])))
    done = subprocess.run(
        [
            sys.executable,
            "-m",
            "pddecont",
            "run",
            str(tmp_path / "run.yaml"),
            "-q",
            "-o",
            str(tmp_path / "a.h5"),
            "--scheduler",
            "tcp://127.0.0.1:1",
        ],
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
    )
    assert done.returncode == 1
    assert "no Dask scheduler answers there" in done.stderr
    assert "Traceback" not in done.stderr
