"""Grazing from both sides, soft and hard.

A hard wall makes the impact speed grow like the square root of the distance in the parameter; a soft one makes contact
grow so. The free orbit is linear, so the grazing has a closed form, and so has each orbit that touches the hard wall
once a period.
"""

import math

import numpy as np
import pytest
from scipy.optimize import root

from tests.hard.linear import Oscillator
from tests.runs import add_step, labels, multipliers, parameter, run

GAINS = {"free": ["K"], "range": {"K": [0.15, 0.3]}}
SOFT = {
    "model": "impact_oscillator",
    "mesh": {"degree": 9, "tol": 1e-11},
    "monitors": {"contact": "time_in(C)", "speed": "at(NC, v)"},
    "steps": [
        {"name": "t", "set": {"K": 0.3}, "simulate": {"t_end": "60*2*pi/omega"}},
        {"name": "free", "set": {"K": 0.3}, "orbit": {"from": "t"}},
        {"name": "down", "continue": {"from": "free", **GAINS, "direction": "down"}},
        {"name": "hits", "orbit": {"from": {"step": "down", "point": "EP1"}}},
        {"name": "up", "continue": {"from": "hits", **GAINS, "direction": "up"}},
    ],
}
GRAZING_K = 0.1774776777
HARD = {
    "name": "hard",
    "states": ["x", "v"],
    "parameters": {"w": 2.2, "c": 0.4, "wall": 0.3, "r": 0.7},
    "forcing": {"period": "2*pi/w"},
    "modes": {"free": {"x'": "v", "v'": "cos(w*t) - c*v - x"}},
    "events": {"hit": "x - wall"},
    "resets": {"bounce": {"v": "-r*v"}},
    "segments": {"flight": {"mode": "free", "event": "hit", "direction": "rising", "reset": "bounce", "to": "free"}},
    "run": {
        "mesh": {"degree": 9, "tol": 1e-11},
        "steps": [
            {"name": "t", "simulate": {"t_end": "60*pi"}},
            {"name": "o", "orbit": {"from": "t"}},
            {
                "name": "c",
                "continue": {
                    "from": "o",
                    "free": ["wall"],
                    "range": {"wall": [0.0, 0.5]},
                    "direction": "down",
                    "step": {"initial": 0.002},
                    "stability": {"multipliers": 2},
                },
            },
        ],
    },
}
SWING = 1 / math.hypot(1 - 2.2**2, 0.4 * 2.2)


def test_soft_from_both_sides(tmp_path, record):
    """Free orbits meet the wall (GR) at the parameter at which impacting ones leave it (VS), in closed form."""
    results = run(SOFT, tmp_path / "a.h5")
    down, up = results.step("down"), results.step("up")
    assert {labels(down)[0][:2], labels(down)[-1][:2]} <= {"GR", "PD"}
    record("soft wall met from the free side", "closed form", abs(parameter(down, "K", "GR1") - GRAZING_K), 1e-9)
    assert "VS1" in labels(up)
    record("soft wall left from the impacting side", "closed form", abs(parameter(up, "K", "VS1") - GRAZING_K), 1e-9)
    touching = [
        i
        for i in range(len(up))
        if up.orbit(i)["signature"].tobytes() == b"NC C" and up.points["parameters"][i, -2] > 0.17
    ]
    K, speed = up.points["parameters"][touching, -2], up.points["monitors"][touching, 1]
    near = GRAZING_K - K < 2e-3
    assert near.sum() >= 3
    order = np.polyfit(np.log(GRAZING_K - K[near]), np.log(speed[near]), 1)[0]
    record("order of the impact speed in the distance from grazing, soft", "1/2", abs(order - 0.5), 0.05)


def hard_orbits(wall, speed):
    """Return the nearest exact impact speed of an orbit with one impact a period and that speed or so."""
    period, flight = 2 * math.pi / 2.2, Oscillator(0.4, 1.0, w=2.2)

    def miss(unknowns):
        return flight.flow(unknowns[1], [wall, -0.7 * unknowns[0]], period) - [wall, unknowns[0]]

    begin = min(np.linspace(0, period, 400), key=lambda s: np.linalg.norm(miss([speed, s])))
    return root(miss, [speed, begin], tol=1e-14).x[0]


@pytest.fixture(scope="module")
def hard(tmp_path_factory):
    up = {"from": {"step": "c", "point": "EP1"}, "free": ["wall"], "range": {"wall": [0.0, 0.5]}, "direction": "up"}
    return run(add_step(HARD, {"name": "up", "continue": up}), tmp_path_factory.mktemp("hard") / "a.h5")


def test_hard_from_both_sides(hard, record):
    """The free orbit grazes where its swing is the wall's place; the family that hits the wall ends there, seen from
    its own side.
    """
    down, up = hard.step("c"), hard.step("up")
    assert labels(down) == ["PD1", "GR1"]
    record("hard wall met from the free side", "closed form", abs(parameter(down, "wall", "GR1") - SWING), 1e-10)
    record("hard wall left from the side that hits it", "closed form", abs(parameter(up, "wall", "VS1") - SWING), 1e-10)


def test_orbits_that_hit_the_hard_wall(hard, record):
    step = hard.step("c")
    hits = [i for i in step.order if step.orbit(i)["signature"].tobytes() == b"flight" and not step.labels[i]]
    walls = step.points["parameters"][hits, 2]
    speeds = np.array([step.orbit(i)["states"][-1, 1] for i in hits])
    exact = np.array([hard_orbits(w, s) for w, s in zip(walls, speeds, strict=True)])
    record("speeds of the family that hits the hard wall", "exact pieces", np.max(np.abs(speeds - exact)), 1e-9)
    both = np.array([multipliers(step, i)[:2] for i in hits])
    product = np.prod(both, axis=1)
    record(
        "product of its multipliers",
        "r^2 exp(-c T)",
        np.max(np.abs(product / (0.49 * math.exp(-0.8 * math.pi / 2.2)) - 1)),
        1e-9,
    )
    order = np.polyfit(np.log(speeds[-5:]), np.log(np.max(np.abs(both[-5:]), axis=1)), 1)[0]
    record("order of its leading multiplier in the impact speed", "-1: the map's square root", abs(order + 1), 0.02)
