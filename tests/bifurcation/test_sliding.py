"""Sliding bifurcations of a block on a belt: located, named, gone through and followed, against a simulation apart."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar
from scipy.special import lambertw

from tests.bifurcation.friction import Block
from tests.bifurcation.runs import follow, settle
from tests.runs import change, labels, multipliers, parameter, run

BELT = {
    "name": "belt",
    "states": ["x", "v"],
    "parameters": {"om": 1.7, "F": 1.0, "G": 0.0, "vb": 1.0, "mu": 0.4},
    "forcing": {"period": "2*pi/om"},
    "switches": {"slip": "v - vb"},
    "equations": {"x'": "v", "v'": "F*cos(om*t) + G*cos(5*om*t) - x - 0.2*v - mu*sign(v - vb)"},
}
MESH = {"degree": 9, "tol": 1e-11}
STEPS = [{"name": "s", "simulate": {"t_end": "60*2*pi/om"}}, {"name": "o", "orbit": {"from": "s", "stability": True}}]


@pytest.fixture(scope="module")
def in_speed(tmp_path_factory):
    """The branch in the belt's speed, and the curves of its three points in the speed and the force."""
    plane = {"vb": [0.05, 2], "F": [0.6, 1.6]}
    steps = [
        *STEPS,
        follow("b", "o", {"vb": [0.3, 1.2]}, stability=True),
        *(follow(label, ("b", f"{label}1"), plane) for label in ("GS", "SS", "CS")),
    ]
    return run(
        {**BELT, "run": {"monitors": {"top": "max(v)"}, "mesh": MESH, "steps": steps}},
        tmp_path_factory.mktemp("b") / "a.h5",
    )


def entry(way, om, F, vb):
    """Return by how much the friction needed where v comes to vb, going up or down, exceeds what there is."""
    block = Block(om, {1: F}, vb, 0.4)
    x, t = next((x, t) for kind, t, x in block.follow(100) if kind == way)
    return block.needed(t, x) - 0.4 if way == "up" else block.needed(t, x) + 0.4


def exact(label, F=1.0, om=1.7):
    """Return the belt's speed at each point: the first in closed form, the others from simulations."""
    if label == "GS":
        return F * om / math.hypot(1.0 - om**2, 0.2 * om)
    low, high = (0.75, 0.85) if label == "SS" else (0.49, 0.55)
    return brentq(lambda vb: entry("up" if label == "SS" else "down", om, F, vb), low * F, high * F, xtol=1e-11)


@pytest.mark.parametrize(("label", "error"), [("GS", 1e-12), ("SS", 1e-9), ("CS", 1e-9)])
def test_each_point_is_located_and_named(in_speed, label, error):
    assert parameter(in_speed.step("b"), "vb", f"{label}1") == pytest.approx(exact(label), abs=error)


def test_the_branch_goes_through_all_of_them(in_speed):
    step = in_speed.step("b")
    assert sorted(labels(step)) == ["CS1", "GS1", "SS1"]
    names = [step.orbit(i)["signature"].tobytes().decode() for i in step.order]
    assert list(dict.fromkeys(names)) == [
        "slip_down>slip_below slip_up>slip_above",
        "slip_up>slip_above slip_down>slip_on slip_off_down",
        "slip_up>slip_on slip_off_down",
        "(slip_below)",
    ]
    assert np.all(step.points["verified"] == 1) and np.all(step.points["admissible"] == 1)


def test_multipliers_that_sliding_makes_zero_are_zero(in_speed):
    """A stick forgets where the motion began: of two multipliers one is zero."""
    step = in_speed.step("b")
    for i in step.order:
        if b">slip_on" in step.orbit(i)["signature"].tobytes():
            found = step.orbit(i)["multipliers"]
            assert np.all(np.abs(found[1:]) < 1e-12)


