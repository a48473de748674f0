"""Orbits with 40 segments.

Twenty and twenty kicks a period: x' = -x + cos(2 pi t), at twenty moments x -> q x, at twenty between them x -> x +
kick. One period is an affine map.
"""

import math

import numpy as np

from tests.runs import labels, multipliers, parameter, run

MODEL = {
    "name": "kicks",
    "states": ["x"],
    "parameters": {"q": 0.9, "kick": 0.05},
    "forcing": {"period": 1},
    "modes": {"m": {"x'": "cos(2*pi*t) - x"}},
    "events": {"even": "sin(40*pi*t)", "odd": "cos(40*pi*t)"},
    "resets": {"shrink": {"x": "q*x"}, "push": {"x": "x + kick"}},
    "segments": {
        "shrink": {"mode": "m", "event": "even", "direction": "rising", "reset": "shrink", "to": "m"},
        "push": {"mode": "m", "event": "odd", "direction": "rising", "reset": "push", "to": "m"},
    },
    "initial": {"x": 0.1},
    "run": {
        "mesh": {"degree": 5, "tol": 1e-11},
        "monitors": {"highest": "max(x)", "lowest": "min(x)"},
        "steps": [
            {"name": "t", "simulate": {"t_end": 10}},
            {"name": "o", "orbit": {"from": "t", "stability": True}},
            {"name": "c", "continue": {"from": "o", "free": ["q"], "range": {"q": [0.8, 1.0]}, "stability": True}},
        ],
    },
}


def after(x, start, duration):
    """Return x a ``duration`` after ``start``."""
    w = 2 * math.pi

    def forced(t):
        return (math.cos(w * t) + w * math.sin(w * t)) / (1 + w**2)

    return forced(start + duration) + (x - forced(start)) * math.exp(-duration)


def values(q, kick):
    """Return x just before and after each event of the periodic motion, shrinking at k/20, pushed at k/20 + 3/80."""

    def turn(x):
        seen = []
        for k in range(20):
            seen.append(x)
            x = q * x
            seen.append(x)
            x = after(x, k / 20, 3 / 80)
            seen.append(x)
            x += kick
            seen.append(x)
            x = after(x, k / 20 + 3 / 80, 1 / 80)
        return x, seen

    at_zero, at_one = turn(0.0)[0], turn(1.0)[0]
    return turn(at_zero / (1 - (at_one - at_zero)))[1]


def test_forty_segments(tmp_path, record):
    results = run(MODEL, tmp_path / "a.h5")
    step = results.step("o")
    assert len(step.orbit(0)["signature"].tobytes().split()) == 40
    assert step.points["admissible"][0] == 1
    rows = step.orbit(0)
    exact = np.array(values(0.9, 0.05))
    ends = np.array([rows["states"][rows["segment"] == s][[-1, 0], 0] for s in range(40)]).ravel()
    record("40 segments: states at all events", "affine map", np.max(np.abs(np.sort(ends) - np.sort(exact))), 1e-11)
    record("40 segments: multiplier", "q^20 / e", abs(multipliers(step)[0] / (0.9**20 / math.e) - 1), 1e-9)
    branch = results.step("c")
    assert labels(branch) == []
    worst = 0.0
    for i, q in zip(branch.order, parameter(branch, "q"), strict=True):
        states = branch.orbit(i)["states"][:, 0]
        exact = np.array(values(q, 0.05))
        worst = max(worst, abs(states.max() - exact.max()), abs(states.min() - exact.min()))
        worst = max(worst, abs(multipliers(branch, i)[0] - q**20 / math.e))
    record("40 segments along a branch: extremes and multiplier", "affine map", worst, 1e-9)
