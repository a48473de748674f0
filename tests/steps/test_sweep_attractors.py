"""What a sweep calls an attractor: its period, size and exponent, where motions are stiff, fast or chaotic."""

import numpy as np
import pytest

from pddecont.tables.attractors import list_attractors, list_returns, name_motion
from tests.runs import change, run


def test_a_map_without_period_is_told_and_has_a_positive_exponent(tmp_path):
    """At every whole t: y = r y (1 - y), the logistic map; its exponent at r = 4 is ln 2 a return."""
    text = {
        "name": "m",
        "states": ["y"],
        "parameters": {"r": 4, "w": 1},
        "forcing": {"period": "w"},
        "modes": {"m": {"y'": 0}},
        "events": {"tick": "sin(2*pi*t)"},
        "resets": {"fold": {"y": "r*y*(1 - y)"}},
        "segments": {"s": {"mode": "m", "event": "tick", "direction": "rising", "reset": "fold", "to": "m"}},
        "initial": {"y": 0.3},
        "run": {
            "steps": [
                {
                    "name": "diagram",
                    "sweep": {
                        "over": {"r": [3.2, 4, 2]},
                        "section": {"phase": 0.5},
                        "transient": 2000,
                        "returns": 300,
                        "lyapunov": True,
                    },
                }
            ]
        },
    }
    step = run(text, tmp_path / "l.h5").steps["diagram"]
    assert list(step.points["period"]) == [2, 0]
    assert name_motion(step, 1) == "no period"
    assert step.points["lyapunov"][1] == pytest.approx(np.log(2.0), abs=0.02)
    # r = 3.2: the period-2 points are the roots of r^2 y^2 - r (r + 1) y + r + 1, the exponent ln |4 + 2 r - r^2| / 2.
    assert step.points["lyapunov"][0] == pytest.approx(np.log(abs(4 + 6.4 - 3.2**2)) / 2, abs=1e-6)
    y = [r["y"] for r in list_returns(step) if r["label"] == "A1"]
    assert sorted(y) == pytest.approx(sorted(np.roots([3.2**2, -3.2 * 4.2, 4.2])), abs=1e-6)


LINEAR = {
    "name": "m",
    "states": ["x", "v"],
    "parameters": {"w": 1.2, "c": 0.02},
    "forcing": {"period": "2*pi"},
    "modes": {"m": {"x'": "v", "v'": "-w**2*x - c*v + cos(t)"}},
    "initial": {"x": 1},
    "run": {"steps": [{"name": "diagram", "sweep": {"over": {"w": [1.2, 1.5, 13]}, "transient": "4000*2*pi"}}]},
}


@pytest.mark.parametrize(("c", "n"), [(0.02, 4000), (0.1, 1000), (0.02, 300)])
def test_a_linear_oscillator_has_period_1_however_its_multipliers_turn(tmp_path, c, n):
    """Multipliers near a root of 1 make a multiple of the period look settled first."""
    text = change(change(LINEAR, "parameters.c", c), "run.steps.0.sweep.transient", f"{n}*2*pi")
    step = run(text, tmp_path / "l.h5").steps["diagram"]
    settled = step.points["period"][[bool(label) for label in step.labels]]
    assert np.all(settled == 1)
    assert len(settled) == 13 or n == 300
    for i in range(len(step)):
        if step.labels[i]:
            w = step.points["parameters"][i, 0]
            # x = Re(e^(it) / (w^2 - 1 + i c)) at t = 0.
            assert step.orbit(i)["returns"][0, 0] == pytest.approx((1 / (w**2 - 1 + 1j * c)).real, rel=1e-3)


def test_a_section_where_the_state_is_always_the_same_tells_by_slopes(tmp_path):
    """Wright's equation is settled at an equilibrium below alpha = pi/2, and its period above it grows with alpha."""
    text = {
        "model": "wright",
        "steps": [
            {
                "name": "diagram",
                "sweep": {
                    "over": {"alpha": [1.2, 2.0, 5]},
                    "section": {"zero": "x"},
                    "transient": 400,
                    "initial": [{"x": 0.5}],
                },
            },
            {
                "name": "up",
                "sweep": {
                    "over": {"alpha": [1.8, 2.0, 2]},
                    "section": {"zero": "x"},
                    "carry": "up",
                    "transient": 400,
                    "initial": [{"x": 0.5}],
                },
            },
        ],
    }
    results = run(text, tmp_path / "w.h5")
    step = results.steps["diagram"]
    assert [bool(label) for label in step.labels] == [False, False, True, True, True]
    assert all("dies away" in r["note"] or "not settled" in r["note"] for r in list_attractors(step)[:2])
    assert step.points["turn"][-1] == pytest.approx(4.4027436513, rel=1e-6)
    assert results.steps["up"].points["turn"] == pytest.approx(step.points["turn"][-2:], rel=1e-6)


