"""Small runs in Python alone, of every kind of step."""

from functools import cache

import pddecont

# x' = -K x(t - 1) (1 + x): Hopf point at K = pi/2 with frequency pi/2 (Wright's equation).
WRIGHT = {
    "name": "wright",
    "states": ["x"],
    "parameters": {"K": 1.2},
    "units": {"x": "m", "t": "s"},
    "modes": {"only": {"x'": "-K*x(t - 1)*(1 + x)"}},
}
# x' = a x -+ 1 behind a delayed switch: orbits of amplitude (exp(a tau) - 1)/a and period that follows from it.
RELAY = {
    "name": "relay",
    "states": ["x"],
    "parameters": {"a": 0.5, "tau": 1},
    "units": {"x": "mm", "t": "s", "a": "1/s"},
    "modes": {"pull": {"x'": "a*x - 1"}, "push": {"x'": "a*x + 1"}},
    "events": {"switch": "x(t - tau)"},
    "segments": {
        "pull": {"mode": "pull", "event": "switch", "direction": "falling", "to": "push"},
        "push": {"mode": "push", "event": "switch", "direction": "rising", "to": "pull"},
    },
    "initial": {"mode": "pull", "x": 0.1},
}


@cache
def equilibria():
    """Return a search, a branch of equilibria with its Hopf point."""
    steps = [
        {"name": "rest", "equilibrium": {"search": {"x": [-2, 2]}}},
        {"name": "line", "continue": {"from": {"step": "rest", "point": "EQ2"}, "free": ["K"], "range": {"K": [1, 2]}}},
    ]
    return pddecont.run(WRIGHT, steps=steps)


@cache
def orbits():
    """Return a simulation, an orbit and a branch of orbits with multipliers."""
    steps = [
        {"name": "transient", "simulate": {"t_end": 60}},
        {"name": "orbit", "orbit": {"from": "transient", "stability": True}},
        {"name": "branch", "continue": {"from": "orbit", "free": ["a"], "range": {"a": [0.3, 0.6]}, "stability": True}},
    ]
    return pddecont.run(RELAY, steps=steps, monitors={"top": "max(x)"})


@cache
def attractors():
    """Return a sweep and a basin of a forced oscillator between two wells."""
    model = {
        "name": "wells",
        "states": ["x", "v"],
        "parameters": {"b": 0.1},
        "units": {"t": "s"},
        "forcing": {"period": "2*pi"},
        "modes": {"only": {"x'": "v", "v'": "x - x**3 - 0.5*v + b*cos(t)"}},
    }
    steps = [
        {"name": "sweep", "sweep": {"over": {"b": [0.1, 0.2, 2]}, "transient": 60, "lyapunov": True}},
        {"name": "basin", "basin": {"over": {"x": [-1.5, 1.5, 4], "v": [-1, 1, 2]}, "transient": 60}},
    ]
    return pddecont.run(model, steps=steps)


@cache
def exploration():
    """Return a whole diagram of a pitchfork."""
    model = {"name": "p", "states": ["x"], "parameters": {"a": 1}, "modes": {"free": {"x'": "a*x - x**3"}}}
    return pddecont.explore(model, {"a": [-1, 2]}, starts=4, check=2, max_branches=2)


@cache
def precision():
    """Return a comparison of meshes on the relay's orbit."""
    steps = [
        {"name": "transient", "simulate": {"t_end": 60}},
        {"name": "orbit", "orbit": {"from": "transient"}},
        {
            "name": "cost",
            "precision": {"from": "orbit", "quantities": {"top": "max(x)"}, "degrees": [4], "intervals": [2, 4]},
        },
    ]
    return pddecont.run(RELAY, steps=steps)
