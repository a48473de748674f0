"""Steps that do not depend on each other at once: the same file and the same words as one after another."""

import threading
from concurrent.futures import Future

import pytest

from pddecont.errors import ConvergenceError
from pddecont.results import read_results, writer
from pddecont.simulate import Elsewhere, other_process
from pddecont.steps import Sharing, list_step_kinds
from pddecont.steps.execution import all_steps, early, execute, one_step
from pddecont.steps.execution.log import step_from_log
from tests.cli.test_resume import SMOOTH
from tests.runs import add_step, change, plan
from tests.steps.test_directions_apart import EQUILIBRIA

BRANCH = {"step": {"max": 0.05}}
UP = {"free": ["alpha"], "range": {"alpha": [1.8, 2.4]}, "direction": "up", **BRANCH}
STEPS = [
    {"name": "transient", "simulate": {"t_end": 60}},
    {"name": "orbit", "orbit": {"from": "transient", "stability": True}},
    {"name": "branch", "continue": {"from": "orbit", **UP}},
    # These depend on nothing above, or on what itself is early.
    {"name": "other", "set": {"alpha": 1.9}, "simulate": {"t_end": 70, "record": {"signals": {"late": "x(t - tau)"}}}},
    {"name": "settled", "orbit": {"from": "other"}},
    {"name": "in_delay", "continue": {"from": "settled", "free": ["tau"], "range": {"tau": [0.9, 1.1]}, **BRANCH}},
    {"name": "rest", "equilibrium": {"from": {"x": 0}}},
    {"name": "rests", "continue": {"from": "rest", "free": ["alpha"], "range": {"alpha": [1, 3]}}},
    {
        "name": "hopf",
        "continue": {
            "from": {"step": "rests", "point": "HB1"},
            "free": ["alpha", "tau"],
            "range": {"alpha": [1, 3], "tau": [0.5, 2]},
        },
    },
    {
        "name": "born",
        "continue": {
            "from": {"step": "rests", "point": "HB1"},
            "branch": "switch",
            "free": ["alpha"],
            "range": {"alpha": [1.5, 1.7]},
        },
    },
    {"name": "sweep", "sweep": {"over": {"alpha": [1.6, 2, 3]}, "transient": 50, "section": {"zero": "x"}}},
    {"name": "again", "orbit": {"from": {"step": "branch", "index": 4}}},
]
RUN = change(SMOOTH, "run.steps", STEPS)


class Heard:
    """A reporter that keeps what it hears."""

    def __init__(self):
        self.messages = []

    def __getattr__(self, name):
        return lambda *values: self.messages.append((name, values))


@pytest.fixture
def early_steps(monkeypatch):
    """Return what lists the steps that were computed early and written.

    Processes that only just start are waited for.
    """
    found, write = [], early.write_computed

    def watched(context, step, computed):
        found.append(step.name)
        write(context, step, computed)

    monkeypatch.setattr(all_steps, "write_computed", watched)
    monkeypatch.setattr(Elsewhere, "take_back", lambda self, future: False)
    return found


def do(run, path, workers, **options):
    """Return the file of a run, and what was told."""
    heard = Heard()
    execute(plan(run), path, heard, workers=workers, **options)
    return path.read_bytes(), heard.messages


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Return the file of the run on one worker, and what was told."""
    return do(RUN, tmp_path_factory.mktemp("whole") / "a.h5", 1)


@pytest.mark.parametrize("workers", [2, 3])
def test_the_file_and_the_words_are_the_same(whole, early_steps, tmp_path, workers):
    data, messages = do(RUN, tmp_path / "b.h5", workers)
    assert data == whole[0]
    # Points of directions that are followed elsewhere are told at once.
    assert leave_out_points(messages) == leave_out_points(whole[1])
    assert {"other", "rest"} <= set(early_steps) and "sweep" not in early_steps
    assert early_steps == [step["name"] for step in STEPS if step["name"] in early_steps]


def test_a_step_is_the_same_before_it_is_written_and_as_it_is_read(monkeypatch, early_steps, tmp_path):
    """Steps that start from one that is not written yet start from what they would read."""
    write, compared = all_steps.write_computed, []

    def watched(context, step, computed):
        write(context, step, computed)
        made, read = step_from_log(step.name, computed.log), read_results(tmp_path / "b.h5").step(step.name)
        assert (made.kind, made.meta, made.endings, made.done) == (read.kind, read.meta, read.endings, read.done)
        for here, there in ((made.points, read.points), (made.orbits, read.orbits)):
            assert set(here) == set(there)
            assert all(here[key].dtype == there[key].dtype for key in here)
            assert all(here[key].shape == there[key].shape for key in here)
            assert all(here[key].tobytes() == there[key].tobytes() for key in here)
        compared.append(read.kind)

    monkeypatch.setattr(all_steps, "write_computed", watched)
    do(change(RUN, "run.steps", STEPS[:9]), tmp_path / "b.h5", 3)
    assert {"simulate", "equilibrium"} <= set(compared)


def leave_out_points(messages):
    return [message for message in messages if message[0] != "progress"]


def test_a_step_goes_on_from_one_that_is_computed_but_not_written(whole, early_steps, monkeypatch, tmp_path):
    """Nothing is written before all of the second motion's steps are computed."""
    computed, compute, do_here = {}, Elsewhere.begin, one_step.do_step
    all_there = threading.Event()

    def watched(self, work, task):
        future = compute(self, work, task)
        if future is not None and work is early.compute_step:
            computed[task.step] = future
            if task.step == "in_delay":
                future.add_done_callback(lambda _: all_there.set())
        return future

    def wait_first(context, step):
        if step.name == "transient":
            assert all_there.wait(100)
            assert not context.file.steps
        do_here(context, step)

    monkeypatch.setattr(Elsewhere, "begin", watched)
    monkeypatch.setattr(all_steps, "do_step", wait_first)
    assert do(RUN, tmp_path / "b.h5", 2)[0] == whole[0]
    assert early_steps[:3] == ["other", "settled", "in_delay"]


