"""Fifteen models in six sets of units of states, time and parameter.

Hard and soft walls, relays, neurons, delayed events, friction, sampling and networks as drawn at random, with one to
three delays, forced and not; an oscillator whose multipliers are far apart; a chain and a Chebyshev line.
"""

import numpy as np
import pytest

from tests.hard.units import Problem, Units
from tests.random_models.generator import draw_model
from tests.runs import multipliers, run

# Multipliers below this are left out.
SMALL = 1e-4
UNITS = {
    "states times 1e-6": Units((1e-6,)),
    "states times 1e6": Units((1e6,), parameter=1e-6),
    "times times 1e-6": Units((1.0,), 1e-6, 1e6),
    "times times 1e6": Units((1.0,), 1e6),
    "states times 1e-6 and 1e6, times times 1e-3": Units((1e-6, 1e6, 1e-3), 1e-3, 1e-6),
    "states times 1e6 and 1e-3, times times 1e6": Units((1e6, 1e-3, 1e-6), 1e6, 1e3),
}
DRAWN = {"hard walls": 24, "soft walls": 25, "relay": 26, "network": 18, "friction": 17, "kicked walls": 21}
DRAWN |= {"hysteresis": 11, "piecewise": 19, "sampled": 20, "late switch": 16, "busy neuron": 34, "neuron": 27}
# How many points a branch needs for its labels.
POINTS = {"network": 30, "friction": 30, "kicked walls": 20}
WALL = {
    "name": "wall",
    "states": ["x", "v"],
    "parameters": {"om": 2.4784, "c": 0.1219, "wall": -0.092, "r": 0.8035, "K": 0.0523, "q": -0.1652}
    | {"tau": 3.8086, "tau2": 0.8647, "g": -0.1652},
    "forcing": {"period": "2*pi/om"},
    "modes": {"m": {"x'": "v", "v'": "cos(om*t) - c*v - x + K*x(t - tau) + q*v(t - tau2)"}},
    "events": {"h": "x - wall"},
    "resets": {"b": {"v": "-r*v + 0.3*g*v(t - tau2)"}},
    "segments": {"s": {"mode": "m", "event": "h", "direction": "rising", "reset": "b", "to": "m"}},
    "initial": {"mode": "m", "x": -0.142, "v": -0.1},
}
MACKEY_GLASS = {
    "name": "mackey_glass",
    "states": ["x"],
    "parameters": {"beta": 0.2, "gamma": 0.1, "n": 10, "tau": 11.0},
    "modes": {"m": {"x'": "beta*x(t - tau)/(1 + x(t - tau)**n) - gamma*x"}},
    "initial": {"x": 1.1},
}
SOFT = {
    "name": "impact",
    "states": ["x", "v"],
    "parameters": {"omega": 0.8, "a": 0.9, "zeta": 0.01, "e": 1.26, "beta": 29.0, "K": 0.12, "tau_d": 3.8},
    "forcing": {"period": "2*pi/omega"},
    "definitions": {"force": "a*omega**2*sin(omega*t) + K*(v(t - tau_d) - v) - 2*zeta*v - x"},
    "modes": {"NC": {"x'": "v", "v'": "force"}, "C": {"x'": "v", "v'": "force - beta*(x - e)"}},
    "events": {"impact": "x - e"},
    "segments": {
        "NC": {"mode": "NC", "event": "impact", "direction": "rising", "to": "C"},
        "C": {"mode": "C", "event": "impact", "direction": "falling", "to": "NC"},
    },
    "initial": {"mode": "NC", "x": 0.0, "v": 0.0},
}


def drawn(name, seed):
    """Return the model of a seed, followed as its random run does."""
    model = draw_model(seed)
    return Problem(name, model.as_mapping(), model.free, model.span, model.settle, max_points=POINTS.get(name, 12))


PROBLEMS = {
    **{name: drawn(name, seed) for name, seed in DRAWN.items()},
    "multipliers far apart": Problem("wall", WALL, "wall", (-0.1, 0.308), 380.0, max_points=30),
    "Chebyshev line": Problem(
        "line", MACKEY_GLASS, "tau", (10.0, 14.0), 3000.0, {"delay": {"method": "chebyshev", "n": 10}}
    ),
    "chain": Problem(
        "chain", SOFT, "K", (0.05, 0.25), 470.0, {"delay": {"method": "chain", "order": 2, "n": 6}}, max_points=30
    ),
}
COMPUTED: dict[tuple[str, Units], dict] = {}


def numbers(name, units, folder):
    """Return what a model's run shows, in units of its own: multipliers, counts, labels with their parameters."""
    if (name, units) in COMPUTED:
        return COMPUTED[name, units]
    problem = PROBLEMS[name]
    results = run(problem.run_in(units), folder / "a.h5")
    orbit, branch = results.step("o"), results.step("b")
    column = list(branch.meta["parameters"]).index(problem.free)
    rows = [(branch.labels[i], i) for i in branch.order if branch.labels[i]]
    result = {
        "labels": [label for label, _ in rows],
        "parameters": np.array([branch.points["parameters"][i, column] / problem.factor(units) for _, i in rows]),
        "periods": np.array([branch.points["period"][i] / units.time for _, i in rows]),
        "stable": [int(orbit.points["stable"][0]), *(int(branch.points["stable"][i]) for _, i in rows)],
        "n_unstable": [int(orbit.points["n_unstable"][0]), *(int(branch.points["n_unstable"][i]) for _, i in rows)],
        "verified": [int(orbit.points["verified"][0]), *(int(branch.points["verified"][i]) for _, i in rows)],
        "endings": [e.code for e in branch.endings],
        "multipliers": [multipliers(orbit), *(multipliers(branch, i) for _, i in rows)],
    }
    COMPUTED[name, units] = result
    return result


def apart(found, expected):
    """Return how far multipliers are apart: each from the nearest of the others.

    The distance is that of points on the sphere: where an orbit touches a wall one is infinite, and rounding says how
    large its number is.
    """
    worst = 0.0
    for here, there in ((found, expected), (expected, found)):
        for m in here[np.abs(here) > SMALL]:
            distances = np.abs(there - m) / np.sqrt((1 + np.abs(there) ** 2) * (1 + np.abs(m) ** 2))
            worst = max(worst, float(np.min(distances, initial=np.inf)))
    return worst


def compare(name, units, folder, record):
    plain, found = (numbers(name, u, folder) for u in (Units(), UNITS[units]))
    for what in ("labels", "stable", "n_unstable", "verified", "endings"):
        assert found[what] == plain[what], what
    case = f"{name}, {units}"
    worst = max(apart(a, b) for a, b in zip(found["multipliers"], plain["multipliers"], strict=True))
    number = sum(int(np.sum(np.abs(m) > SMALL)) for m in plain["multipliers"])
    record(f"{case}: {number} multipliers of {len(plain['multipliers'])} orbits", "units of one", worst, 1e-8)
    for what in ("parameters", "periods"):
        worst = np.max(np.abs(found[what] / plain[what] - 1))
        record(f"{case}: {what} of {', '.join(plain['labels'])}", "units of one", worst, 1e-8)


# One set of units for each model.
ONE_EACH = {name: list(UNITS)[k % len(UNITS)] for k, name in enumerate(PROBLEMS)}


@pytest.mark.parametrize("name", PROBLEMS)
def test_units_do_not_matter(name, tmp_path, record):
    compare(name, ONE_EACH[name], tmp_path, record)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "units"), [(n, u) for n in PROBLEMS for u in UNITS if u != ONE_EACH[n]])
def test_no_units_matter(name, units, tmp_path, record):
    compare(name, units, tmp_path, record)
