"""Orbits that tests of several modules look at, each found once."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

from pddecont.orbit import Orbit, adapt_mesh
from tests.orbits import settle_to_orbit

FINE = {"degree": 10, "tol": 1e-12}
HARD_WALL = {
    "name": "hard_wall_with_delay",
    "states": ["x", "v"],
    "parameters": {"omega": 2, "c": 0.1, "wall": 0.2, "r": 0.8, "K": 0.2, "tau": 0.7},
    "forcing": {"period": "2*pi/omega"},
    "modes": {"free": {"x'": "v", "v'": "cos(omega*t) - c*v - x + K*(v(t - tau) - v)"}},
    "events": {"hit": "x - wall"},
    "resets": {"bounce": {"v": "-r*v"}},
    "segments": {"flight": {"mode": "free", "event": "hit", "direction": "rising", "reset": "bounce", "to": "free"}},
}


@cache
def impact_oscillator():
    """Return the orbit of the oscillator with a soft wall, two segments and a delay."""
    return settle_to_orbit("impact_oscillator", t_end=50 * 2 * math.pi / 0.8, mesh=FINE)


@cache
def hard_wall():
    """Return the orbit of an oscillator that bounces off a wall, with delayed feedback."""
    return settle_to_orbit(HARD_WALL, t_end=60 * math.pi, mesh=FINE)


@cache
def chained_impact_oscillator():
    """Return the orbit of the oscillator with a soft wall whose delay is a chain of three stages, on a coarse mesh."""
    delay = {"method": "chain", "order": 2, "n": 3}
    return settle_to_orbit("impact_oscillator", t_end=400, mesh={"degree": 4, "intervals": 10}, delay=delay)


@cache
def mackey_glass():
    """Return an orbit without events."""
    return settle_to_orbit("mackey_glass", {"n": 10, "tau": 1.2}, 300)


def with_parameter(orbit, name, value, rule):
    """Return the unknowns of an orbit at another value of a parameter, on a mesh made for it."""
    p = orbit.parameters.copy()
    p[orbit.numeric.parameter_index(name)] = value
    return adapt_mesh(Orbit(replace(orbit.problem, parameters=p), orbit.x), rule)


@cache
def neuron():
    """Return an orbit with delayed events of earlier periods under way."""
    return settle_to_orbit("spiking_neuron", {"tau": 2.3}, 200)
