"""Periodic orbits against closed forms, against explicit chain states, and their convergence order."""

import math

import numpy as np
import pytest

from pddecont.collocation import Mesh, MeshRule, equal_cuts
from pddecont.delay import Chain
from pddecont.orbit import (
    Orbit,
    OrbitProblem,
    Signature,
    adapt_mesh,
    estimate_error,
    find_violations,
    guess_from_cycle,
    make_eventless,
    solve_on_mesh,
    solve_orbit,
)
from pddecont.orbit.error import estimate_interval_errors
from pddecont.simulate import detect_period, simulate
from tests.conftest import numeric_from, shipped
from tests.orbit.exact import circle
from tests.orbits import segment_pieces
from tests.problems import WALL, ball_phase, chain_transfer

CHAIN = Chain(2, 15)


def orbit_of(numeric, t_end, delay=CHAIN, degree=6, intervals=30, **changes):
    p = numeric.parameter_values.copy()
    for name, value in changes.items():
        p[numeric.parameter_index(name)] = value
    cycle = detect_period(numeric, p, simulate(numeric, p, delay, t_end))
    return solve_on_mesh(guess_from_cycle(numeric, p, delay, cycle, MeshRule(degree, intervals))).at.orbit


def test_wall_oscillator():
    orbit = orbit_of(shipped("wall_oscillator"), 60 * math.pi)
    assert orbit.values[0, 1] == pytest.approx(WALL["v_out"], abs=1e-10)
    assert orbit.start % math.pi == pytest.approx(WALL["t_hit"], abs=1e-10)
    assert find_violations(orbit) == []


@pytest.mark.parametrize("G", [0.5, 0.6, 0.8])
def test_bouncing_ball(G):
    orbit = orbit_of(shipped("bouncing_ball"), 150 * 2 * math.pi, G=G)
    assert orbit.period == pytest.approx(2 * math.pi, abs=1e-13)
    assert math.cos(orbit.start) == pytest.approx(ball_phase(G, 0.8), abs=1e-10)


def linear(order=2, n=15):
    numeric = numeric_from(
        "name: m\nstates: [x, v]\nparameters: {omega: 0.8, a: 1, zeta: 0.05, K: 0.3, tau: 3.8}\n"
        "forcing: {period: 2*pi/omega}\n"
        "modes: {m: {x': v, v': a*sin(omega*t) - 2*zeta*v - x + K*(v(t - tau) - v)}}\n"
    )
    mesh = Mesh(6, 1, segment_pieces(1, 2, equal_cuts([20])))
    signature = Signature(numeric, (make_eventless(numeric.model, "m"),))
    problem = OrbitProblem(signature, mesh, Chain(order, n), numeric.parameter_values)
    guess = problem.unknowns.join(np.zeros((mesh.n_base, 2)), [2 * math.pi / 0.8], 0.0, [])
    return solve_on_mesh(Orbit(problem, guess)).at.orbit


@pytest.mark.parametrize(("order", "n"), [(1, 10), (2, 15), (3, 4)])
def test_linear_oscillator_with_a_chain_in_closed_form(order, n):
    orbit = linear(order, n)
    D = chain_transfer(0.8, 3.8, order, n)
    amplitude = 1 / (1 - 0.64 + 0.8j * (0.1 + 0.3 * (1 - D)))
    times = orbit.mesh.base_times(orbit.theta)
    exact = np.imag(amplitude * np.exp(0.8j * times))
    assert np.max(np.abs(orbit.values[:, 0] - exact)) < 1e-10


def test_eliminated_chain_equals_explicit_chain_states():
    """Order 2, N = 3: u1, w1, ... written out as states of the model give the same orbit to rounding."""
    n, states = 3, ["x", "v"]
    body = {"x'": "v", "v'": "a*omega**2*sin(omega*t) - 2*zeta*v - x + K*(u3 - v)"}
    before = "v"
    for i in range(1, n + 1):
        states += [f"u{i}", f"w{i}"]
        body[f"u{i}'"] = f"w{i}"
        body[f"w{i}'"] = f"2*{n}**2/tau**2*({before} - u{i} - tau/{n}*w{i})"
        before = f"u{i}"
    contact = {**body, "v'": body["v'"] + " - beta*(x - e)"}
    modes = "\n".join(
        f"  {m}: {{{', '.join(f'{k}: {v}' for k, v in b.items())}}}" for m, b in (("NC", body), ("C", contact))
    )
    explicit = numeric_from(f"""
name: explicit
states: [{", ".join(states)}]
parameters: {{omega: 0.8, a: 0.9, zeta: 0.01, e: 1.26, beta: 29, K: 0.12, tau: 3.8}}
forcing: {{period: 2*pi/omega}}
modes:
{modes}
events: {{impact: x - e}}
segments:
  NC: {{mode: NC, event: impact, direction: rising, to: C}}
  C: {{mode: C, event: impact, direction: falling, to: NC}}
""")
    t_end = 80 * 2 * math.pi / 0.8
    written_out = orbit_of(explicit, t_end, degree=5, intervals=24)
    eliminated = orbit_of(shipped("impact_oscillator"), t_end, Chain(2, 3), degree=5, intervals=24)
    assert eliminated.signature.names == written_out.signature.names
    assert np.max(np.abs(written_out.values[:, :2] - eliminated.values)) < 1e-11
    assert written_out.durations == pytest.approx(eliminated.durations, abs=1e-11)


@pytest.mark.parametrize("degree", [2, 3, 4])
def test_collocation_order(degree):
    """Uniform error of Gauss collocation of degree m falls as h^(m+1) on an orbit that is smooth in each segment."""
    exact = orbit_of(shipped("wall_oscillator"), 60 * math.pi, degree=10, intervals=20)
    errors = []
    for intervals in (8, 16):
        coarse = solve_on_mesh(adapt_mesh(exact, MeshRule(degree, intervals))).at.orbit
        dense = MeshRule(10, intervals * 2)
        errors.append(np.max(np.abs(adapt_mesh(coarse, dense).values - adapt_mesh(exact, dense).values)))
        assert errors[-1] / 20 < estimate_error(coarse) * 3.0 < errors[-1] * 20
    assert math.log2(errors[0] / errors[1]) == pytest.approx(degree + 1, abs=0.4)


@pytest.mark.parametrize("tol", [1e-4, 1e-8])
def test_the_tolerance_is_kept_whatever_the_guess_lay_on(tol):
    """From a coarse mesh and a shape that is off, onto one that the rule finds good enough."""
    exact = circle("s", level=0.5)
    coarse = circle("s", level=0.5, rule=MeshRule(4, intervals=7))
    guess = Orbit(coarse.problem, coarse.x * (1 + 0.01 * np.sin(np.arange(len(coarse.x)))))
    orbit = solve_orbit(guess, MeshRule(6, tol=tol)).at.orbit
    assert np.max(estimate_interval_errors(orbit)) <= tol
    assert orbit.period == pytest.approx(exact.period, abs=tol)
    t = orbit.start + orbit.mesh.base_times(orbit.theta)
    assert np.max(np.abs(orbit.values - np.stack([np.cos(t), np.sin(t)], axis=1))) < 10 * tol


def test_parameters_are_fixed():
    with pytest.raises(AssertionError, match="all parameters are fixed"):
        solve_on_mesh(circle("s", level=0.5, free=("tau",)))
