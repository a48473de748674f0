"""Wall stiffness from 1 to 1e8.

The wall is a spring and a damper of the same damping ratio at every stiffness, so that it returns the same share of
speed: the limit is the hard wall with Newton's law of restitution. Every orbit is put together from the exact motions
of its two linear pieces.
"""

import math

import numpy as np
import pytest
from scipy.optimize import root

from tests.hard.linear import Oscillator
from tests.problems import WALL
from tests.runs import labels, monitor, parameter, run

RESTITUTION = 0.8
RATIO = -math.log(RESTITUTION) / math.hypot(math.pi, math.log(RESTITUTION))
MODEL = {
    "name": "wall",
    "states": ["x", "v"],
    "parameters": {"digits": 4, "c": 0.1, "wall": 0.2, "ratio": RATIO},
    "forcing": {"period": "pi"},
    "definitions": {"force": "cos(2*t) - c*v - x", "beta": "10**digits"},
    "modes": {
        "free": {"x'": "v", "v'": "force"},
        "contact": {"x'": "v", "v'": "force - beta*(x - wall) - 2*ratio*sqrt(beta)*v"},
    },
    "events": {"touch": "x - wall"},
    "segments": {
        "free": {"mode": "free", "event": "touch", "direction": "rising", "to": "contact"},
        "contact": {"mode": "contact", "event": "touch", "direction": "falling", "to": "free"},
    },
    "run": {
        "mesh": {"degree": 8, "tol": 1e-11},
        "monitors": {"contact_time": "time_in(contact)", "v_in": "at(free, v)", "v_out": "at(contact, v)"},
        "steps": [
            {"name": "t", "simulate": {"t_end": "100*pi"}},
            {"name": "o", "orbit": {"from": "t"}},
            {
                "name": "c",
                "continue": {"from": "o", "free": ["digits"], "range": {"digits": [0, 8]}, "step": {"max": 0.3}},
            },
        ],
    },
}


def exact(beta, contact_time, v_in, v_out):
    """Return the same numbers from the exact pieces, found near those given."""
    free, hard = (
        Oscillator(0.1, 1.0, w=2.0),
        Oscillator(0.1 + 2 * RATIO * math.sqrt(beta), 1.0 + beta, b=0.2 * beta, w=2.0),
    )
    scale = np.array([contact_time, abs(v_in), 1.0])

    def miss(unknowns):
        duration, speed, start = unknowns * scale
        left = hard.flow(start, [0.2, speed], duration)
        back = free.flow(start + duration, left, math.pi - duration)
        return [(left[0] - 0.2) / contact_time, back[0] - 0.2, back[1] - speed]

    begin = min(np.linspace(0, math.pi, 400), key=lambda s: np.linalg.norm(miss(np.array([1.0, np.sign(v_in), s]))))
    found = root(miss, [1.0, np.sign(v_in), begin], tol=1e-14)
    duration, speed, start = found.x * scale
    return duration, speed, hard.flow(start, [0.2, speed], duration)[1]


@pytest.fixture(scope="module")
def branch(tmp_path_factory):
    return run(MODEL, tmp_path_factory.mktemp("wall") / "a.h5").step("c")


def test_every_stiffness_against_the_exact_pieces(branch, record):
    digits = parameter(branch, "digits")
    assert (digits[0], digits[-1]) == pytest.approx((0, 8))
    assert labels(branch) == []
    worst = 0.0
    for row in branch.order:
        beta = 10 ** branch.points["parameters"][row, 0]
        numbers = branch.points["monitors"][row]
        worst = max(worst, np.max(np.abs(numbers / exact(beta, *numbers) - 1)))
    record("contact time and speeds, stiffness 1 to 1e8", "exact pieces", worst, 1e-8)
    assert np.max(branch.points["error_estimate"]) < 1e-9


def test_the_hard_wall_is_the_limit(branch, record):
    digits, time = parameter(branch, "digits"), monitor(branch, "contact_time")
    stiff = digits > 6
    limit = math.pi / np.sqrt(10 ** digits[stiff] * (1 - RATIO**2))
    record(
        "contact time, stiffness above 1e6",
        "pi / sqrt(beta (1 - ratio^2))",
        np.max(np.abs(time[stiff] / limit - 1)),
        1e-2,
    )
    gap = np.abs(monitor(branch, "v_out") / WALL["v_out"] - 1)
    order = np.polyfit(digits[stiff], np.log10(gap[stiff]), 1)[0]
    record("order of the gap to the hard wall in stiffness", "-1/2", abs(order + 0.5), 0.02)
    softness = 10 ** (-digits[stiff] / 2)
    limit = np.polynomial.Polynomial.fit(softness, monitor(branch, "v_out")[stiff], 3)(0.0)
    record("speed after contact, extrapolated in beta^(-1/2)", "hard wall", abs(limit / WALL["v_out"] - 1), 1e-7)
