"""Models, runs and comparisons that tests of several kinds of special points share."""

from __future__ import annotations

import math

import numpy as np

from pddecont.stability import Multipliers
from tests.runs import multipliers, run

# Piecewise linear flows by matrix exponentials, the delay line with N = 15 and M = 2, at tau_d = 3.8: the grazing, and
# the period-2 orbit with two impacts that falls onto the period-1 orbit.
CHAIN_GRAZING = 0.174746955369
CHAIN_COLLAPSE = 0.174892118771
# Impact map of the bouncing ball in closed form and by Newton's method, r = 0.8.
BALL_PD = 1.07083646824791


def settle(t_end, **more):
    """Return the steps that simulate and solve for the orbit that is settled to."""
    return [{"name": "t", "simulate": {"t_end": t_end, **more}}, {"name": "o", "orbit": {"from": "t"}}]


def follow(name, source, ranges, **more):
    """Return the step that follows a branch in the parameters of ``ranges`` from a step, or from (step, point)."""
    place = source if isinstance(source, str) else dict(zip(("step", "point"), source, strict=True))
    return {"name": name, "continue": {"from": place, "free": list(ranges), "range": ranges, **more}}


def chain(K, steps, **more):
    """Return a run of the impact oscillator with the delay line of the paper's scheme."""
    return {
        "model": "impact_oscillator",
        "set": {"K": K, "tau_d": 3.8},
        "delay": {"method": "chain", "order": 2, "n": 15},
        "mesh": {"degree": 8, "intervals": 40},
        "steps": steps,
        **more,
    }


def ball(steps, **mesh):
    """Return a run of the bouncing ball."""
    return {"model": "bouncing_ball", "mesh": {"degree": 9, "tol": 1e-11, **mesh}, "steps": steps}


def wall(free, limits, *, model="wall_oscillator", changes=None, **more):
    """Return a run of the oscillator with a hard wall, followed in one parameter."""
    step = follow("c", "o", {free: limits}, **{"step": {"max": 0.05}, "stability": True, "direction": "both", **more})
    mesh, monitors = {"degree": 8, "tol": 1e-10}, {"x_max": "max(x)"}
    return {"model": model, "set": changes or {}, "mesh": mesh, "monitors": monitors, "steps": [*settle(300), step]}


def free_amplitude(omega, c=0.1):
    """Return the amplitude of x'' + c x' + x = cos(omega t)."""
    return 1 / math.hypot(1 - omega**2, c * omega)


# An oscillator that is driven and meets nothing: its amplitude is known in closed form.
FREE = {
    "name": "free",
    "states": ["x", "v"],
    "parameters": {"omega": 2.6, "c": 0.1, "F": 1},
    "forcing": {"period": "2*pi/omega"},
    "modes": {"m": {"x'": "v", "v'": "F*cos(omega*t) - c*v - x"}},
}
# Orbits r^2 = m round the origin, free and begun by an event that does nothing.
NORMAL_FORM = {
    "name": "normal_form",
    "states": ["x", "y"],
    "parameters": {"m": 0.25},
    "modes": {"m": {"x'": "m*x - y - x*(x**2 + y**2)", "y'": "x + m*y - y*(x**2 + y**2)"}},
    "initial": {"x": 0.5, "y": 0},
}
SECTION = {
    **NORMAL_FORM,
    "events": {"top": "y"},
    "segments": {"turn": {"mode": "m", "event": "top", "direction": "rising", "to": "m"}},
    "initial": {"mode": "m", "x": 0.5, "y": 0.1},
}
# Between two walls at a distance of b and a, driven: soft walls push back, hard ones return 0.8 of the speed.
SOFT_WALLS = {
    "name": "soft_walls",
    "states": ["x", "v"],
    "parameters": {"omega": 2.0, "a": 0.3, "b": 0.3, "c": 0.1, "k": 4},
    "forcing": {"period": "2*pi/omega"},
    "modes": {
        "F": {"x'": "v", "v'": "cos(omega*t) - c*v - x"},
        "R": {"x'": "v", "v'": "cos(omega*t) - c*v - x - k*(x-a)"},
        "L": {"x'": "v", "v'": "cos(omega*t) - c*v - x - k*(x+b)"},
    },
    "events": {"right": "x - a", "left": "x + b"},
    "resets": {"same": {}},
    "segments": {
        "FR": {"mode": "F", "event": "right", "direction": "rising", "reset": "same", "to": "R"},
        "RF": {"mode": "R", "event": "right", "direction": "falling", "reset": "same", "to": "F"},
        "FL": {"mode": "F", "event": "left", "direction": "falling", "reset": "same", "to": "L"},
        "LF": {"mode": "L", "event": "left", "direction": "rising", "reset": "same", "to": "F"},
    },
    "initial": {"mode": "F"},
}
HARD_WALLS = {
    **SOFT_WALLS,
    "modes": {"F": {"x'": "v", "v'": "cos(omega*t) - c*v - x - 0*k"}},
    "resets": {"hit": {"v": "-0.8*v"}},
    "segments": {
        "right": {"mode": "F", "event": "right", "direction": "rising", "reset": "hit", "to": "F"},
        "left": {"mode": "F", "event": "left", "direction": "falling", "reset": "hit", "to": "F"},
    },
}


def walls(model, b, *steps, **more):
    """Return a run between two walls: the free orbit followed down in the frequency until it touches them."""
    begin = [{**step, "set": {"omega": 2.6}} for step in settle(200)]
    branch = follow("c", "o", {"omega": [1.9, 2.7]}, direction="down", max_points=40, **more)
    block = {"mesh": {"degree": 9, "tol": 1e-11}, "steps": [*begin, branch, *steps]}
    return {**model, "parameters": {**model["parameters"], "b": b}, "run": block}


def signatures(step):
    """Return the signatures along a branch, each once where it goes on."""
    names = [step.orbit(i)["signature"].tobytes().decode() for i in step.order if not step.points["kind"][i]]
    return [a for a, b in zip(names, [None, *names], strict=False) if a != b]


def plain_multipliers(results, name, row, model, path):
    """Return the multipliers of a recorded orbit solved anew, its parameters fixed, on a mesh of its own."""
    source = {"file": str(results.path), "step": name, "index": row}
    orbit = {"name": "o", "orbit": {"from": source, "stability": {"multipliers": 4}}}
    again = {"model": model, "mesh": {"degree": 10, "tol": 1e-11}, "steps": [orbit]}
    return multipliers(run(again, path / "plain.h5").step("o"))


def check_multipliers(results, name, model, path, tol=1e-8, every=6):
    """Check every sixth orbit of a curve against itself computed plainly."""
    step = results.step(name)
    rows = step.order[::every]
    assert len(rows) > 3
    for i in rows:
        plain, here = plain_multipliers(results, name, int(i), model, path), multipliers(step, i)
        n = min(len(here), 2)
        distance = [np.min(np.abs(plain - v)) for v in here[:n]]
        assert np.max(distance) < tol * max(1.0, np.abs(here[0])), (i, here, plain)


def make_multipliers(values):
    """Return multipliers, none of them trivial."""
    values = np.array(values, dtype=complex)
    return Multipliers(values, values)


class Known:
    """Stands for a cache of multipliers: every orbit has the same."""

    def __init__(self, values):
        self.multipliers = make_multipliers(values)

    def find(self, orbit):
        """Return the multipliers."""
        return self.multipliers
