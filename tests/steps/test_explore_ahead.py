"""Leads that are followed elsewhere before their turn: the same file to the last bit and the same words."""

from concurrent.futures import Future
from dataclasses import replace

import numpy as np
import pytest

from pddecont.errors import ConvergenceError, Problem, ResultsError, RunError
from pddecont.results import read_results
from pddecont.simulate import Elsewhere
from pddecont.steps import Budget
from pddecont.steps.execution import execute, explore_ahead
from pddecont.steps.execution.log import Message, Opened
from pddecont.steps.execution.renaming import rename
from tests.runs import plan
from tests.steps.test_early_steps import do, leave_out_points
from tests.steps.test_explore import BALL, holds_same

# Folds of x at b = 2 (a/3)^(3/2) and its opposite, and beside them a Hopf point of y and z at b = 0.2 a.
PLANE = {
    "name": "folds_and_hopf",
    "states": ["x", "y", "z"],
    "parameters": {"b": 0, "a": 1},
    "definitions": {"r": "y**2 + z**2"},
    "modes": {"m": {"x'": "b + a*x - x**3", "y'": "(b - 0.2*a - r)*y - z", "z'": "(b - 0.2*a - r)*z + y"}},
    "run": {"steps": [{"name": "all", "explore": {"over": {"b": [-1, 1], "a": [0.5, 1.5]}, "starts": 4, "check": 4}}]},
}
RUNS = {"branches": BALL, "curves": PLANE}


@pytest.fixture
def taken(monkeypatch):
    """Return what lists the steps of each lead that was followed before its turn and taken in.

    Processes that only just start are waited for.
    """
    found, take = [], explore_ahead.LeadsAhead.take

    def watched(self, lead, steps):
        computed = take(self, lead, steps)
        found.extend([list(computed)] if computed else [])
        return computed

    monkeypatch.setattr(explore_ahead.LeadsAhead, "take", watched)
    monkeypatch.setattr(Elsewhere, "take_back", lambda self, future: False)
    return found


@pytest.mark.parametrize("name", RUNS)
@pytest.mark.parametrize("workers", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_the_file_and_the_words_are_the_same(taken, name, workers, tmp_path):
    alone, words = do(RUNS[name], tmp_path / "a.h5", 1)
    assert not taken
    data, heard = do(RUNS[name], tmp_path / "b.h5", workers)
    assert data == alone
    assert leave_out_points(heard) == leave_out_points(words)
    kind = "curve" if name == "curves" else "branch"
    assert any(steps[-1].startswith(kind) for steps in taken)


@pytest.mark.parametrize("seconds", [0.0, None])
def test_leads_elsewhere_end_with_the_time_too(monkeypatch, seconds, tmp_path):
    """What is not computed then is computed here, or when the run is resumed."""
    execute(plan(BALL), tmp_path / "a.h5")
    tasks = []

    def begin(self, work, task):
        if work is not explore_ahead.compute_lead:
            return None
        tasks.append(task)
        future = Future()
        future.set_result(work(plan(BALL), replace(task, budget=Budget(seconds=seconds))))
        return future

    monkeypatch.setattr(Elsewhere, "begin", begin)
    monkeypatch.setattr(Elsewhere, "take_back", lambda self, future: False)
    execute(plan(BALL), tmp_path / "b.h5", workers=2)
    assert tasks
    assert holds_same(read_results(tmp_path / "b.h5"), read_results(tmp_path / "a.h5"))


def test_a_lead_whose_process_is_lost_is_followed_here(monkeypatch, tmp_path):
    execute(plan(BALL), tmp_path / "a.h5")
    lost = []

    def wait(self, future):
        lost.append(future.result())

    monkeypatch.setattr(Elsewhere, "wait", wait)
    execute(plan(BALL), tmp_path / "b.h5", workers=2)
    assert lost
    assert (tmp_path / "b.h5").read_bytes() == (tmp_path / "a.h5").read_bytes()


def test_all_texts_of_a_log_get_other_names():
    names = {"lead_1_orbit": "orbit_7"}
    opened = Opened("orbit", {"settings": '{"from": "lead_1_orbit"}', "n": 3, "values": np.ones(2)}, {"capacity": 1})
    renamed = rename([opened, Message("step", ("lead_1_orbit", "orbit"))], names)
    assert renamed[0].meta["settings"] == '{"from": "orbit_7"}'
    assert renamed[0].meta["values"] is opened.meta["values"]
    assert renamed[1] == Message("step", ("orbit_7", "orbit"))


@pytest.mark.parametrize(
    "error",
    [
        ConvergenceError("step 'x': none", [1.0, 0.5]),
        ResultsError("step 'x' holds no orbits"),
        RunError([Problem("a.yaml", 3, 1, "step 'x': no")]),
    ],
)
def test_an_error_keeps_all_but_the_name(error):
    renamed = rename(error, {"x": "branch_2"})
    assert type(renamed) is type(error)
    assert str(renamed) == str(error).replace("'x'", "'branch_2'")
    assert getattr(renamed, "history", None) == getattr(error, "history", None)
    assert [p.line for p in getattr(renamed, "problems", ())] == [p.line for p in getattr(error, "problems", ())]
