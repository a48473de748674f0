"""The Jacobian against differences of the residual, and its pattern."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

from pddecont.codegen import NumericModel
from pddecont.collocation import Mesh, MeshRule, equal_cuts
from pddecont.delay import Chain, Chebyshev, Direct
from pddecont.model import explain_direct_only, load_model
from pddecont.orbit import Orbit, OrbitProblem, Signature, make_eventless, make_mesh
from pddecont.orbit.jacobian import make_jacobian
from pddecont.orbit.residual import compute_residual
from pddecont.orbit.signature import link_delayed_events
from tests.conftest import MODELS, numeric_from
from tests.orbits import segment_pieces

FREE = {
    "impact_oscillator": ("tau_d", "omega"),
    "impact_oscillator_autonomous": ("tau_d", "K"),
    "mackey_glass": ("tau", "n"),
    "spiking_neuron": ("tau", "kick"),
}
METHODS = {"chain": Chain(2, 5), "chebyshev": Chebyshev(6), "direct": Direct(), "untracked": Direct(track=False)}


def difference(orbit):
    """Return central differences, extrapolated from two steps: delays of many periods make their first error large."""

    def residual(x):
        return compute_residual(Orbit(orbit.problem, x))

    def central(step):
        steps = step * np.eye(len(orbit.x))
        return np.array([(residual(orbit.x + e) - residual(orbit.x - e)) / (2 * step) for e in steps]).T

    return (4 * central(1e-6) - central(2e-6)) / 3


def check(orbit):
    exact = make_jacobian(orbit)
    exact = exact.toarray() if sp.issparse(exact) else exact
    expected = difference(orbit)
    assert exact.shape == expected.shape
    assert np.max(np.abs(exact - expected)) < 1e-7 * (1 + np.max(np.abs(expected)))


def start(problem, seed=1):
    x = np.random.default_rng(seed).normal(size=problem.unknowns.size)
    x[problem.unknowns.durations] = np.linspace(2.0, 3.0, problem.mesh.n_segments)
    x[problem.unknowns.free] = problem.parameters[list(problem.free_index)]
    return x


def orbit_of(numeric, segments, method, free, degree=3, intervals=9, n_periods=1):
    """Return unknowns on the mesh that a method asks for, near which no breaking points cross."""
    model = numeric.model
    durations = np.linspace(1.3, 2.1, len(segments))
    theta = np.concatenate([durations, numeric.delays.value(numeric.parameter_values)])
    signature, p = Signature(numeric, segments), numeric.parameter_values
    links = link_delayed_events(signature, p, durations)
    bare = OrbitProblem(signature, Mesh(degree, len(segments), ()), METHODS[method], p, free, n_periods, links=links)
    mesh = make_mesh(bare, theta, MeshRule(degree, intervals))
    reference = (
        None
        if segments[0].event or model.forced
        else np.random.default_rng(0).normal(size=(mesh.n_base, numeric.n_states))
    )
    problem = replace(bare, mesh=mesh, reference=reference)
    x = np.random.default_rng(1).uniform(0.5, 1.5, size=problem.unknowns.size)
    x[problem.unknowns.durations] = durations
    x[problem.unknowns.free] = problem.parameters[list(problem.free_index)]
    return Orbit(problem, x)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_shipped_models(path, method):
    numeric = NumericModel(load_model(str(path))[0])
    model = numeric.model
    if METHODS[method].stages is not None and explain_direct_only(model):
        pytest.skip(f"refused where methods are chosen: {explain_direct_only(model)}")
    free = FREE.get(path.stem) or tuple(list(model.parameters)[:2])
    # Cars on a ring have hundreds of segments, all of them alike.
    segments = tuple(model.segments.values())[: None if model.derived is None else 16]
    check(orbit_of(numeric, segments or (make_eventless(model, model.initial_mode),), method, free))


@pytest.mark.parametrize("method", METHODS)
def test_delays_in_events_and_resets(method):
    numeric = numeric_from("""
name: m
states: [x, y]
parameters: {a: 1.5, tau: 0.7, sigma: 1.1, w: 2}
forcing: {period: 2*pi/w}
modes: {m: {x': y(t - tau)*x - a*sin(w*t), y': x(t - sigma) - y + x(t - tau)}}
events: {e: x(t - tau) - a*y + 0.1*sin(w*t)}
resets: {g: {x: x + y(t - sigma)*a, y: -a*y*cos(w*t)}}
segments: {s: {mode: m, event: e, reset: g, to: m}}
""")
    segments = (numeric.model.segments["s"],) * 2
    check(orbit_of(numeric, segments, method, ("tau", "sigma", "w", "a"), n_periods=2))


def test_without_delays_the_matrix_is_sparse_and_its_pattern_is_kept():
    numeric = NumericModel(load_model(str(next(p for p in MODELS if p.stem == "wall_oscillator")))[0])
    mesh = Mesh(4, 1, segment_pieces(1, 1, equal_cuts([50])))
    signature = Signature(numeric, (numeric.model.segments["flight"],))
    problem = OrbitProblem(signature, mesh, Chain(2, 5), numeric.parameter_values, ("a",))
    x = start(problem)
    first = make_jacobian(Orbit(problem, x))
    assert sp.issparse(first)
    assert first.nnz < 0.08 * np.prod(first.shape)
    assert make_jacobian(Orbit(problem, x + 0.1)).indices is first.indices
