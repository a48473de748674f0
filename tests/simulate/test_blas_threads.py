"""Linear algebra in Python: one thread while a run goes on, as many as before when all runs have ended."""

import os
import pickle
import subprocess
import sys
import threading

import pytest
from threadpoolctl import threadpool_info

from pddecont.simulate import blas_threads
from pddecont.simulate.other_process import OtherProcess
from tests.conftest import ROOT

COUNTS = """
import threading
import numpy, scipy.linalg
from threadpoolctl import threadpool_info, threadpool_limits
import pddecont
from pddecont.errors import PddecontError
from pddecont.steps import Silent

class Count(Silent):
    def step(self, name, kind):
        seen.append(count())

def count():
    return {found["num_threads"] for found in threadpool_info() if found["user_api"] == "blas"}

seen = []
model = {"name": "m", "states": ["x"], "modes": {"only": {"x'": "-x"}}, "initial": {"x": 1}}
threadpool_limits(3, user_api="blas")
run = lambda t_end: pddecont.run(model, steps=[{"name": "fall", "simulate": {"t_end": t_end}}], reporter=Count())
run(1)
try:
    run(-1)
except PddecontError:
    pass
print(seen, count())
"""


def count_threads(**settings):
    pytest.importorskip("threadpoolctl")
    bare = {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")}
    done = subprocess.run(
        [sys.executable, "-c", COUNTS],
        capture_output=True,
        text=True,
        env={**bare, "PYTHONPATH": str(ROOT), **settings},
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_a_run_has_one_thread_and_leaves_what_was_set():
    assert count_threads() == "[{1}] {3}"


@pytest.mark.parametrize("name", ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"])
def test_what_the_user_has_chosen_stands(name):
    assert count_threads(**{name: "2"}) == "[{3}] {3}"


def test_the_last_of_several_runs_gives_the_limit_back(monkeypatch):
    for name in blas_threads.CHOSEN:
        monkeypatch.delenv(name, raising=False)
    events = []

    class Lent:
        def restore_original_limits(self):
            events.append("restored")

    monkeypatch.setattr(blas_threads, "_set_limit", lambda: events.append("set") or Lent())
    inside, leave = threading.Event(), threading.Event()

    def hold():
        with blas_threads.lend_one_thread():
            inside.set()
            leave.wait(60)

    other = threading.Thread(target=hold)
    with blas_threads.lend_one_thread():
        other.start()
        assert inside.wait(60)
    assert events == ["set"]
    leave.set()
    other.join()
    assert events == ["set", "restored"]


@pytest.mark.parametrize(("chosen", "number"), [({}, 1), ({"OPENBLAS_NUM_THREADS": "2"}, 2)])
def test_a_process_that_computes_for_this_one_has_as_many_threads(monkeypatch, chosen, number):
    for name in blas_threads.CHOSEN:
        monkeypatch.delenv(name, raising=False)
    for name, value in chosen.items():
        monkeypatch.setenv(name, value)
    process = OtherProcess(pickle.dumps(None))
    try:
        process.make_ready()
        assert process.ask(count_threads_there, None) == {number}
    finally:
        process.kill()
        process.close()


def count_threads_there(shared, task):
    import scipy.linalg

    assert scipy.linalg.lapack is not None, "its libraries are loaded"
    return {found["num_threads"] for found in threadpool_info() if found["user_api"] == "blas"}