def test_steps_whose_processes_are_lost_are_done_here(whole, early_steps, monkeypatch, tmp_path):
    monkeypatch.setattr(other_process.sys, "executable", "/bin/false")
    assert do(RUN, tmp_path / "b.h5", 2)[0] == whole[0]
    assert not early_steps


def test_a_step_that_has_not_begun_when_its_turn_comes_is_done_here(monkeypatch, tmp_path):
    """No process is ever ready."""
    run = change(RUN, "run.steps", STEPS[:5])
    monkeypatch.setattr(other_process.OtherProcess, "make_ready", lambda self: self._process.wait())
    assert do(run, tmp_path / "b.h5", 2) == do(run, tmp_path / "a.h5", 1)


FAILING = add_step(
    change(EQUILIBRIA, "run.steps.1.continue.max_points", 8),
    {"name": "none", "set": {"a": 2}, "simulate": {"t_end": 10}},
)
for extra in (
    {"name": "orbit", "orbit": {"from": "none"}},
    {"name": "after", "set": {"b": 3}, "simulate": {"t_end": 10}},
):
    FAILING = add_step(FAILING, extra)


def test_what_goes_wrong_early_is_raised_in_its_turn(early_steps, tmp_path):
    """A motion that comes to rest has no period; what comes after it in the file is not done."""
    told = []
    for workers in (1, 2):
        heard = Heard()
        with pytest.raises(Exception, match=r".") as caught:
            execute(plan(FAILING), tmp_path / f"{workers}.h5", heard, workers=workers)
        told.append((type(caught.value), str(caught.value), leave_out_points(heard.messages)))
    assert told[0] == told[1] and "orbit" in early_steps
    assert (tmp_path / "1.h5").read_bytes() == (tmp_path / "2.h5").read_bytes()
    assert list(read_results(tmp_path / "2.h5").steps) == ["rest", "branch", "none"]


def test_points_before_an_error_are_written(early_steps, monkeypatch, tmp_path):
    """An error after some rows of a step that is computed early, in the middle of a run."""

    def begin(self, work, task):
        if work is not early.compute_step or task.step not in ("rest", "rests"):
            return None
        future, found = Future(), early.compute_step(plan(RUN), task)
        if task.step == "rests":
            after = next(k for k, entry in enumerate(found.log) if isinstance(entry, early.Opened)) + 5
            found = early.ComputedStep(found.log[:after], ConvergenceError("nothing goes on from here"), {})
        future.set_result(found)
        return future

    monkeypatch.setattr(Elsewhere, "begin", begin)
    with pytest.raises(ConvergenceError, match="nothing goes on"):
        do(RUN, tmp_path / "b.h5", 2)
    step = read_results(tmp_path / "b.h5").step("rests")
    assert early_steps == ["rest", "rests"] and 0 < len(step) < 5 and not step.done


class Stopped(Exception):
    """The run was stopped."""


@pytest.mark.parametrize("number", [1, 12, 30, 60])
def test_a_run_that_is_stopped_goes_on_to_the_same_file(whole, monkeypatch, tmp_path, number):
    real, count = writer.StepWriter.append, []

    def counted(self, *args):
        real(self, *args)
        count.append(1)
        if len(count) == number:
            raise Stopped

    path = tmp_path / "b.h5"
    with monkeypatch.context() as patch:
        patch.setattr(writer.StepWriter, "append", counted)
        with pytest.raises(Stopped):
            do(RUN, path, 2)
    assert path.read_bytes() != whole[0]
    assert do(RUN, path, 2, resume=True)[0] == whole[0]


def test_a_file_that_is_there_already_is_gone_on_with(whole, early_steps, tmp_path):
    """Steps that are done are sources of steps that are not; a motion in the file is computed again where needed."""
    path = tmp_path / "b.h5"
    do(RUN, path, 1, until="rests")
    assert do(RUN, path, 2, resume=True)[0] == whole[0]
    assert set(early_steps) <= {"born", "again", "hopf"} and early_steps


def test_an_accuracy_chooses_the_same(early_steps, tmp_path):
    run = change(change(RUN, "run.steps", STEPS[:6]), "run.accuracy", 1e-5)
    del run["run"]["mesh"]
    assert do(run, tmp_path / "a.h5", 1) == do(run, tmp_path / "b.h5", 1)
    data, messages = do(run, tmp_path / "c.h5", 2)
    assert data == (tmp_path / "a.h5").read_bytes() and "settled" in early_steps
    assert any(name == "note" for name, _ in messages)


def test_what_is_computed_early_is_a_property_of_the_kind():
    assert {name: kind.sharing for name, kind in list_step_kinds().items()} == {
        "simulate": Sharing.EARLY,
        "orbit": Sharing.EARLY,
        "continue": Sharing.EARLY,
        "equilibrium": Sharing.EARLY,
        "sweep": Sharing.POOL,
        "basin": Sharing.POOL,
        "precision": Sharing.ALONE,
        "explore": Sharing.POOL,
    }
