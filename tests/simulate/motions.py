"""Motions that several files test: tolerances, models as texts, and how to run them."""

from __future__ import annotations

from pddecont.delay import Direct
from pddecont.simulate import Method, simulate
from tests.conftest import numeric_from

TIGHT = Method(1e-12, 1e-13)
STIFF = Method(1e-10, 1e-11, stiff=True)
# c counts time, and n the events of h = H; an event is the end of the segment s.
COUNTER = (
    "name: c\nstates: [c, n]\nmodes: {m: {c': 1, n': 0}}\nevents: {e: H}\nresets: {add: {n: n + 1}}\n"
    "segments: {s: {mode: m, event: e, direction: DIR, reset: add, to: m}}\n"
)
# The vector fields of modes p and q lead to and away from the surface h = H.
RELAY = (
    "name: f\nstates: [x]\nparameters: {tau: 1}\nmodes: {p: {x': -1}, q: {x': 2}, s: {x': 0}}\nevents: {e: "
    "H}\nsegments:\n"
    "  a: {mode: p, event: e, direction: falling, to: q}\n  b: {mode: q, event: e, direction: rising, to: "
    "p}\ninitial: {x: 1}\n"
)
# A ball of restitution r falls from y = 1; the floor is at y = 0.
BALL = (
    "name: ball\nstates: [y, v]\nparameters: {g: 9.81, r: 0.8}\nmodes: {fly: {y': v, v': -g}, lie: {y': 0, v': 0}}\n"
    "events: {hit: y}\nresets: {bounce: {v: -r*v}}\n"
    "segments: {hop: {mode: fly, event: hit, direction: falling, reset: bounce, to: fly}}\ninitial: {y: 1}\n"
)


def with_parameters(numeric, **given):
    """Return a model's parameters, some of them replaced."""
    p = numeric.parameter_values.copy()
    for name, value in given.items():
        p[numeric.parameter_index(name)] = value
    return p


def trajectory_of(model, t_end, method=TIGHT, delay=None, **given):
    """Return the trajectory of a model, or of its text; ``given`` are parameters and arguments of ``simulate``."""
    numeric = numeric_from(model) if isinstance(model, str) else model
    parameters = {name: given.pop(name) for name in [*given] if name in numeric.model.parameters}
    return simulate(numeric, with_parameters(numeric, **parameters), delay or Direct(), t_end, method, **given)