@pytest.mark.parametrize(("label", "error"), [("GS", 3e-12), ("SS", 1e-9), ("CS", 1e-7)])
def test_the_points_are_followed_in_two_parameters(in_speed, label, error):
    step = in_speed.step(label)
    assert step.meta["curve"] == label
    F, vb = parameter(step, "F"), parameter(step, "vb")
    assert max(F) == pytest.approx(1.6, abs=1e-12)
    for k in (np.argmin(F), np.argmax(F)):
        if label == "GS":
            assert vb[k] == pytest.approx(exact("GS", F[k]), abs=error)
            continue
        way = "up" if label == "SS" else "down"
        near = brentq(lambda x, k=k, way=way: entry(way, 1.7, F[k], x), vb[k] - 0.01, vb[k] + 0.01, xtol=1e-11)
        assert vb[k] == pytest.approx(near, abs=error)


@pytest.mark.parametrize(
    ("om", "span", "exact"), [(1.3, [1.2, 1.32], 1.2357471523224), (0.65, [0.63, 0.75], 0.7226791944381)]
)
def test_a_stick_that_vanishes_is_located_as_well_as_where_it_begins(tmp_path, om, span, exact):
    """x'' + 0.1 x' + x = 1.5 cos(om t) - sgn x' turns with just the friction on it: found by bisection."""
    mapping = {
        "name": "turning",
        "states": ["x", "v"],
        "parameters": {"om": om},
        "forcing": {"period": "2*pi/om"},
        "switches": {"slip": "v"},
        "equations": {"x'": "v", "v'": "1.5*cos(om*t) - x - 0.1*v - sign(v)"},
        "initial": {"x": 1, "v": 0.3},
    }
    steps = [*settle(100)[:1], {"name": "o", "orbit": {"from": "t"}}, follow("b", "o", {"om": span})]
    step = run({**mapping, "run": {"mesh": MESH, "steps": steps}}, tmp_path / "a.h5").step("b")
    assert parameter(step, "om", "CS1") == pytest.approx(exact, abs=1e-11)
    assert np.all(step.points["verified"] == 1)


def test_where_a_stick_is_broken_in_two_is_adding_sliding(tmp_path):
    """At om = 0.5 with a fifth harmonic the friction needed while the block sticks has a maximum that reaches mu."""
    mapping = {**BELT, "parameters": {"om": 0.5, "F": 0.3, "G": 0.5, "vb": 0.2, "mu": 0.4}}
    steps = [*STEPS, follow("b", "o", {"G": [0.5, 0.56]}, stability=True)]
    step = run({**mapping, "run": {"mesh": MESH, "steps": steps}}, tmp_path / "a.h5").step("b")

    def excess(G):
        block = Block(0.5, {1: 0.3, 5: G}, 0.2, 0.4)
        events = block.follow(30)
        sticks = [(t, x) for kind, t, x in events if kind == "stick"]
        return max(_top(block, t, x) for t, x in sticks)

    assert parameter(step, "G", "AS1") == pytest.approx(brentq(excess, 0.53, 0.56, xtol=1e-11), abs=1e-8)
    assert np.all(step.points["verified"] == 1)


def _top(block, t, x):
    """Return by how much the friction needed exceeds mu at its highest maximum after t, sticking on as far as 3."""

    def needed(a):
        return block.needed(a, x + block.vb * (a - t))

    s = np.linspace(t, t + 3.0, 301)
    values = np.array([needed(a) for a in s])
    inner = [k for k in range(1, len(s) - 1) if values[k] >= values[k - 1] and values[k] > values[k + 1]]
    k = max(inner, key=lambda k: values[k])
    found = minimize_scalar(
        lambda a: -needed(a), bounds=(s[k - 1], s[k + 1]), method="bounded", options={"xatol": 1e-9}
    )
    return -found.fun - block.mu


SYMMETRIC = {
    **BELT,
    "parameters": {"om": 0.5, "F": 1.5, "G": 0.0, "vb": 0.0, "mu": 1.0},
    "equations": {"x'": "v", "v'": "F*cos(om*t) + G*cos(3*om*t) - x - 0.1*v - mu*sign(v)"},
    "switches": {"slip": "v"},
}


