"""Points at which a condition changes: located, gone through where what follows joins, followed in two parameters."""

import math

import numpy as np
import pytest

from pddecont.tables import describe_endings
from tests.bifurcation.runs import follow, settle
from tests.guarded import LOW, MIDDLE, RAMP, SATURATION
from tests.runs import labels, monitor, parameter, run


@pytest.fixture(scope="module")
def saturation(tmp_path_factory):
    steps = [
        *settle(60),
        follow("b", "o", {"F": [0.1, 2]}, stability=True),
        follow("c", ("b", "GD1"), {"F": [0.1, 2], "k": [0.1, 1.5]}, stability=True),
    ]
    return run(
        {**SATURATION, "run": {"monitors": {"top": "max(x)"}, "steps": steps}}, tmp_path_factory.mktemp("g") / "a.h5"
    )


def test_where_a_condition_fails_is_located_and_said(tmp_path):
    branch = follow("b", "o", {"ramp": [0.1, 3]}, stability=True)
    step = run({**RAMP, "run": {"steps": [*settle(60), branch]}}, tmp_path / "a.h5").step("b")
    assert sorted(labels(step)) == ["GD1", "GD2"]
    assert [parameter(step, "ramp", label) for label in ("GD1", "GD2")] == pytest.approx([LOW, MIDDLE], abs=1e-12)
    names = [step.reason(step.row(label)).values["segment"] for label in ("GD1", "GD2")]
    assert names == ["tock>feed", "tock>idle"]
    # The other mode goes on to something else at once: nothing joins, and nothing is recorded beyond.
    assert all("next signature was not found" in text for text in describe_endings(step))
    assert np.all(step.points["verified"] == 1)


def test_where_both_modes_agree_the_branch_goes_through(saturation):
    """x = s = (F - k s) / 0.5 below cap, (F - k cap) / 0.5 above."""
    step = saturation.step("b")
    place = 0.5 * (0.5 + 0.8)
    assert parameter(step, "F", "GD1") == pytest.approx(place, abs=1e-12)
    F, x = parameter(step, "F"), monitor(step, "top")
    exact = np.where(place > F, F / 1.3, (F - 0.4) / 0.5)
    assert x == pytest.approx(exact, abs=1e-12)
    assert [min(F), max(F)] == [0.1, 2]
    assert {step.orbit(i)["signature"].tobytes() for i in range(len(step))} == {b"tick>linear", b"tock>capped"}
    assert np.all(step.points["verified"] == 1) and np.all(step.points["stable"] == 1)


def test_the_point_is_followed_in_two_parameters(saturation):
    step = saturation.step("c")
    assert step.meta["curve"] == "GD"
    F, k = parameter(step, "F"), parameter(step, "k")
    assert [min(k), max(k)] == pytest.approx([0.1, 1.5], abs=1e-14)
    assert pytest.approx(0.5 * (0.5 + k), abs=1e-12) == F


def test_along_a_curve_of_another_point_it_is_located(tmp_path):
    """Along v = 10 up (1 - e^-0.1) / (1 - e^-1.1) = 1.2 up is fixed; ramp passes the lowest and the middle value."""
    top = {"level": "top - 1.2"}
    steps = [
        *settle(60),
        follow("b", "o", {"up": [0.5, 1.6]}, events_along=top),
        follow("c", ("b", "UF1"), {"ramp": [0.1, 3], "up": [0.5, 1.6]}, events_along=top),
    ]
    step = run({**RAMP, "run": {"monitors": {"top": "max(v)"}, "steps": steps}}, tmp_path / "a.h5").step("c")
    assert step.meta["curve"] == "UF" and sorted(labels(step)) == ["GD1", "GD2"]
    exact = [1.2 * math.exp(-1.0), 1.2 * math.exp(-0.5)]
    assert [parameter(step, "ramp", label) for label in ("GD1", "GD2")] == pytest.approx(exact, abs=1e-12)


def test_without_gd_wanted_the_branch_goes_on_and_its_orbits_are_no_motions(tmp_path):
    branch = follow("b", "o", {"ramp": [0.4, 1]}, detect=[])
    step = run({**RAMP, "run": {"steps": [*settle(60), branch]}}, tmp_path / "a.h5").step("b")
    ramp = parameter(step, "ramp")
    assert ((ramp > LOW) & (ramp < MIDDLE)).tolist() == (step.points["admissible"][step.order] == 1).tolist()
