"""Both directions of a branch at once: the same file as one after the other, whatever becomes of the other process."""

from concurrent.futures import Future
from dataclasses import replace

import pytest

from pddecont.errors import ConvergenceError
from pddecont.results import read_results
from pddecont.simulate import Elsewhere, other_process
from pddecont.steps import Budget
from pddecont.steps.execution import apart, continuation, execute
from pddecont.steps.execution.explore_ahead import LeadsAhead
from tests.bifurcation.runs import follow, settle
from tests.cli.test_resume import RUNS
from tests.runs import add_step, change, plan
from tests.steps.test_closed_branch import ISLAND
from tests.steps.test_explore import holds_same


def follow_with(run, path, workers):
    execute(plan(run), path, workers=workers)
    return path.read_bytes()


@pytest.fixture
def taken(monkeypatch):
    """Return what lists the directions that were followed elsewhere and taken in: points, or None of one lost.

    Processes that only just start are waited for.
    """
    found, wait = [], Elsewhere.wait

    def watched(self, future):
        result = wait(self, future)
        if result is None or isinstance(result, apart.FollowedDirection):
            found.append(result and len(result.rows))
        return result

    monkeypatch.setattr(Elsewhere, "wait", watched)
    monkeypatch.setattr(Elsewhere, "take_back", lambda self, future: False)
    return found


EQUILIBRIA = {
    "name": "brusselator",
    "states": ["x", "y"],
    "parameters": {"a": 1, "b": 1.6},
    "modes": {"m": {"x'": "a - (b + 1)*x + x**2*y", "y'": "b*x - x**2*y"}},
    "run": {
        "steps": [
            {"name": "rest", "equilibrium": {"from": {"x": 1, "y": 1.6}}},
            {"name": "branch", "continue": {"from": "rest", "free": ["b"], "range": {"b": [0.5, 3]}}},
        ]
    },
}
EQUILIBRIUM_CURVE = add_step(
    change(EQUILIBRIA, "run.steps.1.name", "first"),
    {
        "name": "branch",
        "continue": {
            "from": {"step": "first", "point": "HB1"},
            "free": ["b", "a"],
            "range": {"b": [0.5, 4], "a": [0.5, 1.5]},
        },
    },
)
ALL = {**RUNS, "equilibria": EQUILIBRIA, "curve of Hopf points": EQUILIBRIUM_CURVE}
EXPLORED = {
    "model": "bouncing_ball",
    "steps": [{"name": "all", "explore": {"over": {"G": [0.3, 1.2]}, "starts": 4, "check": 4, "depth": 1}}],
}


@pytest.mark.parametrize("name", ALL)
def test_the_file_is_the_same_byte_for_byte(taken, tmp_path, name):
    alone = follow_with(ALL[name], tmp_path / "a.h5", 1)
    assert follow_with(ALL[name], tmp_path / "b.h5", 2) == alone
    # In a curve's run the branch that it starts from has two directions too, unless it goes up alone.
    assert len(taken) == (2 if name == "curve of Hopf points" else 1)
    assert all(n > 3 for n in taken)


def test_branches_that_an_exploration_plans_are_followed_both_ways_at_once(taken, monkeypatch, tmp_path):
    # No whole branches before their turn.
    monkeypatch.setattr(LeadsAhead, "_begin_all", lambda self: None)
    alone = follow_with(EXPLORED, tmp_path / "a.h5", 1)
    assert not taken
    assert follow_with(EXPLORED, tmp_path / "b.h5", 2) == alone
    branches = [name for name in read_results(tmp_path / "b.h5").names if name.startswith("branch")]
    assert len(taken) >= len(branches) > 1


class Clock(Budget):
    """A budget whose time is over from when it is said to be."""

    now_over = False

    @property
    def is_over(self):
        return Clock.now_over


def test_a_direction_elsewhere_ends_with_the_time_too(monkeypatch, tmp_path):
    """What it found until then is kept, and resumed."""
    follow_with(EXPLORED, tmp_path / "a.h5", 1)
    begun = []

    def begin(self, work, task):
        if work is not apart.follow_apart or begun:
            return None
        begun.append(Future())
        begun[0].set_result(work(plan(EXPLORED), replace(task, budget=Budget(seconds=0.0))))
        return begun[0]

    def wait(self, future):
        monkeypatch.setattr(Clock, "now_over", True)
        return future.result()

    monkeypatch.setattr(Elsewhere, "begin", begin)
    monkeypatch.setattr(Elsewhere, "wait", wait)
    path = tmp_path / "b.h5"
    execute(plan(EXPLORED), path, workers=2, budget=Clock())
    assert not read_results(path).steps["all"].done
    assert len(begun[0].result().rows) >= 1
    execute(plan(EXPLORED), path, resume=True)
    assert holds_same(read_results(path), read_results(tmp_path / "a.h5"))


def test_where_the_other_process_is_lost_its_work_is_done_here(monkeypatch, taken, tmp_path):
    alone = follow_with(RUNS["smooth"], tmp_path / "a.h5", 1)
    monkeypatch.setattr(other_process.sys, "executable", "/bin/false")
    assert follow_with(RUNS["smooth"], tmp_path / "b.h5", 2) == alone
    assert taken == [None]


def test_a_branch_that_closes_needs_no_other_direction(taken, tmp_path):
    run = {**ISLAND, "run": {"steps": [*settle(100), follow("c", "o", {"m": [-1, 1]})]}}
    alone = follow_with(run, tmp_path / "a.h5", 1)
    assert follow_with(run, tmp_path / "b.h5", 2) == alone
    assert not taken and len(read_results(tmp_path / "b.h5").step("c").endings) == 2


def test_what_goes_wrong_is_told_after_the_points_before_it(monkeypatch, tmp_path):
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
