"""The same model in two sets of units, its parameters up to 1e12 apart.

A length unit L and a time unit U turn x, t, omega, beta, ... into other numbers; every result must be the same after it
is turned back.
"""

import numpy as np
import pytest

from tests.runs import labels, multipliers, run

PLAIN = {"omega": 0.8, "a": 0.9, "zeta": 0.01, "k": 1.0, "e": 1.26, "beta": 29.0, "K": 0.12, "tau_d": 3.8}


def model(length, time):
    """Return the impact oscillator with lengths in units of 1/length, times in units of 1/time."""
    scaled = {
        "omega": PLAIN["omega"] / time,
        "a": PLAIN["a"] * length,
        "zeta": PLAIN["zeta"] / time,
        "k": 1 / time**2,
        "e": PLAIN["e"] * length,
        "beta": PLAIN["beta"] / time**2,
        "K": PLAIN["K"] / time,
        "tau_d": PLAIN["tau_d"] * time,
    }
    atol = 1e-11 * min(length, length / time)
    branch = {
        "from": "o",
        "free": ["K"],
        "range": {"K": [0.05 / time, 0.25 / time]},
        "direction": "up",
        "stability": True,
    }
    return {
        "name": "impact",
        "states": ["x", "v"],
        "parameters": scaled,
        "forcing": {"period": "2*pi/omega"},
        "definitions": {"force": "a*omega**2*sin(omega*t) + K*(v(t - tau_d) - v) - 2*zeta*v - k*x"},
        "modes": {"NC": {"x'": "v", "v'": "force"}, "C": {"x'": "v", "v'": "force - beta*(x - e)"}},
        "events": {"impact": "x - e"},
        "segments": {
            "NC": {"mode": "NC", "event": "impact", "direction": "rising", "to": "C"},
            "C": {"mode": "C", "event": "impact", "direction": "falling", "to": "NC"},
        },
        "run": {
            "mesh": {"degree": 8, "tol": 1e-10},
            "monitors": {"speed": "at(NC, v)", "top": "max(x)", "contact": "time_in(C)"},
            "steps": [
                {"name": "t", "simulate": {"t_end": "60*2*pi/omega", "atol": atol}},
                {"name": "o", "orbit": {"from": "t", "stability": True}},
                {"name": "c", "continue": branch},
            ],
        },
    }


def numbers(mapping, path, length, time):
    results = run(mapping, path)
    orbit, branch = results.step("o"), results.step("c")
    units = np.array([length / time, length, time])
    special = {
        name: (
            branch.points["parameters"][branch.row(name), 6] * time,
            *(branch.points["monitors"][branch.row(name)] / units),
        )
        for name in labels(branch)
    }
    return orbit.points["monitors"][0] / units, multipliers(orbit), special


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    return numbers(model(1.0, 1.0), tmp_path_factory.mktemp("plain") / "a.h5", 1.0, 1.0)


@pytest.mark.parametrize(
    ("length", "time"), [(1e-9, 1.0), (1e9, 1.0), (1.0, 1e-6), (1.0, 1e6), (1e-6, 1e-6), (1e6, 1e-3)]
)
def test_units_do_not_matter(tmp_path, plain, length, time, record):
    orbit, leading, special = numbers(model(length, time), tmp_path / "a.h5", length, time)
    case = f"lengths times {length:g}, times {time:g}"
    record(
        f"{case}: speed, top and contact time of the orbit",
        "units of the paper",
        np.max(np.abs(orbit / plain[0] - 1)),
        1e-8,
    )
    record(f"{case}: leading multipliers", "units of the paper", np.max(np.abs(leading[:2] - plain[1][:2])), 1e-8)
    assert list(special) == list(plain[2])
    worst = max(np.max(np.abs(np.array(special[name]) - plain[2][name])) for name in special)
    record(f"{case}: special points ({', '.join(special)})", "units of the paper", worst, 1e-8)
