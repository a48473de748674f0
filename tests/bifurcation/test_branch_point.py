"""Branch points, and the branches that cross there."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.bifurcation import BranchSettings, StartError, branch_point, find_kind
from pddecont.bifurcation.branch_point import find_other_branch
from pddecont.collocation import MeshRule
from pddecont.tables import describe_endings
from tests.bifurcation.runs import make_multipliers
from tests.continuation.systems import Algebraic
from tests.runs import change, labels, monitor, multipliers, parameter, run

PITCHFORK = {
    "name": "pitchfork",
    "states": ["x", "y"],
    "parameters": {"a": -0.4, "b": 0},
    "forcing": {"period": 1},
    "modes": {"m": {"x'": "a*x + b*x**2 - x**3 + x*y", "y'": "cos(2*pi*t) - y"}},
    "run": {
        "mesh": {"degree": 8, "tol": 1e-10},
        "monitors": {"x": "mean(x)"},
        "steps": [
            {"name": "t", "simulate": {"t_end": 40}},
            {"name": "o", "orbit": {"from": "t"}},
            {"name": "c", "continue": {"from": "o", "free": ["a"], "range": {"a": [-0.5, 0.5]}, "stability": True}},
            {
                "name": "other",
                "continue": {
                    "from": {"step": "c", "point": "BP1"},
                    "branch": "switch",
                    "free": ["a"],
                    "range": {"a": [-0.5, 0.5]},
                    "stability": True,
                },
            },
        ],
    },
}


@pytest.mark.parametrize("b", [0.0, 0.7])
def test_branch_points_and_the_branch_that_crosses(tmp_path, b):
    """x = 0 has the multiplier exp(a): branches cross at a = 0, a pitchfork for b = 0, else a transcritical point."""

    results = run(change(PITCHFORK, "parameters.b", b), tmp_path / "a.h5")
    step, other = results.step("c"), results.step("other")
    assert labels(step) == ["BP1"]
    assert parameter(step, "a", "BP1") == pytest.approx(0, abs=1e-8)
    at = np.argsort(parameter(step, "a"))
    for i in step.order[at][:: max(1, len(step) // 5)]:
        a = step.points["parameters"][i, 0]
        assert np.min(np.abs(multipliers(step, i) - math.exp(a))) < 1e-8
    x = monitor(other, "x")
    assert np.max(np.abs(x)) > 0.3
    a = parameter(other, "a")
    if b == 0.0:
        assert np.all(a > -1e-6)
        assert np.max(x) > 0.3 and np.min(x) < -0.3
    else:
        assert np.min(a) < -0.05


SYMMETRIC = {
    "name": "symmetric",
    "states": ["x", "v"],
    "parameters": {"omega": 1.2, "c": 0.3, "r": 0.9, "K": 0.1, "tau": 0.5, "g": 1},
    "forcing": {"period": "2*pi/omega"},
    "modes": {"free": {"x'": "v", "v'": "cos(omega*t) - c*v + K*v(t - tau)"}},
    "events": {"R": "x - g", "L": "x + g"},
    "resets": {"b": {"v": "-r*v"}},
    "segments": {
        "R": {"mode": "free", "event": "R", "direction": "rising", "reset": "b", "to": "free"},
        "L": {"mode": "free", "event": "L", "direction": "falling", "reset": "b", "to": "free"},
    },
    "initial": {"x": 0.1, "v": 0.5},
    "run": {
        "mesh": {"degree": 8, "tol": 1e-09},
        "monitors": {"m": "mean(x)"},
        "steps": [
            {"name": "t", "simulate": {"t_end": 400}},
            {"name": "o", "orbit": {"from": "t"}},
            {
                "name": "c",
                "continue": {
                    "from": "o",
                    "free": ["omega"],
                    "range": {"omega": [1.05, 1.4]},
                    "stability": True,
                    "step": {"max": 0.1},
                },
            },
            {
                "name": "small",
                "continue": {
                    "from": "o",
                    "free": ["omega"],
                    "range": {"omega": [1.08, 1.25]},
                    "stability": True,
                    "step": {"max": 0.03},
                },
            },
            {
                "name": "d",
                "continue": {
                    "from": {"step": "c", "point": "BP1"},
                    "branch": "switch",
                    "free": ["omega"],
                    "range": {"omega": [1.09, 1.4]},
                    "step": {"max": 0.02},
                },
            },
        ],
    },
}


def test_a_symmetric_orbit_between_two_walls_loses_its_symmetry(tmp_path):
    """At the branch point no orbit can be corrected; its place does not depend on the steps, and the new orbits mirror
    each other.
    """
    results = run(SYMMETRIC, tmp_path / "a.h5")
    step = results.step("c")
    assert labels(step) == ["BP1"]
    assert not any("WARNING" in t for t in describe_endings(step))
    at = parameter(step, "omega", "BP1")
    assert parameter(results.step("small"), "omega", "BP1") == pytest.approx(at, abs=1e-8)
    assert np.min(np.abs(multipliers(step, step.row("BP1")) - 1.0)) < 1e-6
    m, omega = monitor(results.step("d"), "m"), parameter(results.step("d"), "omega")
    assert np.max(m) > 0.05
    assert np.max(m) == pytest.approx(-np.min(m), abs=1e-8)
    assert np.max(omega) < at + 1e-6
    # The squared asymmetry grows in proportion to the distance from the branch point.
    near = (np.abs(m) < 0.06) & (np.abs(m) > 1e-6)
    assert np.sum(near) > 6
    # Extrapolated to none: a quadratic over a wider range misses by 6e-5, this cubic by 1e-6.
    assert np.polynomial.Polynomial.fit(m[near] ** 2, omega[near], 3)(0.0) == pytest.approx(at, abs=3e-6)


def test_three_branch_points_of_a_symmetric_oscillator(tmp_path):
    text = {
        "name": "cubic",
        "states": ["x", "v"],
        "parameters": {"w": 1.2},
        "forcing": {"period": "2*pi/w"},
        "modes": {"m": {"x'": "v", "v'": "cos(w*t) - 0.2*v - x**3"}},
        "initial": {"x": 0.1, "v": 0.5},
        "run": {
            "mesh": {"degree": 8, "tol": 1e-09},
            "steps": [
                {"name": "t", "simulate": {"t_end": 400}},
                {"name": "o", "orbit": {"from": "t"}},
                {"name": "c", "continue": {"from": "o", "free": ["w"], "range": {"w": [0.32, 1.4]}, "stability": True}},
            ],
        },
    }
    step = run(text, tmp_path / "a.h5").step("c")
    assert sorted(labels(step)) == ["BP1", "BP2", "BP3", "LP1", "LP2"]
    assert not any("WARNING" in t for t in describe_endings(step))
    for name in ("BP1", "BP2", "BP3"):
        assert np.min(np.abs(multipliers(step, step.row(name)) - 1.0)) < 1e-5


def cross(f, slopes, scale=(1.0, 1.0)):
    """Return the equations 2 z = 0, z + f(y, p) = 0 in (z, y, p) at zero, where f is singular."""
    system = Algebraic(
        lambda x: [2.0 * x[0], x[0] + f(x[1], x[2])],
        lambda x: [[2.0, 0.0, 0.0], [1.0, *slopes(x[1], x[2])]],
        scale=(1.0, *scale),
        weight=(1.0, 1.0, 1.0),
    )
    return system.at(np.zeros(3))


@pytest.mark.parametrize("scale", [(1.0, 1.0), (0.1, 3.0)])
@pytest.mark.parametrize("slope", [0.0, 0.7, -2.0])
def test_the_other_branch_crosses_in_the_direction_of_the_closed_form(scale, slope):
    """y (p - s y) = 0: y = 0 along p, and p = s y."""
    at = cross(lambda y, p: y * (p - slope * y), lambda y, p: [p - 2.0 * slope * y, y], scale)
    line, other = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, slope])
    found = find_other_branch(at, line)
    assert found / found[1] == pytest.approx(other, abs=1e-9)
    assert at.system.scaling.length(found) == pytest.approx(1.0, abs=1e-12)
    back = find_other_branch(at, other)
    assert back / back[2] == pytest.approx(line, abs=1e-9)


@pytest.mark.parametrize("tilt", [-0.3, 0.3])
def test_a_tangent_that_is_roughly_known_is_enough(tilt):
    """y (p - y) = 0: whatever mixture of both directions the tangent is, the branch farther from it is found."""
    at = cross(lambda y, p: y * (p - y), lambda y, p: [p - 2.0 * y, y])
    found = find_other_branch(at, np.array([0.0, tilt, 1.0]))
    line, other = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 1.0])
    assert found / found[1] == pytest.approx(other, abs=1e-9)
    back = find_other_branch(at, np.array([0.0, 1.0, 1.0 + tilt]))
    assert back / back[2] == pytest.approx(line, abs=1e-9)


def test_at_a_pitchfork_the_other_branch_stands_across():
    """y (p - y^2) = 0: a parabola that touches the direction of y."""
    at = cross(lambda y, p: y * (p - y**2), lambda y, p: [p - 3.0 * y**2, y])
    found = find_other_branch(at, np.array([0.0, 0.0, 1.0]))
    assert np.abs(found) == pytest.approx([0.0, 1.0, 0.0], abs=1e-6)


def test_another_mesh_than_that_of_the_step_that_found_it_is_refused(free_orbit):
    settings = BranchSettings(("omega",), ((1.5, 2.5),), MeshRule(8, tol=1e-9))
    with pytest.raises(StartError, match="on the mesh and with the free parameter of the step that found it"):
        find_kind("BP").switch(free_orbit, np.zeros(3), settings)


@settings(max_examples=50, deadline=None, derandomize=True)
@given(
    st.lists(st.floats(-3.0, 3.0), min_size=1, max_size=5), st.lists(st.complex_numbers(max_magnitude=3.0), max_size=2)
)
def test_the_test_function_is_the_distance_to_one_and_counts_those_beyond(real, pairs):
    pairs = [v for v in pairs if v.imag]
    m = make_multipliers([*real, *pairs, *np.conj(pairs)])
    value = branch_point.measure_distance(m)
    assert abs(value) == min(abs(v - 1.0) for v in real)
    if value:
        assert np.sign(value) == (-1.0) ** sum(v > 1.0 for v in real)


def test_without_a_real_multiplier_there_is_no_test_function():
    assert math.isnan(branch_point.measure_distance(make_multipliers([1j, -1j])))


def test_a_branch_point_just_after_a_meeting_of_multipliers_is_found(tmp_path):
    """Two coupled oscillators, neutral by a difference: a pair meets on the real axis just before one passes +1.

    A third multiplier is nearer to +1 than they are until then. Steps of 0.008 find k = 0.481996 without meeting that.
    """
    linear = "-0.1*(x2 - x4) - (x1 - x3) - x1 + (x1 - x3)**3"
    model = {
        "name": "after_a_meeting",
        "states": ["x1", "x2", "x3", "x4"],
        "parameters": {"k": 0.48, "tau": 0.1, "d": 0.001},
        "modes": {
            "m": {
                "x1'": "x2",
                "x2'": f"{linear} + k*(x2(t - tau + d) - x2(t - tau - d))/(2*d)",
                "x3'": "x4",
                "x4'": "-0.1*(x4 - x2) - (x3 - x1) + (x3 - x1)**3",
            }
        },
        "initial": {"x1": 0.1, "x4": -0.1},
    }
    limits = {"k": [0.47, 0.5]}
    step = {"from": "o", "free": ["k"], "range": limits, "direction": "up", "step": {"max": 0.02}, "stability": True}
    steps = [
        {"name": "t", "simulate": {"t_end": 600}},
        {"name": "o", "orbit": {"from": "t"}},
        {"name": "b", "continue": {**step, "max_points": 8}},
    ]
    branch = run({**model, "run": {"steps": steps}}, tmp_path / "a.h5").step("b")
    assert labels(branch) == ["BP1"]
    assert parameter(branch, "k", "BP1") == pytest.approx(0.481996, abs=1e-6)
    assert not any("WARNING: 1 change" in text for text in describe_endings(branch))