@pytest.mark.parametrize(
    "step", [{}, *({"initial": 0.01, "max": longest} for longest in (0.015, 0.018, 0.02)), {"initial": 0.2, "max": 0.3}]
)
def test_a_symmetric_orbit_that_sticks_anew_on_both_sides_is_named(step, tmp_path):
    """Beyond the point both turns cross the surface first and are drawn back to it."""
    steps = [*STEPS[:1], {"name": "o", "orbit": {"from": "s"}}, follow("b", "o", {"G": [-0.9, 0.2]}, step=step)]
    branch = run({**SYMMETRIC, "run": {"mesh": MESH, "steps": steps}}, tmp_path / "a.h5").step("b")
    assert labels(branch) == ["SS1"]

    def excess(G):
        block = Block(0.5, {1: 1.5, 3: G}, 0.0, 1.0, damping=0.1)
        return min(block.needed(t, x) for kind, t, x in block.follow(40) if kind == "down") + 1.0

    assert parameter(branch, "G", "SS1") == pytest.approx(brentq(excess, -0.7, -0.3, xtol=1e-11), abs=1e-8)
    assert np.all(branch.points["verified"] == 1)


@pytest.mark.parametrize(
    "step", [{}, *({"initial": 0.01, "max": longest} for longest in (0.015, 0.018, 0.02)), {"initial": 0.2, "max": 0.3}]
)
def test_a_step_over_two_points_that_are_close_finds_both(step, tmp_path):
    """With more damping both sticks are broken in two first, and 2e-4 later their first parts are crossings."""
    mapping = change(SYMMETRIC, "equations.v'", "F*cos(om*t) + G*cos(3*om*t) - x - 0.2*v - mu*sign(v)")
    steps = [*STEPS[:1], {"name": "o", "orbit": {"from": "s"}}, follow("b", "o", {"G": [-0.9, 0.2]}, step=step)]
    branch = run({**mapping, "run": {"mesh": MESH, "steps": steps}}, tmp_path / "a.h5").step("b")
    assert labels(branch) == ["CS1", "AS1"]

    def excess(G):
        block = Block(0.5, {1: 1.5, 3: G}, 0.0, 1.0)
        return min(block.needed(t, x) for kind, t, x in block.follow(40) if kind == "down") + 1.0

    assert parameter(branch, "G", "CS1") == pytest.approx(brentq(excess, -0.74, -0.7247, xtol=1e-11), abs=1e-8)
    assert parameter(branch, "G", "AS1") - parameter(branch, "G", "CS1") == pytest.approx(1.965e-4, abs=1e-7)


def test_points_do_not_depend_on_the_steps_that_lead_there(tmp_path):
    """A long step may pass several: the motion ceases at the first, and no zero beyond it counts."""
    mapping = {**BELT, "parameters": {"om": 0.5, "F": 1.0, "G": 0.0, "vb": 0.3, "mu": 0.4}}
    steps = [
        *STEPS[:1],
        {"name": "o", "orbit": {"from": "s"}},
        follow("wide", "o", {"G": [-1, 1]}),
        follow("narrow", "o", {"G": [-0.7, 0.62]}),
    ]
    results = run({**mapping, "run": {"mesh": MESH, "steps": steps}}, tmp_path / "a.h5")
    found = {}
    for name in ("wide", "narrow"):
        step = results.step(name)
        at = parameter(step, "G")
        kept = [(step.labels[i][:2], x) for i, x in zip(step.order, at, strict=True) if step.labels[i]]
        found[name] = [(kind, x) for kind, x in kept if kind != "EP" and -0.7 < x < 0.62]
        assert np.all(step.points["verified"] == 1)
    kinds, values = ([f[k] for f in found["wide"]] for k in (0, 1))
    assert kinds == ["CS", "AS", "AS", "CS", "AS", "SS", "GS", "AS", "CS", "AS", "SS", "AS"]
    assert kinds == [kind for kind, _ in found["narrow"]]
    assert values == pytest.approx([x for _, x in found["narrow"]], abs=1e-8)


