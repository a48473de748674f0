"""Cases with friction and with a ramp, written as equations: modes, events and sliding are made of them."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.models.method_of_steps import Motion, same
from tests.runs import change, labels, monitor, parameter, run

# Forced dry friction with delayed control, as in friction_stick.yaml.
FRICTION = {
    "name": "friction",
    "states": ["x", "v"],
    "parameters": {"omega": 0.5, "a": 1, "F": 0.4, "K": 0.1, "tau": 0.6},
    "definitions": {"pull": "a*cos(omega*t) - x + K*(x(t - tau) - x)"},
    "forcing": {"period": "2*pi/omega"},
    "switches": {"slip": "v"},
    "equations": {"x'": "v", "v'": "pull - F*sign(v)"},
    "initial": {"x": 0, "v": 0},
    "run": {
        "mesh": {"degree": 8, "tol": 1e-10},
        "monitors": {"x_max": "max(x)", "stuck": "time_in(slip_on)"},
        "steps": [
            {"name": "t", "simulate": {"t_end": "100*2*pi/omega"}},
            {"name": "o", "orbit": {"from": "t"}},
            {"name": "c", "continue": {"from": "o", "free": ["omega"], "range": {"omega": [0.3, 0.9]}}},
        ],
    },
}
BUCK = {
    "name": "buck",
    "states": ["v", "i"],
    "parameters": {"E": 33, "R": 22, "C": 47e-6, "L": 0.02, "T": 4e-4, "gamma": 11.75238, "rise": 0.5238096},
    "forcing": {"period": "T"},
    "definitions": {"excess": "v - gamma - rise*mod(t, T)/T"},
    "switches": {"cut": "excess"},
    "equations": {"v'": "(i - v/R)/C", "i'": "(E*heaviside(-excess) - v)/L"},
    "initial": {"v": 12, "i": 0.5},
}


def without_sticking(omega, n_terms=4001, a=1.0, F=0.4, K=0.1, tau=0.6):
    """Return the size of (cos, sin) of the forcing's phase where the motion turns upwards with just the friction on it.

    The friction is a square wave, its answer a Fourier series in odd harmonics; less 1 it is zero where sticking
    begins. The series of the speed ends as that of -1/(n omega)^2, whose sum is known.
    """
    n = np.arange(1, n_terms, 2)
    D = 1 + K - K * np.exp(-1j * n * omega * tau) - (n * omega) ** 2
    speed = omega * (np.sum((1 / D).real + 1 / (n * omega) ** 2) - np.pi**2 / (8 * omega**2))
    here = np.sum((1 / D).imag / n)
    late = np.sum((np.exp(-1j * n * omega * tau) / D).imag / n)
    part, wave = a / D[0], 4 * F / np.pi
    # In (p, q), the phase's cosine and sine: x is Re part (p + i q) e^(i omega t).
    turned = part * np.exp(-1j * omega * tau)
    A = [
        [(1j * omega * part).real, (-omega * part).real],
        [a - (1 + K) * part.real + K * turned.real, (1 + K) * part.imag - K * turned.imag],
    ]
    p, q = np.linalg.solve(A, [wave * speed, F - (1 + K) * wave * here + K * wave * late])
    return math.hypot(p, q) - 1


def by_steps(omega, a=1.0, F=0.4, K=0.1, tau=0.6):
    """Return the largest x and the time of sticking of a period, by the method of steps: it sticks at every turn."""

    def pull(t, z, past):
        return a * math.cos(omega * t) - z[0] + K * (past(tau)[0] - z[0])

    def stop(t, z, past):
        return [z[0], 0.0]

    motion = Motion(
        {
            "right": lambda t, z, past: [z[1], pull(t, z, past) - F],
            "left": lambda t, z, past: [z[1], pull(t, z, past) + F],
            "stuck": lambda t, z, past: [0.0, 0.0],
        },
        {
            "right": [(lambda t, z, past: z[1], -1, stop, "stuck", "stop_right")],
            "left": [(lambda t, z, past: z[1], 1, stop, "stuck", "stop_left")],
            "stuck": [
                (lambda t, z, past: pull(t, z, past) - F, 1, same, "right", "go"),
                (lambda t, z, past: pull(t, z, past) + F, -1, same, "left", "go"),
            ],
        },
        (tau,),
        lambda t: [0.0, 0.0],
        "right",
    ).run(40 * 2 * math.pi / omega)
    last = motion.events[-6:]
    stuck = [b[1] - a[1] for a, b in pairwise(last) if b[0] == "go"]
    return max(z[0] for _, _, z in last), sum(stuck[-2:])


@pytest.mark.parametrize("omega", [0.5, 0.7])
def test_a_branch_goes_on_where_sticking_begins(omega, tmp_path):
    """Started where it sticks and where it does not: the same point between, at both turns at once."""
    step = run(change(FRICTION, "parameters.omega", omega), tmp_path / "a.h5").step("c")
    assert labels(step) == ["CS1"]
    exact = brentq(without_sticking, 0.5, 0.6, xtol=1e-15)
    assert exact == pytest.approx(0.55008, abs=1e-5)
    assert parameter(step, "omega", "CS1") == pytest.approx(exact, abs=1e-8)
    along, stuck = parameter(step, "omega"), monitor(step, "stuck")
    assert np.all(stuck[along > exact + 1e-6] == 0)
    assert np.all(stuck[along < exact - 1e-6] > 0)


def test_stick_slip_is_that_of_the_method_of_steps(tmp_path):
    data = change(FRICTION, "run.steps", FRICTION["run"]["steps"][:2])
    step = run(data, tmp_path / "a.h5").step("o")
    x_max, stuck = by_steps(0.5)
    assert x_max == pytest.approx(1.28, abs=1e-6)
    assert monitor(step, "x_max")[0] == pytest.approx(x_max, abs=1e-9)
    assert monitor(step, "stuck")[0] == pytest.approx(stuck, abs=1e-8)


@pytest.mark.parametrize("E", [33, 34])
def test_where_the_ramp_drops_the_converter_feeds_just_if_the_voltage_is_below_it(E, tmp_path):
    """1500 periods of chaos: no crossing is made of rounding, and none is lost."""
    data = {**change(BUCK, "parameters.E", E)}
    data["run"] = {"steps": [{"name": "t", "simulate": {"t_end": "1500*T", "rtol": 1e-8, "atol": 1e-10}}]}
    step = run(data, tmp_path / "a.h5").step("t")
    T, gamma, rise = 4e-4, 11.75238, 0.5238096
    times, v = step.orbits["event_time"], step.orbits["before"][:, 0]
    modes = [step.meta["segments"][k] for k in step.orbits["event_segment"]]
    drops = np.abs(times / T - np.round(times / T)) < 1e-9
    crossings = np.array(["cut_up" in m or "cut_down" in m for m in modes])
    assert drops.sum() >= 1498
    assert np.all(np.abs(v - gamma - rise * (times / T % 1))[crossings & ~drops] < 1e-6)
    # What follows a drop is told by the next crossing: up from feeding, down from idling.
    after = [i for i in np.flatnonzero(drops)[:-1] if crossings[i + 1]]
    assert len(after) > 500
    for i in after:
        assert (v[i] < gamma) == ("cut_up" in modes[i + 1]), times[i] / T