def test_the_size_of_a_motion_is_that_of_where_it_is(tmp_path):
    """x' = -0.01 x + cos t from x = 1e6 and from 0: one attractor, x = 0.01 / (1e-4 + 1) at t = 0."""
    text = {
        "name": "m",
        "states": ["x"],
        "parameters": {"a": 0.01},
        "forcing": {"period": "2*pi"},
        "modes": {"m": {"x'": "-a*x + cos(t)"}},
        "run": {
            "steps": [
                {
                    "name": "diagram",
                    "sweep": {
                        "over": {"a": [0.01, 0.01, 1]},
                        "transient": "2000*2*pi",
                        "initial": [{"x": 1000000.0}, {"x": 0}],
                        "lyapunov": True,
                    },
                }
            ]
        },
    }
    step = run(text, tmp_path / "f.h5").steps["diagram"]
    assert (len(step), step.points["share"][0]) == (1, 1.0)
    assert step.orbit(0)["returns"][0, 0] == pytest.approx(0.01 / (1e-4 + 1), rel=1e-5)
    assert step.points["lyapunov"][0] == pytest.approx(-0.01, abs=1e-6)


def test_a_fast_decay_has_its_exponent(tmp_path):
    text = {
        "name": "m",
        "states": ["x"],
        "parameters": {"k": 60},
        "forcing": {"period": "2*pi"},
        "modes": {"m": {"x'": "-k*x + cos(t)"}},
        "run": {
            "steps": [
                {"name": "diagram", "sweep": {"over": {"k": [2, 60, 2]}, "transient": "1000*2*pi", "lyapunov": True}}
            ]
        },
    }
    step = run(text, tmp_path / "k.h5").steps["diagram"]
    assert step.points["lyapunov"] == pytest.approx([-2.0, -60.0], rel=1e-6)


def test_what_grows_or_has_not_settled_is_no_attractor(tmp_path):
    text = {
        "name": "m",
        "states": ["x"],
        "parameters": {"k": 0.1},
        "forcing": {"period": "2*pi"},
        "modes": {"m": {"x'": "k*x + cos(t)"}},
        "run": {
            "steps": [
                {
                    "name": "diagram",
                    "sweep": {"over": {"k": [-0.001, 0.02, 2]}, "transient": "60*2*pi", "initial": [{"x": 1}]},
                }
            ]
        },
    }
    step = run(text, tmp_path / "g.h5").steps["diagram"]
    assert step.labels == ("", "")
    assert all("not settled" in r["note"] for r in list_attractors(step))


def test_a_forced_motion_keeps_its_phase_at_a_section_of_its_own(tmp_path):
    """Returns counted where v = 0 falls: the orbit from a label, and from the same motion counted by the forcing."""
    text = {
        "model": "duffing",
        "mesh": {"degree": 8, "tol": 1e-09},
        "monitors": {"top": "max(x)"},
        "steps": [
            {
                "name": "a",
                "sweep": {
                    "over": {"omega": [1.1, 1.3, 3]},
                    "section": {"zero": "v", "direction": "falling"},
                    "carry": "up",
                    "transient": 3000,
                },
            },
            {"name": "b", "sweep": {"over": {"omega": [1.1, 1.3, 3]}, "carry": "up", "transient": 3000}},
            {"name": "oa", "orbit": {"from": {"step": "a", "point": "A2"}}},
            {"name": "ob", "orbit": {"from": {"step": "b", "point": "A2"}}},
        ],
    }
    results = run(text, tmp_path / "d.h5")
    a, b = (results.steps[name].points["monitors"][0, 0] for name in ("oa", "ob"))
    assert a == pytest.approx(b, abs=1e-7)
    assert results.steps["a"].points["turn"] == pytest.approx(results.steps["b"].points["turn"], rel=1e-6)


