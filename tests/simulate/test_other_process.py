"""Work in another process: its results and errors, what it may import, and that it ends with this one."""

import math
import os
import pickle
import subprocess
import sys
import time
from concurrent.futures import Future
from pathlib import Path

import pytest

from pddecont.errors import RunError
from pddecont.simulate import Workers, open_elsewhere, other_process
from pddecont.simulate.other_process import Lost, OtherProcess


@pytest.fixture
def process():
    """Return a process whose work shares a number."""
    made = OtherProcess(pickle.dumps(7))
    made.make_ready()
    yield made
    made.kill()
    made.close()


def test_results_come_one_after_another_and_share_what_was_sent_once(process):
    assert [process.ask(divmod, n) for n in (2, 3)] == [(3, 1), (2, 1)]
    assert process.ask(find_process, None) not in (os.getpid(), process.ask(math.gcd, 14))


def find_process(shared, task):
    return os.getpid()


def test_an_error_keeps_its_places_on_its_way_from_another_process(process):
    error = process.ask(make_error, "m.yaml")
    assert str(error) == str(make_error(7, "m.yaml")) and error.problems == make_error(7, "m.yaml").problems


def make_error(shared, path):
    return RunError.at(path, 3, 4, "is wrong")


def test_what_goes_wrong_there_is_left_to_this_process(process, capfd):
    with pytest.raises(Lost):
        process.ask(divmod, 0)
    with pytest.raises(Lost):
        process.ask(divmod, 1)
    assert capfd.readouterr().err == ""


def test_a_result_that_cannot_be_sent_is_lost(process):
    with pytest.raises(Lost):
        process.ask(make_what_cannot_be_sent, None)


def make_what_cannot_be_sent(shared, task):
    return lambda: None


def test_modules_of_the_folder_it_runs_in_are_none_of_its_own(monkeypatch, tmp_path):
    """A file beside the model named like a module must not be run."""
    (tmp_path / "pickle.py").write_text("raise SystemExit('run by mistake')")
    (tmp_path / "numpy.py").write_text("raise SystemExit('run by mistake')")
    monkeypatch.chdir(tmp_path)
    with open_elsewhere(Workers(2), None) as elsewhere:
        assert elsewhere.begin(find_process, None).result() != os.getpid()


def test_who_is_lost_is_replaced(monkeypatch):
    with open_elsewhere(Workers(2), 7) as elsewhere:
        with pytest.raises(Lost):
            elsewhere.begin(divmod, 0).result()
        assert elsewhere.begin(divmod, 2).result() == (3, 1)
    monkeypatch.setattr(other_process.sys, "executable", "/no/such/file")
    with open_elsewhere(Workers(2), 7) as elsewhere:
        assert elsewhere.wait(begin_slowly(elsewhere)) is None


def begin_slowly(elsewhere):
    """Begin a piece of work and wait until it runs, or has ended."""
    future = elsewhere.begin(divmod, 2)
    while not (future.running() or future.done()):
        time.sleep(0.01)
    return future


def test_no_more_is_begun_than_there_are_places():
    with open_elsewhere(Workers(2), 0.5) as elsewhere:
        elsewhere.slots.sit()
        first = elsewhere.begin(wait_for, None)
        assert isinstance(first, Future) and elsewhere.begin(wait_for, None) is None
        assert first.result() == 0.5
        elsewhere.slots.stand()


def wait_for(seconds, task):
    time.sleep(seconds)
    return seconds


def test_what_has_not_begun_is_taken_back():
    with open_elsewhere(Workers(2), 600) as elsewhere:
        # The process needs some time to start.
        assert elsewhere.wait(elsewhere.begin(wait_for, None)) is None


def test_what_is_being_done_ends_with_the_context():
    with open_elsewhere(Workers(3), 600) as elsewhere:
        futures = [elsewhere.begin(wait_for, None) for _ in range(2)]
        while not all(future.running() for future in futures):
            time.sleep(0.01)
    # What is waited for would have a result.
    assert all(isinstance(future.exception(), Lost) for future in futures)


KILLED = """
import subprocess, time
from pddecont.simulate import Workers, open_elsewhere, other_process
from tests.simulate.test_other_process import wait_for

class Told(subprocess.Popen):
    def __init__(self, *args, **options):
        super().__init__(*args, **options)
        print(self.pid, flush=True)

other_process.subprocess.Popen = Told
with open_elsewhere(Workers(2), 600) as elsewhere:
    elsewhere.begin(wait_for, None)
    time.sleep(600)
"""


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="processes are looked for in /proc")
def test_the_other_process_ends_with_one_that_is_killed():
    with subprocess.Popen([sys.executable, "-c", KILLED], stdout=subprocess.PIPE, text=True) as process:
        pid = int(process.stdout.readline())
        time.sleep(2.0)
        assert is_running(pid)
        process.kill()
    assert has_ended(pid)


def has_ended(pid):
    """Return whether a process ends within some time."""
    deadline = time.monotonic() + 20
    while is_running(pid) and time.monotonic() < deadline:
        time.sleep(0.05)
    return not is_running(pid)


def is_running(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False
