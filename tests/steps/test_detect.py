"""Special points are looked for as far as a step asks for them, and what is not asked for is not computed."""

import numpy as np
import pytest

from pddecont.bifurcation import grazing, period_doubling, tangency
from pddecont.errors import RunError
from pddecont.model.document import parse_document
from pddecont.orbit.monitors import Monitor
from pddecont.stability.multipliers import Known
from pddecont.steps import points, watch
from pddecont.steps.loading import load_plan
from tests.conftest import ROOT
from tests.runs import labels, run

START = """
model: impact_oscillator
mesh: {intervals: 12}
monitors: {top: max(x)}
steps:
  - {name: transient, simulate: {t_end: 60*2*pi/omega}}
  - {name: orbit, orbit: {from: transient}}
  - {name: branch, continue: {from: orbit, free: [tau_d], range: {tau_d: [3.0, 3.9]}, events_along: {level: max(x) - 1.3}%s}}
"""


def branch(tmp_path, more):
    return run(START % more, tmp_path / "r.h5").step("branch")


@pytest.fixture
def calls(monkeypatch):
    """Count the calls of all that special points are found with."""
    count = {}

    def counting(name, function):
        def counted(*args, **kwargs):
            count[name] = count.get(name, 0) + 1
            return function(*args, **kwargs)

        return counted

    for where, name in ((grazing, "height"), (tangency, "crossing_rate"), (tangency.Meeting, "at"),
                        (period_doubling, "halves"), (Known, "__call__"), (watch, "objections"), (Monitor, "value")):  # fmt: skip
        key = f"{where.__name__}.{name}"
        monkeypatch.setattr(where, name, counting(key, getattr(where, name)))
    return count


def test_all_is_looked_for_unless_said_otherwise(tmp_path, calls):
    step = branch(tmp_path, "")
    assert "GR1" in labels(step)
    names = {name.rsplit(".", 1)[1] for name in calls}
    assert {"height", "crossing_rate", "objections", "value", "halves"} <= names


def test_nothing_is_looked_for_where_nothing_is_asked_for(tmp_path, calls):
    step = branch(tmp_path, ", detect: []")
    assert labels(step) == []
    assert step.meta["monitors"] == ["top"]
    # One monitor, recorded once a point; the user function is not looked at.
    assert set(calls) == {"Monitor.value"}
    assert calls["Monitor.value"] == len(step) + 1
    # What the orbits do is recorded all the same: beyond the grazing they cross what they should not.
    assert set(step.points["admissible"][step.order]) == {0, 1}
    assert np.all(np.isfinite(step.points["clearance"]))


def test_only_what_is_asked_for_is_computed(tmp_path, calls):
    step = branch(tmp_path, ", detect: [UF]")
    assert {x.rstrip("0123456789") for x in labels(step)} <= {"UF"}
    assert set(calls) == {"Monitor.value"}
    assert calls["Monitor.value"] > len(step) + 1
    grazes = branch(tmp_path, ", detect: [GR], signature_change: stop")
    assert labels(grazes) == ["GR1"]
    assert not any("tangency" in name for name in calls)


DUFFING = """
model: duffing
mesh: {intervals: 20}
steps:
  - {name: transient, simulate: {t_end: 100*2*pi/omega}}
  - {name: orbit, orbit: {from: transient}}
  - {name: branch, continue: {from: orbit, free: [omega], range: {omega: [1.0, 2.6]}%s}}
"""


def test_folds_alone_need_no_multipliers_though_points_may_have_them(tmp_path, calls):
    step = run(DUFFING % ", detect: [LP]", tmp_path / "d.h5").step("branch")
    assert {x.rstrip("0123456789") for x in labels(step)} == {"LP"}
    assert "Known.__call__" not in calls
    with_stability = run(DUFFING % ", detect: [LP], stability: true", tmp_path / "s.h5").step("branch")
    assert labels(with_stability) == labels(step)
    # Once a point, for its own record, and once to see whether they can be told at all.
    assert calls["Known.__call__"] == len(with_stability) + 1


@pytest.mark.parametrize(("more", "message"), [
    ("detect: [TR]", "'TR' is seen from multipliers; add 'stability: true'"),
    ("detect: [GG]", "'GG' is not found with one free parameter"),
    ("detect: [GT, LR]", "did you mean 'TR'|expected"),
])  # fmt: skip
def test_kinds_that_cannot_be_found_are_refused(more, message):
    with pytest.raises(RunError, match=message):
        load_plan(parse_document(START % f", {more}", str(ROOT / "configs" / "test.yaml")))


def test_a_recorded_point_looks_at_its_events_once(tmp_path, monkeypatch):
    looks = []
    whole = points.event_profiles
    monkeypatch.setattr(points, "event_profiles", lambda *a: looks.append(1) or whole(*a))
    step = branch(tmp_path, ", detect: []")
    assert len(looks) == len(step) + 1
