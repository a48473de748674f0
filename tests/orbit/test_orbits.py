"""Periodic orbits against closed forms, against explicit chain states, and their convergence order."""

import math

import numpy as np
import pytest

from pddecont.delay.chain import Chain
from pddecont.orbit.admissibility import objections
from pddecont.orbit.curve import solve_orbit
from pddecont.orbit.estimate import error_estimate
from pddecont.orbit.guess import orbit_from_cycle
from pddecont.orbit.mesh import Mesh, equal_cuts, segment_pieces
from pddecont.orbit.meshing import MeshRule, remeshed
from pddecont.orbit.problem import OrbitProblem, eventless
from pddecont.simulate.integrate import simulate
from pddecont.simulate.recognise import recognise
from tests.conftest import numeric_from, shipped
from tests.problems import WALL, ball_phase, chain_transfer

CHAIN = Chain(2, 15)


def orbit_of(numeric, t_end, delay=CHAIN, degree=6, intervals=30, **changes):
    p = numeric.parameter_values.copy()
    for name, value in changes.items():
        p[numeric.parameter_index(name)] = value
    cycle = recognise(numeric, p, simulate(numeric, p, delay, t_end))
    problem, guess = orbit_from_cycle(numeric, p, delay, cycle, MeshRule(degree, intervals))
    return problem, solve_orbit(problem, guess).x


def test_wall_oscillator():
    problem, x = orbit_of(shipped("wall_oscillator"), 60 * math.pi)
    values, _, start, _ = problem.layout.split(x)
    assert values[0, 1] == pytest.approx(WALL["v_out"], abs=1e-10)
    assert start % math.pi == pytest.approx(WALL["t_hit"], abs=1e-10)
    assert objections(problem, x) == []


@pytest.mark.parametrize("G", [0.5, 0.6, 0.8])
def test_bouncing_ball(G):
    problem, x = orbit_of(shipped("bouncing_ball"), 150 * 2 * math.pi, G=G)
    assert problem.period(x) == pytest.approx(2 * math.pi, abs=1e-13)
    assert math.cos(x[problem.layout.start][0]) == pytest.approx(ball_phase(G, 0.8), abs=1e-10)


def linear(order=2, n=15):
    numeric = numeric_from("name: m\nstates: [x, v]\nparameters: {omega: 0.8, a: 1, zeta: 0.05, K: 0.3, tau: 3.8}\n"
                           "forcing: {period: 2*pi/omega}\n"
                           "modes: {m: {x': v, v': a*sin(omega*t) - 2*zeta*v - x + K*(v(t - tau) - v)}}\n")  # fmt: skip
    mesh = Mesh(6, 1, segment_pieces(1, 2, equal_cuts([20])))
    problem = OrbitProblem(numeric, (eventless("m"),), mesh, Chain(order, n), numeric.parameter_values)
    guess = problem.layout.join(np.zeros((mesh.n_base, 2)), [2 * math.pi / 0.8], 0.0, [])
    return problem, solve_orbit(problem, guess).x


@pytest.mark.parametrize(("order", "n"), [(1, 10), (2, 15), (3, 4)])
def test_linear_oscillator_with_a_chain_in_closed_form(order, n):
    problem, x = linear(order, n)
    D = chain_transfer(0.8, 3.8, order, n)
    amplitude = 1 / (1 - 0.64 + 0.8j * (0.1 + 0.3 * (1 - D)))
    times = problem.mesh.base_times(problem.theta(x))
    exact = np.imag(amplitude * np.exp(0.8j * times))
    assert np.max(np.abs(problem.layout.split(x)[0][:, 0] - exact)) < 1e-10


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
    modes = "\n".join(f"  {m}: {{{', '.join(f'{k}: {v}' for k, v in b.items())}}}" for m, b in (("NC", body), ("C", contact)))
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
    problem, x = orbit_of(explicit, t_end, degree=5, intervals=24)
    same, y = orbit_of(shipped("impact_oscillator"), t_end, Chain(2, 3), degree=5, intervals=24)
    assert [s.name for s in same.segments] == [s.name for s in problem.segments]
    assert np.max(np.abs(problem.layout.split(x)[0][:, :2] - same.layout.split(y)[0])) < 1e-11
    assert x[problem.layout.durations] == pytest.approx(y[same.layout.durations], abs=1e-11)


@pytest.mark.parametrize("degree", [2, 3, 4])
def test_collocation_order(degree):
    """Uniform error of Gauss collocation of degree m falls as h^(m+1) on an orbit that is smooth in each segment."""
    problem, x = orbit_of(shipped("wall_oscillator"), 60 * math.pi, degree=10, intervals=20)
    errors = []
    for intervals in (8, 16):
        coarse, guess = remeshed(problem, x, MeshRule(degree, intervals))
        y = solve_orbit(coarse, guess).x
        fine, z = remeshed(coarse, y, MeshRule(10, intervals * 2))
        reference = remeshed(problem, x, MeshRule(10, intervals * 2))
        errors.append(np.max(np.abs(fine.layout.split(z)[0] - reference[0].layout.split(reference[1])[0])))
        assert errors[-1] / 20 < error_estimate(coarse, y) * 3.0 < errors[-1] * 20
    assert math.log2(errors[0] / errors[1]) == pytest.approx(degree + 1, abs=0.4)
