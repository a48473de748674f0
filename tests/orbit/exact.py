"""An orbit that is known: x = cos t, y = sin t, which draws nearby motions to it; written down, not solved for."""

from __future__ import annotations

from functools import cache

import numpy as np

from pddecont.collocation import Mesh, MeshRule
from pddecont.delay import Direct
from pddecont.orbit import Orbit, OrbitProblem, Signature, make_eventless, make_mesh
from tests.conftest import numeric_from
from tests.runs import to_yaml

TURN = 2 * np.pi
CIRCLE = {
    "name": "circle",
    "states": ["x", "y"],
    "parameters": {"level": 0.5, "tau": 1.0, "w": 1.0},
    "forcing": {"period": "2*pi/w"},
    "modes": {
        "m": {"x'": "-w*sin(w*t) + cos(w*t) - x", "y'": "w*(x(t - tau)*cos(tau) - y(t - tau)*sin(tau)) + sin(w*t) - y"}
    },
    "events": {"e": "y - level"},
    "segments": {"s": {"mode": "m", "event": "e", "direction": "rising", "to": "m"}},
}


@cache
def _numeric(direction):
    segment = {**CIRCLE["segments"]["s"], "direction": direction}
    return numeric_from(to_yaml({**CIRCLE, "segments": {"s": segment}}))


def circle(*names, level=0.5, tau=1.0, direction="rising", rule=None, method=None, free=()):
    """Return the circle through segments of these names, turn after turn, or through none from t = 0.

    The one that ``s`` ends begins where the circle rises through the level.
    """
    numeric = _numeric(direction)
    p = numeric.parameter_values.copy()
    p[numeric.parameter_index("level")], p[numeric.parameter_index("tau")] = level, tau
    model = numeric.model
    signature = Signature(numeric, tuple(model.segments[name] for name in names) or (make_eventless(model, "m"),))
    n, rule = len(signature), rule or MeshRule(10, intervals=8)
    durations, start = np.full(n, TURN), float(np.arcsin(level)) if names else 0.0
    bare = OrbitProblem(signature, Mesh(rule.degree, n, ()), method or Direct(), p, free, n, phase=start)
    mesh = make_mesh(bare, np.append(durations, tau), rule)
    t = start + mesh.base_times(np.append(durations, tau))
    problem = OrbitProblem(signature, mesh, bare.delay, p, free, n, phase=start)
    values = np.stack([np.cos(t), np.sin(t)], axis=1)
    return Orbit(problem, problem.unknowns.join(values, durations, start, p[list(problem.free_index)]))
