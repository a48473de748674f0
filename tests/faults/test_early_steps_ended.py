"""A run whose steps are computed in other processes, ended at random instants: no process is left, --resume goes on."""

import random
import signal
import time
from contextlib import suppress
from pathlib import Path

import pytest

from pddecont.results import read_results
from pddecont.steps.execution import execute
from tests.cli.test_cli import call
from tests.faults.runs import is_beginning, start_run
from tests.faults.test_interrupt import MESSAGE
from tests.runs import change, plan, to_yaml
from tests.steps.test_early_steps import RUN, STEPS

# Long enough for other processes to have begun: the first motion is integrated for some seconds.
LONG = change(change(RUN, "run.steps", STEPS[:9]), "run.steps.0.simulate.t_end", 4000)


def find_others(pid):
    """Return the processes that one has started."""
    found = []
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        with suppress(FileNotFoundError, ProcessLookupError):  # a thread that has ended meanwhile
            found += task.read_text().split()
    return {int(number) for number in found}


def is_running(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Return the run's file on one worker, and how long the run takes."""
    path = tmp_path_factory.mktemp("whole") / "whole.h5"
    began = time.monotonic()
    execute(plan(LONG), path)
    return path, time.monotonic() - began


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="processes are looked for in /proc")
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGKILL, -9)])
def test_no_process_is_left_and_the_run_goes_on(tmp_path, whole, number, code, tally):
    (tmp_path / "run.yaml").write_text(to_yaml(LONG))
    rng, seen = random.Random(int(number)), set()
    path, seconds = tmp_path / "a.h5", whole[1]
    while not seen:
        path.unlink(missing_ok=True)
        with start_run(tmp_path, tmp_path / "run.yaml", "-o", path, "--workers", 2) as process:
            time.sleep(rng.uniform(0.3, 1.0) * seconds)
            others = find_others(process.pid)
            process.send_signal(number)
            err = process.communicate(timeout=20)[1]
        if process.returncode == 0:  # too fast for this instant
            continue
        seen |= others
        assert process.returncode == code, err
        assert "Traceback" not in err
        assert number == signal.SIGKILL or err.splitlines()[-1] == MESSAGE
    deadline = time.monotonic() + 20
    while any(map(is_running, seen)) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not any(map(is_running, seen))
    recorded = read_results(path).steps if path.exists() else {}
    assert all(is_beginning(step, read_results(whole[0]).steps[name]) for name, step in recorded.items())
    assert call("run", tmp_path / "run.yaml", "-o", path, "--resume", "-q", "--workers", "2")[0] == 0
    assert [step.name for step in read_results(path).steps.values()] == [step["name"] for step in STEPS[:9]]
    alone = tmp_path / "b.h5"
    assert call("run", tmp_path / "run.yaml", "-o", alone, "-q")[0] == 0
    assert path.read_bytes() == alone.read_bytes()
    tally("faults", f"{number.name} while steps are computed in two processes", "no process is left, the same file", 1)