def test_an_orbit_may_slide_all_along(tmp_path):
    """On x + y^2/4 = cos t the motion is that of y' = sin t - y: multipliers e^(-2 pi) and 0."""
    mapping = {
        "name": "slide",
        "states": ["x", "y"],
        "forcing": {"period": "2*pi"},
        "switches": {"u": "x + y**2/4 - cos(t)"},
        "equations": {"x'": "-3*sign(x + y**2/4 - cos(t))", "y'": "sin(t) - y"},
        "initial": {"x": 2},
    }
    step = run(
        {**mapping, "run": {"steps": [*settle(40)[:1], {"name": "o", "orbit": {"from": "t", "stability": True}}]}},
        tmp_path / "a.h5",
    ).step("o")
    row = step.orbit(0)
    assert row["signature"].tobytes() == b"(u_on)"
    found = row["multipliers"]
    assert found[0][0] == pytest.approx(math.exp(-2.0 * math.pi), abs=1e-10) and np.all(np.abs(found[1:]) < 1e-14)


def test_brute_force_agrees_with_the_branch_on_both_sides(tmp_path, in_speed):
    sweep = {"over": {"vb": [0.4, 1.0, 13]}, "transient": "60*2*pi/om", "initial": [{"x": 0, "v": 0}]}
    steps = [{"name": "w", "sweep": sweep}]
    found = run({**BELT, "run": {"steps": steps}}, tmp_path / "a.h5").step("w")
    branch = in_speed.step("b")
    vb = parameter(branch, "vb")
    signatures = [branch.orbit(i)["signature"].tobytes().decode() for i in branch.order]
    for i in range(len(found)):
        here = found.points["parameters"][i][3]
        block = Block(1.7, {1: 1.0}, here, 0.4)
        sticks = sum(kind == "stick" for kind, _, _ in block.follow(60))
        names = [found.meta["segments"][k] for k in np.flatnonzero(found.points["n_segments"][i])]
        assert sum(name.endswith(">slip_on") for name in names) == sticks
        assert signatures[np.argmin(np.abs(vb - here))].count(">slip_on") == sticks


def test_along_a_surface_of_delayed_values_a_motion_slides_too(tmp_path):
    """On v = F cos t - K x(t - 1) it is that of x' = F cos t - K x(t - 1), as long as friction A can hold it there."""
    K, F = 0.9, 0.5
    u = "v + K*x(t - tau) - F*cos(t)"
    mapping = {
        "name": "held",
        "states": ["x", "v"],
        "parameters": {"K": K, "tau": 1.0, "F": F, "A": 4},
        "forcing": {"period": "2*pi"},
        "switches": {"u": u},
        "equations": {"x'": "v", "v'": f"-x - 0.1*v - A*sign({u})"},
        "initial": {"x": 1},
    }
    steps = [
        {"name": "s", "simulate": {"t_end": "80*2*pi"}},
        {"name": "o", "orbit": {"from": "s", "stability": True}},
        follow("b", "o", {"A": [0.02, 4]}, stability=True),
    ]
    more = {"mesh": MESH, "monitors": {"top": "max(x)"}, "steps": steps}
    results = run({**mapping, "run": more}, tmp_path / "a.h5")
    orbit, branch = results.step("o"), results.step("b")
    X = F / (1j + K * np.exp(-1j))
    assert orbit.orbit(0)["signature"].tobytes() == b"(u_on)"
    assert orbit.points["monitors"][0][0] == pytest.approx(abs(X), abs=1e-12)
    found = multipliers(orbit)
    pair = np.exp(2.0 * math.pi * lambertw(-K, [0, -1]))
    assert sorted(found[:2], key=np.imag) == pytest.approx(sorted(pair, key=np.imag), abs=1e-10)
    # The motion leaves where the friction that it needs reaches A.
    needed = -X - 0.1j * X - 1j * F + 1j * K * X * np.exp(-1j)
    assert parameter(branch, "A", "AS1") == pytest.approx(abs(needed), abs=1e-10)
    assert np.all(branch.points["verified"] == 1)
