"""Ctrl-C and SIGTERM at random instants: a clean end, a message, the exit code, a file that --resume goes on with."""

import contextlib
import random
import signal
import subprocess
import sys
import time

import pytest

from pddecont.cli.interrupt import end_on_signals
from pddecont.errors import ResultsError
from pddecont.results import read_results
from pddecont.steps.execution import execute
from tests.cli.test_cli import call
from tests.conftest import ROOT
from tests.faults.runs import is_beginning, plan_of, run_of, start_run, text_of
from tests.faults.test_disk import same_numbers
from tests.runs import change, to_yaml

MESSAGE = "interrupted; what was finished is kept, and 'run' with --resume goes on from there"
# Minutes of machine code without a pause, in one motion and on two workers.
LONG = to_yaml(
    change(
        run_of("sweep"),
        "run.steps.0.sweep",
        {
            "over": {"wall": [0.15, 0.3, 100]},
            "transient": 1e9,
            "max_period": 1,
            "returns": 100000,
            "carry": "up",
            "section": {"zero": "x - 5"},
        },
    )
)
RUN = ("quick.yaml", "-o", "q.h5")
# Runs of which three are to be caught by a signal.
MOST_TRIED = 60


def wait_for_step(path, name):
    """Wait until a run has begun a step; the compiler may come first."""
    for _ in range(1200):
        with contextlib.suppress(ResultsError):
            if name in read_results(path).steps:
                return
        time.sleep(0.1)
    pytest.fail(f"step '{name}' has not begun after two minutes")


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_at_a_random_instant_is_a_clean_end(tmp_path, number, code, tally):
    (tmp_path / "quick.yaml").write_text(text_of("continue"))
    execute(plan_of("continue"), tmp_path / "whole.h5")
    whole, rng = read_results(tmp_path / "whole.h5"), random.Random(1)
    caught = tried = 0
    while caught < 3:
        tried += 1
        assert tried < MOST_TRIED, "every run was done before the signal came"
        (tmp_path / "q.h5").unlink(missing_ok=True)
        with start_run(tmp_path, *RUN) as process:
            time.sleep(rng.uniform(0.0, 0.6))
            ended = process.poll() is not None
            process.send_signal(number)
            out, err = process.communicate(timeout=20)
        if ended or process.returncode == 0:  # too fast for this instant: all of it is there
            assert same_numbers(tmp_path / "q.h5", tmp_path / "whole.h5"), err
            continue
        caught += 1
        assert process.returncode == code, err
        assert out == ""
        assert err.splitlines()[-1] == MESSAGE
        assert "Traceback" not in err
        for name, step in (read_results(tmp_path / "q.h5").steps if (tmp_path / "q.h5").exists() else {}).items():
            assert is_beginning(step, whole.steps[name])
        assert call("run", tmp_path / "quick.yaml", "-o", tmp_path / "q.h5", "--resume", "-q")[0] == 0
        assert same_numbers(tmp_path / "q.h5", tmp_path / "whole.h5")
    tally("faults", f"{number.name} at a random instant", f"exit {code}, --resume gives the same file", 3)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize(("model", "code"), [("wall_oscillator", 0), ("nothing.yaml", 1)])
def test_a_signal_that_comes_when_all_is_done_changes_nothing(tmp_path, number, model, code):
    # What is registered here runs when the program has returned and Python ends.
    late = f"import atexit, os, time; atexit.register(lambda: (os.kill(os.getpid(), {int(number)}), time.sleep(0.05)))"
    program = f"{late}\nimport sys; sys.argv[1:] = ['check', '{model}']\nfrom pddecont.cli import main\nmain()"
    done = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr
    assert MESSAGE not in done.stderr


def test_a_signal_on_the_way_out_is_told_or_changes_nothing():
    """The handler is called between the last line of the work and the end of the watch over it."""
    before = signal.getsignal(signal.SIGTERM)
    with end_on_signals() as received:
        handler = signal.getsignal(signal.SIGTERM)
    handler(signal.SIGTERM, None)
    assert received.number == 0
    assert signal.getsignal(signal.SIGTERM) is before


def test_integrations_are_interrupted_in_machine_code_without_harm(tally):
    number = 400
    done = subprocess.run(
        [sys.executable, "-X", "faulthandler", "-m", "tests.faults.interrupted", str(number), "1"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert int(done.stdout) == number
    tally("faults", "an integration interrupted within machine code", "one exception, the process goes on", number)


@pytest.mark.parametrize("workers", [1, 2])
def test_machine_code_and_workers_do_not_hold_a_signal_up(tmp_path, workers, tally):
    (tmp_path / "quick.yaml").write_text(LONG)
    with start_run(tmp_path, *RUN, "--workers", workers) as process:
        wait_for_step(tmp_path / "q.h5", "last")
        time.sleep(0.5)
        assert process.poll() is None
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=20)
    assert process.returncode == 130
    assert err.splitlines()[-1] == MESSAGE
    assert read_results(tmp_path / "q.h5").step("last").done is False
    tally("faults", f"Ctrl-C in machine code, {workers} worker(s)", "exit 130")


def test_a_second_signal_ends_the_program_on_the_spot(tmp_path):
    (tmp_path / "quick.yaml").write_text(LONG)
    with start_run(tmp_path, *RUN) as process:
        time.sleep(1.0)
        process.send_signal(signal.SIGINT)
        time.sleep(0.2)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=20)
    assert process.returncode == 130


def test_an_ignored_signal_stays_ignored(tmp_path):
    # As in a job that a script puts in the background.
    (tmp_path / "quick.yaml").write_text(text_of("simulate"))
    with start_run(tmp_path, *RUN, on_ctrl_c=signal.SIG_IGN) as process:
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
    assert process.returncode == 0