def test_a_stiff_forced_motion_of_large_size_has_its_period(tmp_path):
    """x' = 40 x (1 - x/L) + sin 2 pi t: errors of x relative to its size are no motion of its slopes."""
    text = {
        "name": "m",
        "states": ["x"],
        "parameters": {"L": 10000},
        "forcing": {"period": 1},
        "modes": {"m": {"x'": "40*x*(1 - x/L) + sin(2*pi*t)"}},
        "run": {
            "steps": [
                {
                    "name": "diagram",
                    "sweep": {
                        "over": {"L": [10000.0, 1000000.0, 2]},
                        "transient": 200,
                        "initial": [{"x": 1}, {"x": 5000}],
                    },
                }
            ]
        },
    }
    step = run(text, tmp_path / "l.h5").steps["diagram"]
    assert list(step.points["period"]) == [1, 1]
    assert list(step.points["share"]) == [1.0, 1.0]


def test_an_orbit_starts_from_an_attractor_with_one_event(tmp_path):
    """x' = 1 - x, s' = 1, at s = 1: x/2, s = 0: after the event always one state, x = (1 - 1/e)/(2 - 1/e)."""
    text = {
        "name": "m",
        "states": ["x", "s"],
        "parameters": {"r": 2},
        "modes": {"m": {"x'": "1 - x", "s'": 1}},
        "events": {"tick": "s - 1"},
        "resets": {"halve": {"x": "x/r", "s": 0}},
        "segments": {"a": {"mode": "m", "event": "tick", "direction": "rising", "reset": "halve", "to": "m"}},
        "run": {
            "steps": [
                {
                    "name": "diagram",
                    "sweep": {"over": {"r": [2, 3, 2]}, "section": {"event": "tick"}, "transient": 200},
                },
                {"name": "o", "orbit": {"from": {"step": "diagram", "point": "A1"}}},
            ]
        },
    }
    results = run(text, tmp_path / "o.h5")
    assert list(results.steps["diagram"].points["period"]) == [1, 1]
    assert results.steps["o"].points["period"][0] == pytest.approx(1.0, abs=1e-10)
    x = (1 - np.exp(-1)) / (2 - np.exp(-1))
    assert results.steps["o"].orbit(0)["states"][0, 0] == pytest.approx(x, abs=1e-8)


@pytest.mark.parametrize(("tau", "n"), [(1.2, 1), (1.45, 2), (1.62, 4)])
def test_an_orbit_starts_from_an_attractor_of_several_passages(tmp_path, tau, n):
    """A smooth equation whose orbits double at tau = 1.325 and 1.579: no event tells how far the period is."""
    sweep = {"over": {"tau": [tau, tau + 1e-3, 2]}, "transient": 3000, "section": {"zero": "x - 0.9"}}
    steps = [
        {"name": "diagram", "sweep": sweep},
        {"name": "orbit", "orbit": {"from": {"step": "diagram", "point": "A1"}}},
    ]
    steps = run({"model": "mackey_glass", "steps": steps}, tmp_path / "a.h5").steps
    assert steps["diagram"].points["period"][0] == n
    assert steps["orbit"].points["period"][0] == pytest.approx(steps["diagram"].points["turn"][0], rel=1e-6)


def test_chaos_is_an_attractor(tmp_path):
    text = {
        "name": "m",
        "states": ["x", "v"],
        "parameters": {"F": 0.32},
        "forcing": {"period": "2*pi/1.2"},
        "modes": {"m": {"x'": "v", "v'": "x - x**3 - 0.3*v + F*cos(1.2*t)"}},
        "run": {
            "steps": [
                {
                    "name": "diagram",
                    "sweep": {"over": {"F": [0.32, 0.44, 2]}, "transient": "2000*2*pi/1.2", "lyapunov": True},
                }
            ]
        },
    }
    step = run(text, tmp_path / "c.h5").steps["diagram"]
    assert step.labels == ("A1", "A2")
    assert np.all(step.points["period"] == 0)
    assert np.all(step.points["lyapunov"] > 0.05)


def test_a_motion_that_starts_on_its_section(tmp_path):
    text = {
        "name": "m",
        "states": ["x", "v"],
        "parameters": {"c": 0.05},
        "forcing": {"period": "2*pi"},
        "modes": {"m": {"x'": "v", "v'": "-1.1*x - c*v + cos(t)"}},
        "run": {
            "steps": [
                {
                    "name": "diagram",
                    "sweep": {"over": {"c": [0.05, 0.06, 2]}, "section": {"zero": "x"}, "transient": 3000},
                }
            ]
        },
    }
    step = run(text, tmp_path / "s.h5").steps["diagram"]
    assert list(step.points["period"]) == [1, 1]
    assert step.points["turn"] == pytest.approx([2 * np.pi] * 2, rel=1e-6)
