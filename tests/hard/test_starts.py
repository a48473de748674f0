"""Events at the very start, and surfaces left tangentially."""

import math

import numpy as np
import pytest
from scipy.optimize import root

from pddecont.delay import Direct
from pddecont.errors import ConvergenceError
from pddecont.orbit import is_rotation
from pddecont.simulate import Method, simulate
from tests.conftest import numeric_from
from tests.hard.linear import Oscillator
from tests.runs import labels, parameter, run

BALL = """
name: ball
states: [y, v]
parameters: {g: 9.81, r: 0.8, tau: 0.3, K: 0}
modes: {flight: {y': v, v': -g + K*v(t - tau)}}
events: {landing: y}
resets: {bounce: {v: -r*v}}
segments: {hop: {mode: flight, event: landing, direction: falling, reset: bounce, to: flight}}
initial: {y: 0, v: 3}
"""


@pytest.mark.parametrize(("v", "landings"), [(3.0, 1), (-3.0, 2), (0.0, None)])
def test_a_ball_that_starts_on_the_floor(v, landings, record):
    """Thrown up it lands after 2 v / g; thrown down it bounces at once; at rest its impacts accumulate at once."""
    numeric = numeric_from(BALL)
    if landings is None:
        with pytest.raises(ConvergenceError, match=r"accumulate at t = 0 \(Zeno\)"):
            simulate(numeric, numeric.parameter_values, Direct(), 0.5, initial=[0.0, v])
        record("ball at rest on the floor", "refused: impacts accumulate at t = 0", 0, 0)
        return
    up = v if v > 0 else -0.8 * v
    first = 2 * up / 9.81
    path = simulate(numeric, numeric.parameter_values, Direct(), first * 1.01, initial=[0.0, v])
    times = path.events.t
    assert len(times) == landings
    expected = [first] if v > 0 else [0.0, first]
    record(
        f"ball thrown {'up' if v > 0 else 'down'} from the floor", "2 v / g", np.max(np.abs(times - expected)), 1e-12
    )


def test_a_jump_between_history_and_start(record):
    """x' = -x(t - 1), history 1, x(0) = 2: the jump at t = 0 comes back as a kink at 1; x(2) = x(1) - int_0^1 (2 - s) =
    1 - 3/2.
    """
    numeric = numeric_from(
        "name: m\nstates: [x]\nparameters: {tau: 1}\nmodes: {m: {x': -x(t - tau)}}\ninitial: {x: 1}\n"
    )
    path = simulate(numeric, numeric.parameter_values, Direct(), 2.0, Method(1e-12, 1e-14), initial=[2.0])
    record("history that jumps at the start", "method of steps", abs(path(2.0)[0] + 0.5), 1e-12)


STICK = {
    "name": "stops",
    "states": ["x", "v"],
    "parameters": {"omega": 0.32, "F": 0.45},
    "forcing": {"period": "2*pi/omega"},
    "definitions": {"push": "cos(omega*t) - x"},
    "modes": {
        "forth": {"x'": "v", "v'": "push - F"},
        "back": {"x'": "v", "v'": "push + F"},
        "held": {"x'": 0, "v'": 0},
        "stuck": {"x'": 0, "v'": 0},
    },
    "events": {"stop": "v", "slip_forth": "push - F", "slip_back": "push + F"},
    "resets": {"still": {"v": 0}},
    "segments": {
        "forth": {"mode": "forth", "event": "stop", "direction": "falling", "reset": "still", "to": "held"},
        "hold": {"mode": "held", "event": "slip_back", "direction": "falling", "reset": "still", "to": "back"},
        "back": {"mode": "back", "event": "stop", "direction": "rising", "reset": "still", "to": "stuck"},
        "stick": {"mode": "stuck", "event": "slip_forth", "direction": "rising", "reset": "still", "to": "forth"},
    },
    "initial": {"mode": "stuck", "x": 0, "v": 0},
    "run": {
        "mesh": {"degree": 9, "tol": 1e-11},
        "monitors": {"amplitude": "amplitude(x)", "held": "time_in(held)"},
        "steps": [
            {"name": "t", "simulate": {"t_end": "40*2*pi/omega"}},
            {"name": "o", "orbit": {"from": "t", "stability": True}},
            {"name": "c", "continue": {"from": "o", "free": ["F"], "range": {"F": [0.4, 0.6]}}},
        ],
    },
}


def stops(F, omega=0.32):
    """Return amplitude and time at rest of the motion with two stops a period: from rest at -A until the speed is zero
    at +A.
    """

    def miss(unknowns):
        A, start, move = unknowns
        forth = Oscillator(0.0, 1.0, -F, 1.0, omega)
        return [math.cos(omega * start) + A - F, *(forth.flow(start, [-A, 0.0], move) - [A, 0.0])]

    best = None
    for A in np.linspace(0.2, 2.5, 30):
        for move in np.linspace(1.0, math.pi / omega, 12):
            if abs(F - A) >= 1:
                continue
            start = -math.acos(F - A) / omega
            found = root(miss, [A, start, move], tol=1e-14)
            A_, start_, move_ = found.x
            inside = 0 < move_ < math.pi / omega and A_ > 0.05 and np.sin(omega * start_) < 0
            if found.success and inside and (best is None or move_ < best[1]):
                best = A_, move_
    return best[0], math.pi / omega - best[1]


def test_an_orbit_that_leaves_its_surfaces_tangentially(tmp_path, record):
    """Dry friction with two stops: each slip begins with v = 0 and v' = 0, on the very surface that ends it."""
    results = run(STICK, tmp_path / "a.h5")
    step = results.step("o")
    assert is_rotation(step.orbit(0)["signature"].tobytes().decode().split(), ["forth", "hold", "back", "stick"])
    assert step.points["admissible"][0] == 1
    exact = stops(0.45)
    record("dry friction with two stops", "exact pieces", np.max(np.abs(step.points["monitors"][0] - exact)), 1e-10)
    branch = results.step("c")
    assert labels(branch) == []
    assert parameter(branch, "F")[[0, -1]] == pytest.approx([0.4, 0.6])
    errors = [
        np.max(np.abs(branch.points["monitors"][i] - stops(branch.points["parameters"][i, 1]))) for i in branch.order
    ]
    record("the same followed in friction", "exact pieces", max(errors), 1e-9)
