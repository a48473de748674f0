"""Smooth orbits with delays that vary, rates and integrals of the past, against Fourier collocation."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from pddecont.collocation import MeshRule
from pddecont.orbit import integrals
from pddecont.orbit.system import PeriodicOrbitSystem, measure_orbit
from tests.delay_kinds import KINDS, exact, solve
from tests.runs import run


def measure_error(kind, orbit):
    """Return the largest error of an orbit's base values, its phase fitted where it has none of its own."""
    known, times = exact(kind), orbit.start + orbit.mesh.base_times(orbit.theta)
    shift = 0.0
    for _ in range(5 if not KINDS[kind][3] else 0):
        rate = known(times + shift, 1)[0]
        shift += float(rate @ (orbit.values[:, 0] - known(times + shift)[0]) / (rate @ rate))
    return float(np.max(np.abs(orbit.values[:, 0] - known(times + shift)[0])))


@pytest.mark.parametrize("kind", KINDS)
def test_smooth_orbits_against_fourier_collocation(kind):
    orbit = solve(kind, MeshRule(7, None, 1e-12))
    assert abs(orbit.period - exact(kind).period) < 1e-10
    assert measure_error(kind, orbit) < 1e-10


@pytest.mark.parametrize("kind", KINDS)
def test_orders(kind):
    """Values converge with order m + 1 as with constant delays; rates of polynomials of degree m with order m."""
    degree = 4
    coarse, fine = (measure_error(kind, solve(kind, MeshRule(degree, n, None))) for n in (32, 64))
    assert math.log2(coarse / fine) > (degree - 0.3 if kind == "neutral" else degree + 0.7)


@pytest.mark.parametrize("kind", KINDS)
def test_derivatives_are_those_of_the_residuals(kind):
    orbit = solve(kind, MeshRule(3, 8, None))
    free = tuple(orbit.numeric.model.parameters)
    system = PeriodicOrbitSystem(orbit.with_free(free).problem, measure_orbit(orbit))
    x = orbit.with_free(free).x
    x = x + 1e-3 * np.sin(np.arange(len(x)))
    jacobian, step = system.at(x).jacobian().toarray(), 1e-5
    for column, unit in enumerate(np.eye(len(x))):
        pairs = [(8.0, step), (-1.0, 2 * step)]
        slope = sum(w * (system.at(x + h * unit).residual - system.at(x - h * unit).residual) for w, h in pairs) / (
            12 * step
        )
        assert jacobian[:, column] == pytest.approx(slope, abs=2e-9 * np.max(np.abs(jacobian)))


def test_windows_may_cut_no_mesh_interval():
    """Where all limits lie on edges every interval is read whole."""
    orbit = solve("distributed", MeshRule(3, 8, None))
    window, xi = orbit.equation_reads.integrals[0].window, np.linspace(0.0, 1.0, 5)
    whole = np.zeros(len(window.interval), dtype=bool)
    window = replace(window, cut_low=whole, cut_high=whole)
    nodes = integrals._find_nodes(orbit.mesh, window, xi, np.tile(xi, (len(whole), 1)))
    assert nodes.own.shape == (0, 5, 4) and not len(nodes.cut)
    every = nodes.interpolate(orbit.mesh, np.ones((orbit.mesh.n_base, 1)))
    assert np.allclose(every, 1.0, rtol=0, atol=1e-14)


def test_impacts_with_a_rate_and_an_integral_of_the_past(tmp_path):
    """Jumps come back by the rate until they have faded, and by both limits of the integral; the referee agrees."""
    force = "cos(1.2*t) - 0.4*v - x + 0.1*v'(t - 0.7) - 0.1*integral(exp(-s)*x(t - s), s, 0.2, 1)"
    model = {
        "name": "wall",
        "states": ["x", "v"],
        "parameters": {"r": 0.6, "wall": 0.3},
        "forcing": {"period": "2*pi/1.2"},
        "modes": {"m": {"x'": "v", "v'": force}},
        "events": {"hit": "x - wall"},
        "resets": {"bounce": {"v": "-r*v"}},
        "segments": {"s": {"mode": "m", "event": "hit", "direction": "rising", "reset": "bounce", "to": "m"}},
        "initial": {"x": -0.1, "v": 0.0, "mode": "m"},
    }
    steps = [{"name": "t", "simulate": {"t_end": 120}}, {"name": "o", "orbit": {"from": "t"}}]
    step = run({**model, "run": {"mesh": {"tol": 1e-8}, "steps": steps}}, tmp_path / "a.h5").step("o")
    assert step.points["verified"][0] != 0
    assert step.points["deviation"][0] < 1e-7
