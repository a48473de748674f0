"""Many runs at once, exit codes, JSON, threads, and the same numbers every time."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest

from pddecont.results import read_results
from pddecont.steps.execution import execute
from tests.conftest import ROOT
from tests.faults.runs import plan_of, run_of, text_of
from tests.runs import change, to_yaml

COMMAND = [sys.executable, "-m", "pddecont"]


def run(folder, *args, **environment):
    done = subprocess.run(
        [*COMMAND, *args],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
    )
    return done.returncode, done.stdout, done.stderr


def test_fifty_runs_at_once_in_one_folder(tmp_path, tally):
    (tmp_path / "quick.yaml").write_text(text_of("simulate"))
    walls = [f"{0.15 + 0.002 * k:.3f}" for k in range(50)]
    one = f"{sys.executable} -m pddecont run quick.yaml --set wall={{}} -o wall_{{}}.h5 --json > wall_{{}}.json"
    done = subprocess.run(
        ["xargs", "-P", "8", "-I", "{}", "sh", "-c", one],
        input="\n".join(walls),
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"},
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    for wall in walls:
        data = json.loads((tmp_path / f"wall_{wall}.json").read_text())
        assert data["output"] == f"wall_{wall}.h5"
        assert data["steps"][0]["done"]
        step = read_results(tmp_path / f"wall_{wall}.h5").step("last")
        assert step.points["parameters"][0][step.meta["parameters"].index("wall")] == float(wall)
    assert not [p.name for p in tmp_path.iterdir() if p.name.startswith(".")]
    tally("batch", "50 runs at once in one folder", "all done, each with its own numbers")


def test_runs_at_once_on_one_file_leave_one_of_them(tmp_path, tally):
    (tmp_path / "quick.yaml").write_text(text_of("sweep"))
    runs = [
        subprocess.Popen(
            [*COMMAND, "run", "quick.yaml", "-o", "q.h5", "-q"],
            cwd=tmp_path,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
        )
        for _ in range(4)
    ]
    ends = [(process.communicate()[1], process.returncode) for process in runs]
    assert sorted(code for _, code in ends) == [0, 1, 1, 1]
    assert all("being written by another run" in err or "exists already" in err for err, code in ends if code)
    execute(plan_of("sweep"), tmp_path / "whole.h5")
    assert read_results(tmp_path / "q.h5").step("last").points["period"].tobytes() == (
        read_results(tmp_path / "whole.h5").step("last").points["period"].tobytes()
    )
    tally("batch", "4 runs at once on one file", "one writes, three are refused")


LONG = to_yaml(change(run_of("sweep"), "run.steps.0.sweep.over.wall", [0.15, 0.3, 4000]))
SHORT = {"t_end": 7, "rtol": 1e-6, "atol": 1e-8}
FAILS = to_yaml(change(run_of("orbit"), "run.steps.0.simulate", SHORT))


@pytest.mark.parametrize(
    ("text", "args", "code"),
    [(text_of("simulate"), [], 0), ("name: m", [], 1), (text_of("simulate"), ["--set", "wall"], 2), (FAILS, [], 3)],
)
def test_exit_codes_and_json(tmp_path, text, args, code, tally):
    (tmp_path / "quick.yaml").write_text(text)
    found, out, err = run(tmp_path, "run", "quick.yaml", "-o", "q.h5", "--json", *args)
    assert found == code, err
    if code:
        assert out == ""
        assert err
    else:
        assert json.loads(out)["steps"][0]["name"] == "last"
        assert err == ""
    tally("batch", f"exit code {code}", "as documented")


def test_exit_code_of_an_interruption_and_its_json(tmp_path, tally):
    (tmp_path / "quick.yaml").write_text(LONG)
    process = subprocess.Popen(
        [*COMMAND, "run", "quick.yaml", "-o", "q.h5", "--json"],
        cwd=tmp_path,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    until = time.monotonic() + 120
    while not ((tmp_path / "q.h5").exists() and len(read_results(tmp_path / "q.h5").steps)):
        assert time.monotonic() < until
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=30)
    assert (process.returncode, out) == (130, "")
    assert "--resume" in err
    tally("batch", "exit code 130", "as documented")


def most_threads(folder, *args, **environment):
    """Return the largest number of threads that a run has had."""
    process = subprocess.Popen(
        [*COMMAND, "run", "quick.yaml", "-o", "q.h5", "--overwrite", "-q", *args],
        cwd=folder,
        env={
            **{k: v for k, v in os.environ.items() if not k.endswith("_NUM_THREADS")},
            "PYTHONPATH": str(ROOT),
            **environment,
        },
    )
    most = 0
    while process.poll() is None:
        try:
            most = max(most, len(os.listdir(f"/proc/{process.pid}/task")))
        except FileNotFoundError:
            break
        time.sleep(0.002)
    assert process.wait() == 0
    return most


@pytest.mark.skipif(not os.path.isdir("/proc/self/task"), reason="threads are counted in /proc")
def test_threads_are_those_asked_for(tmp_path, tally):
    (tmp_path / "quick.yaml").write_text(text_of("sweep"))
    # The main thread and the one that waits for signals.
    alone = most_threads(tmp_path)
    assert alone == 2
    assert most_threads(tmp_path, "--workers", "3") == 5
    assert most_threads(tmp_path, OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1") == 2
    if (os.cpu_count() or 1) > 1:
        assert most_threads(tmp_path, OMP_NUM_THREADS="2") > 2
    tally("batch", "--workers and OMP_NUM_THREADS", "as many threads as asked for; one without")


@pytest.mark.parametrize("kind", ["continue", "sweep", "basin"])
def test_the_same_input_gives_the_same_file(tmp_path, kind, tally):
    (tmp_path / "quick.yaml").write_text(text_of(kind))
    for name, options in (("a", []), ("b", []), ("c", ["--workers", "2"])):
        assert run(tmp_path, "run", "quick.yaml", "-o", f"{name}.h5", "-q", *options)[0] == 0
    files = [(tmp_path / f"{name}.h5").read_bytes() for name in "abc"]
    assert files[0] == files[1] == files[2]
    tally("batch", f"{kind} twice, and with two workers", "the same file, byte for byte")
