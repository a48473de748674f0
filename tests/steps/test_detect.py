"""Special points are looked for as far as a step asks for them, and what is not asked for is not computed."""

import numpy as np
import pytest

from pddecont.bifurcation import branch_tests, grazing, period_doubling, vanishing
from pddecont.errors import RunError
from pddecont.orbit import Monitor, event_profiles
from pddecont.stability import MultiplierCache
from tests.runs import labels, plan, run

CONTINUE = {
    "from": "orbit",
    "free": ["tau_d"],
    "range": {"tau_d": [3.0, 3.9]},
    "events_along": {"level": "max(x) - 1.3"},
}


def started(more):
    """Return a run whose branch is told more."""
    return {
        "model": "impact_oscillator",
        "mesh": {"intervals": 12},
        "monitors": {"top": "max(x)"},
        "steps": [
            {"name": "transient", "simulate": {"t_end": "60*2*pi/omega"}},
            {"name": "orbit", "orbit": {"from": "transient"}},
            {"name": "branch", "continue": {**CONTINUE, **more}},
        ],
    }


def branch(tmp_path, **more):
    return run(started(more), tmp_path / "r.h5").step("branch")


@pytest.fixture
def calls(monkeypatch):
    """Count the calls of all that special points are found with."""
    count = {}

    def counting(name, function):
        def counted(*args, **kwargs):
            count[name] = count.get(name, 0) + 1
            return function(*args, **kwargs)

        return counted

    for where, name in (
        (grazing, "_gaps"),
        (vanishing, "find_smallest_crossing_rate"),
        (vanishing.MeetingFunction, "evaluate"),
        (period_doubling, "compare_halves"),
        (MultiplierCache, "find"),
        (branch_tests, "find_violation"),
        (Monitor, "evaluate"),
    ):
        key = f"{where.__name__.rpartition('.')[2]}.{name}"
        monkeypatch.setattr(where, name, counting(key, getattr(where, name)))
    return count


def test_all_is_looked_for_unless_said_otherwise(tmp_path, calls):
    step = branch(tmp_path)
    assert "GR1" in labels(step)
    assert set(calls) >= {
        "grazing._gaps",
        "vanishing.find_smallest_crossing_rate",
        "branch_tests.find_violation",
        "Monitor.evaluate",
        "period_doubling.compare_halves",
    }


def test_nothing_is_looked_for_where_nothing_is_asked_for(tmp_path, calls):
    step = branch(tmp_path, detect=[])
    assert labels(step) == []
    assert step.meta["monitors"] == ["top"]
    # One monitor, recorded once a point; the user function is not looked at.
    assert set(calls) == {"Monitor.evaluate"}
    assert calls["Monitor.evaluate"] == len(step) + 1
    # What the orbits do is recorded all the same: beyond the grazing they cross what they should not.
    assert set(step.points["admissible"][step.order]) == {0, 1}
    assert np.all(np.isfinite(step.points["clearance"]))


def test_only_what_is_asked_for_is_computed(tmp_path, calls):
    step = branch(tmp_path, detect=["UF"])
    assert {x.rstrip("0123456789") for x in labels(step)} <= {"UF"}
    assert set(calls) == {"Monitor.evaluate"}
    assert calls["Monitor.evaluate"] > len(step) + 1
    grazes = branch(tmp_path, detect=["GR"], signature_change="stop")
    assert labels(grazes) == ["GR1"]
    assert not any("vanishing" in name or "Meeting" in name for name in calls)


def duffing(**more):
    """Return a run whose branch is told more."""
    branch = {"from": "orbit", "free": ["omega"], "range": {"omega": [1.0, 2.6]}, **more}
    return {
        "model": "duffing",
        "mesh": {"intervals": 20},
        "steps": [
            {"name": "transient", "simulate": {"t_end": "100*2*pi/omega"}},
            {"name": "orbit", "orbit": {"from": "transient"}},
            {"name": "branch", "continue": branch},
        ],
    }


def test_folds_alone_need_no_multipliers_though_points_may_have_them(tmp_path, calls):
    step = run(duffing(detect=["LP"]), tmp_path / "d.h5").step("branch")
    assert {x.rstrip("0123456789") for x in labels(step)} == {"LP"}
    assert "MultiplierCache.find" not in calls
    with_stability = run(duffing(detect=["LP"], stability=True), tmp_path / "s.h5").step("branch")
    assert labels(with_stability) == labels(step)
    # Once a point, for its own record, and once to see whether they can be told at all.
    assert calls["MultiplierCache.find"] == len(with_stability) + 1


@pytest.mark.parametrize(
    ("detect", "message"),
    [
        (["TR"], "'TR' is seen from multipliers; add 'stability: true'"),
        (["GG"], "'GG' is not found with one free parameter"),
        (
            ["GT", "LR"],
            r"'LR' is not found with one free parameter "
            r"\(there are: LP, BP, PD, TR, GR, VS, MC, GD, CS, GS, SS, AS, UF, HB\)",
        ),
    ],
)
def test_kinds_that_cannot_be_found_are_refused(detect, message):
    with pytest.raises(RunError, match=message):
        plan(started({"detect": detect}))


def test_event_functions_along_an_orbit_are_worked_out_once(tmp_path, monkeypatch):
    made, whole = [], event_profiles.make_profile

    def counting(orbit, *args, **kwargs):
        made.append(id(orbit))
        orbits.append(orbit)  # as long as it is kept no other orbit has its identity
        return whole(orbit, *args, **kwargs)

    orbits = []
    monkeypatch.setattr(event_profiles, "make_profile", counting)
    step = branch(tmp_path, detect=[])
    # One event function, looked at for what is admissible, for the clearance and for its extrema.
    assert len(set(made)) == len(made) == len(step) + 1
