"""A step of each kind, stopped after a row that it writes, goes on to the same file: words and warnings included."""

import shutil

import numpy as np
import pytest

from pddecont.bifurcation import branch_tests
from pddecont.continuation import CountFunction
from pddecont.results import read_results, writer
from pddecont.steps.execution import execute
from pddecont.tables import describe_endings
from tests.faults.runs import BRANCH, KINDS, LOOSE, MODEL, START, UP, contents
from tests.runs import change, plan
from tests.steps.test_asymptote import SADDLE

FOLD = {
    "name": "folding",
    "states": ["x", "v"],
    "parameters": {"omega": 1.2, "F": 0.4, "K": 0.05, "tau": 0.7},
    "forcing": {"period": "2*pi/omega"},
    "modes": {"free": {"x'": "v", "v'": "F*cos(omega*t) - 0.2*v - x - x**3 + K*x(t - tau)"}},
}
SWEEP = {
    "over": {"wall": [0.15, 0.3, 4]},
    "initial": [{"x": 0, "v": 0}],
    "random": {"number": 2, "seed": 2, "box": {"v": [-1, 1]}},
    "carry": "both",
    "lyapunov": True,
    "transient": "20*pi",
    "max_period": 4,
    **LOOSE,
}


def make_curve(name, point, free, ranges):
    return {"name": "last", "continue": {"from": {"step": name, "point": point}, "free": free, "range": ranges}}


def make_run(model, steps):
    return change({**model, "run": {"mesh": {"degree": 3, "intervals": 10}}}, "run.steps", steps)


WIDE = {**UP, "range": {"wall": [0.17, 0.6]}, "step": {"initial": 0.1, "max": 0.1}, "stability": True}
RESPONSE = {"from": "orbit", "free": ["omega"], "range": {"omega": [1.1, 2.2]}, "direction": "up"}
SETTLING = {"name": "transient", "simulate": {"t_end": "40*pi"}}
RUNS = {
    **{kind: change(MODEL, "run.steps", KINDS[kind]) for kind in KINDS if kind != "precision"},
    "sweep both ways": change(MODEL, "run.steps", [{"name": "last", "sweep": SWEEP}]),
    "signatures": change(MODEL, "run.steps", [*START, {"name": "last", "continue": {**WIDE, "max_points": 30}}]),
    "grazings": change(
        MODEL,
        "run.steps",
        [
            *START,
            {"name": "first", "continue": WIDE},
            make_curve("first", "GR1", ["wall", "r"], {"wall": [0.15, 0.6], "r": [0.7, 0.9]}),
        ],
    ),
    "folds": make_run(
        FOLD,
        [
            SETTLING,
            START[1],
            {"name": "first", "continue": RESPONSE},
            make_curve("first", "LP1", ["omega", "F"], {"omega": [1, 2.2], "F": [0.1, 0.5]}),
        ],
    ),
}


# Branches that shrink to a Hopf point, one that is a loop, one along an asymptote, one whose orbits cease to
# be motions, and the same followed beyond.
SUPERCRITICAL = {
    "name": "supercritical",
    "states": ["x", "y"],
    "parameters": {"m": 0.3},
    "modes": {"m": {"x'": "m*x - y - x*(x**2 + y**2)", "y'": "x + m*y - y*(x**2 + y**2)"}},
    "initial": {"x": 0.5, "y": 0},
}
ISLAND = {
    "name": "island",
    "states": ["x", "y"],
    "parameters": {"m": 0.1},
    "modes": {
        "m": {
            "x'": "(0.25 - (x**2 + y**2 - 1)**2 - m**2)*x - (1 + 0.3*m)*y",
            "y'": "(1 + 0.3*m)*x + (0.25 - (x**2 + y**2 - 1)**2 - m**2)*y",
        }
    },
    "initial": {"x": 1, "y": 0},
}
STICKING = {
    "name": "sticking",
    "states": ["x", "v"],
    "parameters": {"om": 0.9},
    "forcing": {"period": "2*pi/om"},
    "modes": {
        "plus": {"x'": "v", "v'": "1.5*cos(om*t) - x - 0.1*v - 1"},
        "minus": {"x'": "v", "v'": "1.5*cos(om*t) - x - 0.1*v + 1"},
    },
    "events": {"turn": "v"},
    "segments": {
        "P": {"mode": "plus", "event": "turn", "direction": "falling", "to": "minus"},
        "M": {"mode": "minus", "event": "turn", "direction": "rising", "to": "plus"},
    },
    "initial": {"mode": "plus", "x": 0, "v": 5},
}
STICKS = {"from": "orbit", "free": ["om"], "range": {"om": [0.6, 0.95]}}
ASYMPTOTE = {"from": "orbit", "free": ["p"], "range": {"p": [0, 1]}, "stability": True}
IN_M = {"from": "orbit", "free": ["m"], "range": {"m": [-1, 1]}, "stability": True, "step": {"max": 0.2}}


