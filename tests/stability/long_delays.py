"""Orbits with delays of many periods whose multipliers are known apart from this program."""

from __future__ import annotations

import math

import numpy as np
import scipy.linalg

from pddecont.collocation import Mesh, equal_cuts
from pddecont.delay import Direct
from pddecont.orbit import Orbit, OrbitProblem, Signature, make_eventless, solve_on_mesh
from tests.conftest import numeric_from
from tests.orbits import segment_pieces, settle_to_orbit

MESH = {"degree": 6, "tol": 1e-9}


def damped_wall(n, K=0.0):
    """Return the orbit of a forced oscillator at a rigid wall with feedback over ``n`` periods."""
    model = {
        "name": "long_delay",
        "states": ["x", "v"],
        "parameters": {"omega": 2, "c": 0.3, "wall": 0.2, "r": 0.6, "K": K, "n": n},
        "forcing": {"period": "2*pi/omega"},
        "modes": {"free": {"x'": "v", "v'": "cos(omega*t) - c*v - x + K*x(t - n*2*pi/omega)"}},
        "events": {"hit": "x - wall"},
        "resets": {"bounce": {"v": "-r*v"}},
        "segments": {
            "flight": {"mode": "free", "event": "hit", "direction": "rising", "reset": "bounce", "to": "free"}
        },
    }
    return settle_to_orbit(model, t_end=300, mesh=MESH)


def find_saltation_multipliers(orbit):
    """Return the multipliers of ``damped_wall`` without feedback, from the textbook's saltation matrix."""
    c, r, t = 0.3, 0.6, orbit.start
    out = float(orbit.values[0, 1])
    into = -out / r

    def field(v):
        return np.array([v, math.cos(2 * t) - c * v - 0.2])

    jump = np.diag([1.0, -r])
    saltation = jump + np.outer(field(out) - jump @ field(into), [1.0, 0.0]) / into
    flow = scipy.linalg.expm(np.array([[0.0, 1.0], [-1.0, -c]]) * math.pi)
    return sorted(scipy.linalg.eigvals(saltation @ flow), key=lambda z: -z.imag)


def linear_feedback(n, K):
    """Return the orbit of x' = -x + K x(t - n) + cos(2 pi t)."""
    numeric = numeric_from(
        f"name: feedback\nstates: [x]\nparameters: {{K: {K}, n: {n}}}\nforcing: {{period: 1}}\n"
        "modes: {m: {x': -x + K*x(t - n) + cos(2*pi*t)}}\n"
    )
    mesh = Mesh(10, 1, segment_pieces(1, 2, equal_cuts([8])))
    problem = OrbitProblem(
        Signature(numeric, (make_eventless(numeric.model, "m"),)), mesh, Direct(), numeric.parameter_values
    )
    guess = Orbit(problem, problem.unknowns.join(np.zeros((mesh.n_base, 1)), [1.0], 0.0, []))
    return solve_on_mesh(guess).at.orbit


def find_lambert_multipliers(n, K, number):
    """Return its leading multipliers exp(s) with s = W_k(K n e^n) / n - 1, by falling modulus."""
    # W of numbers too large for floating point, from log w + w = log K + log n + n + 2 pi i k.
    found = []
    for k in range(-number, number + 1):
        level = math.log(abs(K)) + math.log(n) + n + (2 * math.pi * k + (math.pi if K < 0 else 0.0)) * 1j
        w = level - np.log(level)
        for _ in range(50):
            w -= (w + np.log(w) - level) / (1 + 1 / w)
        found.append(np.exp(w / n - 1))
    return sorted(found, key=lambda z: (-round(abs(z), 11), -z.imag))[:number]
