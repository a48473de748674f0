"""Runs that once went wrong without a word, as they stand in the files beside this one, against what is known of them.

References: closed forms where there are some; else the places at which a simulation begins to do something else, found
by an integrator written apart. ``before`` is what the program said before it was
mended, written down then.
"""

import ast
import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import yaml

from pddecont.tables import describe_endings
from tests.runs import labels, parameter, run

HERE = Path(__file__).parent


@cache
def load(name):
    return yaml.safe_load((HERE / f"{name}.yaml").read_text())


def until(data, last):
    """Return a model with a run, or a run, with its steps up to one of them."""
    block = data.get("run", data)
    names = [step["name"] for step in block["steps"]]
    block = {**block, "steps": block["steps"][: names.index(last) + 1]}
    return {**data, "run": block} if "run" in data else block


def follow(name, tmp_path, step="b"):
    """Return a step of a case's run, done with those before it."""
    return run(until(load(name), step), tmp_path / "a.h5").step(step)


def rows_beyond(step, name, value, way):
    """Return the rows of a branch whose parameter is beyond a value."""
    column = step.points["parameters"][:, step.meta["parameters"].index(name)]
    return np.flatnonzero(way * (column - value) > 1e-9 * abs(value))


@pytest.mark.parametrize(
    ("name", "parameter_name", "places"),
    [
        ("sliding_called_admissible", "om", [0.7226791944, 1.2357471523]),
        ("after_event_missed", "tau", [0.4]),
        ("jump_event_missed", "d", [0.5]),
    ],
)
def test_a_branch_goes_no_further_than_its_orbits_are_motions(name, parameter_name, places, tmp_path, mended):
    """Sticking, a kick that the signature does not list, a delayed value that jumps over a surface."""
    branch = follow(name, tmp_path)
    found = [parameter(branch, parameter_name, label) for label in labels(branch) if label.startswith("MC")]
    assert found == pytest.approx(places, abs=1e-8)
    middle = float(np.median(parameter(branch, parameter_name)))
    for place, reference in zip(found, places, strict=True):
        assert (
            len(
                rows_beyond(branch, parameter_name, reference + np.sign(place - middle) * 1e-8, np.sign(place - middle))
            )
            == 0
        )
    assert np.all(branch.points["verified"] == 1)
    now = ", ".join(f"MC at {place:.10g}" for place in found)
    mended(name, "stable and admissible throughout", now, ", ".join(map(str, places)))


def test_dry_friction_with_delayed_feedback_begins_to_stick(tmp_path, monkeypatch, mended):
    monkeypatch.chdir(HERE)
    branch = follow("friction_cross", tmp_path, "branch")
    (label,) = [label for label in labels(branch) if label.startswith("MC")]
    place = parameter(branch, "omega", label)
    assert place == pytest.approx(0.55008, abs=1e-5)
    mended("friction_cross", "stable and admissible throughout", f"MC at {place:.8g}", ".55008")


@pytest.mark.parametrize(
    ("name", "parameter_name", "place"), [("hopf_wright", "tau", math.pi / 2), ("hopf_normal_form", "m", 0.0)]
)
def test_orbits_that_shrink_end_in_a_hopf_point(name, parameter_name, place, tmp_path, mended):
    step = next(s["name"] for s in load(name)["run"]["steps"] if "continue" in s)
    branch = follow(name, tmp_path, step)
    found = parameter(branch, parameter_name, "HB1")
    assert found == pytest.approx(place, abs=1e-10)
    states = [np.ptp(branch.orbit(i)["states"], axis=0).max() for i in range(len(branch)) if branch.labels[i] != "HB1"]
    assert min(states) > 1e-6
    mended(name, "through the point and on with amplitudes of 1e-60", f"HB at {found:.12g}", f"{place:.12g}")


def test_a_hit_born_at_a_grazing_starts_its_clock(tmp_path, mended):
    """Each new hit starts a kick of finite strength: nothing joins at the grazing, and nothing is recorded beyond."""
    branch = follow("grazing_starts_clock", tmp_path)
    place = parameter(branch, "A", "GR1")
    assert place == pytest.approx(0.4 * math.hypot(1 - 4.0, 0.3 * 2.0), abs=1e-8)
    assert len(rows_beyond(branch, "A", place, 1)) == 0
    assert "no motion of the model" in describe_endings(branch)[1]
    mended("grazing_starts_clock", "[fl] stable to A = 1.6", f"ends at GR1 = {place:.10g}", "0.4 abs(3 + 0.6 i)")


@pytest.mark.parametrize(
    ("name", "label", "place"), [("gr_jump", "GR1", 1.0043032411), ("vs_jump", "VS1", 0.9818425107)]
)
def test_nothing_is_called_the_next_signature_that_does_not_join(name, label, place, tmp_path, mended):
    """A relay with hysteresis stays on for a finite time, however little its threshold is passed."""
    branch = follow(name, tmp_path)
    assert parameter(branch, "p", label) == pytest.approx(place, abs=1e-8)
    admissible = branch.points["admissible"] == 1
    assert np.all(admissible[[not kind for kind in branch.points["kind"]]])
    signatures = {branch.orbit(i)["signature"].tobytes() for i in range(len(branch))}
    assert len(signatures) == 1
    assert any("not join" in text for text in describe_endings(branch))
    mended(name, "goes on with an orbit that joins nowhere", f"ends at {label} = {place:.10g} and says so", f"{place}")


def test_events_that_commute_swap(tmp_path, mended):
    """Three cars on a ring: where two of their events meet nothing happens, and the branch goes on."""
    data = until(load("cars"), "branch")
    steps = data["run"]["steps"]
    steps[-1] = {**steps[-1], "continue": {**steps[-1]["continue"], "direction": "up"}}
    branch = run({**data, "run": {**data["run"], "steps": steps}}, tmp_path / "a.h5").step("branch")
    assert parameter(branch, "tau", "EP1") == 1.5
    assert [label for label in labels(branch) if label.startswith("VS")]
    assert len({branch.orbit(i)["signature"].tobytes() for i in range(len(branch))}) == 2
    assert np.all(branch.points["verified"] == 1)
    order = branch.order.tolist()
    k = order.index(branch.row("VS1"))
    # The period goes on without a jump: its slope is the same on either side.
    period, tau = branch.points["period"][order], parameter(branch, "tau")[order]
    before, after = (np.diff(period[i : i + 2]) / np.diff(tau[i : i + 2]) for i in (k - 1, k))
    assert after == pytest.approx(before, rel=1e-3)
    mended("cars, in tau", "ends where two events meet", "goes on to tau = 1.5", "continuous")


def test_files_here_are_used():
    """As a word of a test, or as the model of another file."""
    tests = [ast.parse(path.read_text()) for path in HERE.glob("test_*.py")]
    words = {node.value for tree in tests for node in ast.walk(tree) if isinstance(node, ast.Constant)}
    models = {load(path.stem).get("model") for path in HERE.glob("*.yaml")}
    for path in HERE.glob("*.yaml"):
        assert path.stem in words or path.name in models, path.name