def settle_and_follow(model, branch):
    steps = [{"name": "transient", "simulate": {"t_end": "200*pi"}}, START[1], {"name": "last", "continue": branch}]
    return {**model, "run": {"steps": steps}}


ENDS = {
    "MC": settle_and_follow(STICKING, {**STICKS, "stability": True}),
    "not verified": settle_and_follow(STICKING, {**STICKS, "detect": [], "step": {"initial": 0.1}}),
    "HB": settle_and_follow(SUPERCRITICAL, IN_M),
    "closed": settle_and_follow(ISLAND, IN_M),
    "asymptote": settle_and_follow(SADDLE, ASYMPTOTE),
}


class Stopped(Exception):
    """The run was stopped."""


def stop_after(monkeypatch, name, number):
    """Let a run stop after so many calls of a method of those that write steps."""
    real, count = getattr(writer.StepWriter, name), []

    def counted(*args, **options):
        real(*args, **options)
        count.append(1)
        if len(count) == number:
            raise Stopped

    monkeypatch.setattr(writer.StepWriter, name, counted)


def check_all_stops(run, folder, monkeypatch, most):
    """Stop the last step of a run after its rows, one after another, and compare what --resume makes of it."""
    checked, before, whole = plan(run), folder / "before.h5", folder / "whole.h5"
    names = [step.name for step in checked.steps]
    if len(names) > 1:
        execute(checked, before, until=names[-2])
        shutil.copy(before, whole)
    execute(checked, whole, resume=True)
    expected, step = contents(whole), read_results(whole).step("last")
    n, ends = len(step), len(step.endings)
    stops = [("append", k) for k in sorted({1 + round(k * (n - 1) / (most - 1)) for k in range(most)})]
    for name, number in [*stops, *(("terminate", k + 1) for k in range(ends))]:
        path = folder / f"{name}{number}.h5"
        if before.exists():
            shutil.copy(before, path)
        with monkeypatch.context() as patch:
            stop_after(patch, name, number)
            with pytest.raises(Stopped):
                execute(checked, path, resume=True)
        execute(checked, path, resume=True)
        found = contents(path)
        assert [key for key in expected if found.get(key) != expected[key]] == [], (name, number)
        assert set(found) == set(expected)
        path.unlink()
    return step


QUICK = ("simulate", "orbit", "continue")


@pytest.mark.parametrize(
    "kind", [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in RUNS]
)
def test_a_step_stopped_after_any_row_goes_on_to_the_same_file(kind, tmp_path, monkeypatch, tally):
    step = check_all_stops(RUNS[kind], tmp_path, monkeypatch, most=3 if kind in QUICK else 8)
    tally("faults", f"{kind} stopped after a row", "--resume gives the same file", min(8, len(step)))
    # What is hard to go on from is there.
    if kind == "signatures":
        assert len({step.orbit(i)["signature"].tobytes() for i in range(len(step))}) > 1
    assert kind not in {"grazings", "folds"} or step.meta["curve"] == {"grazings": "GR", "folds": "LP"}[kind]
    assert len(step) > 5 or kind in {"simulate", "orbit", "continue", "sweep", "basin"}


def test_changes_of_stability_that_were_not_located_are_still_told_of(tmp_path, monkeypatch, mended):
    """Counts that change where no special point is, twice on the way up, once on the way down."""

    def count(point):
        wall = float(point.at.orbit.free[0])
        return (int(wall > 0.207) + int(wall > 0.213) - int(wall < 0.19),)

    counts = CountFunction(count, lambda before, after: None if before != after else [])
    monkeypatch.setattr(branch_tests, "count_on_branch", lambda settings: counts)
    branch = {**BRANCH, "step": {"initial": 0.05, "max": 0.05}}
    run = change(MODEL, "run.steps", [*START, {"name": "last", "continue": branch}])
    step = check_all_stops(run, tmp_path, monkeypatch, most=4)
    assert [ending.values["unexplained"] for ending in step.endings] == [1, 2]
    assert int(step.points["unexplained"].sum()) == 3
    down, up = describe_endings(step)
    assert "WARNING: 1 change of stability not located" in down
    assert "WARNING: 2 changes of stability not located" in up
    mended(
        "resume_warning", "the warning is gone in 5 of 8 resumed runs", "the same at every stop", "the run left alone"
    )


ENDINGS = {
    "MC": ["invalid", "range"],
    "not verified": ["range", "range"],
    "HB": ["shrinks", "range"],
    "closed": ["closed", "closed"],
    "asymptote": ["asymptote", "range"],
}


@pytest.mark.parametrize(
    "end", [end if end in {"asymptote", "not verified"} else pytest.param(end, marks=pytest.mark.slow) for end in ENDS]
)
def test_a_branch_stopped_after_any_row_ends_as_it_would_have_ended(end, tmp_path, monkeypatch):
    step = check_all_stops(ENDS[end], tmp_path, monkeypatch, most=3)
    assert [ending.code for ending in step.endings] == ENDINGS[end]
    assert np.any(step.points["verified"] == 0) == (end == "not verified")
    assert (end not in {"MC", "HB"}) or f"{end}1" in step.labels
