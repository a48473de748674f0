"""The Jacobian against differences of the residual, and its pattern."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

from pddecont.delay.chain import Chain
from pddecont.delay.chebyshev import Chebyshev
from pddecont.delay.direct import Direct
from pddecont.model.builder import load_model
from pddecont.model.codegen import NumericModel
from pddecont.orbit.guess import timers_of
from pddecont.orbit.jacobian import Assembler
from pddecont.orbit.mesh import Mesh, equal_cuts, segment_pieces
from pddecont.orbit.meshing import MeshRule, new_mesh
from pddecont.orbit.problem import OrbitProblem, eventless
from pddecont.orbit.residual import residual
from tests.conftest import MODELS, numeric_from

FREE = {"impact_oscillator": ("tau_d", "omega"), "impact_oscillator_autonomous": ("tau_d", "K"), "mackey_glass": ("tau", "n"),
        "spiking_neuron": ("tau", "kick")}  # fmt: skip
METHODS = {"chain": Chain(2, 5), "chebyshev": Chebyshev(6), "direct": Direct(), "untracked": Direct(track=False)}


def difference(problem, x):
    """Return central differences, extrapolated from two steps: a delay of many periods makes their first error large."""
    def central(step):
        return np.array([(residual(problem, x + step * e) - residual(problem, x - step * e)) / (2 * step) for e in np.eye(len(x))]).T

    return (4 * central(1e-6) - central(2e-6)) / 3


def check(problem, x):
    exact = Assembler(problem)(x)
    exact = exact.toarray() if sp.issparse(exact) else exact
    expected = difference(problem, x)
    assert exact.shape == expected.shape
    assert np.max(np.abs(exact - expected)) < 1e-7 * (1 + np.max(np.abs(expected)))


def start(problem, seed=1):
    x = np.random.default_rng(seed).normal(size=problem.layout.size)
    x[problem.layout.durations] = np.linspace(2.0, 3.0, problem.mesh.n_segments)
    x[problem.layout.free] = problem.parameters[list(problem.free_index)]
    return x


def problem_of(numeric, segments, method, free, degree=3, intervals=9, n_periods=1):
    """Return a problem on the mesh that its method asks for, at unknowns near which no breaking points cross."""
    model = numeric.model
    durations = np.linspace(1.3, 2.1, len(segments))
    theta = np.concatenate([durations, numeric.delays.value(numeric.parameter_values)])
    timers = timers_of(numeric, segments, numeric.parameter_values, durations)
    bare = OrbitProblem(numeric, segments, Mesh(degree, len(segments), ()), METHODS[method], numeric.parameter_values, free, n_periods,
                        timers=timers)  # fmt: skip
    mesh = new_mesh(bare, theta, MeshRule(degree, intervals))
    reference = None if segments[0].event or model.forced else np.random.default_rng(0).normal(size=(mesh.n_base, numeric.n_states))
    problem = replace(bare, mesh=mesh, reference=reference)
    x = np.random.default_rng(1).uniform(0.5, 1.5, size=problem.layout.size)
    x[problem.layout.durations] = durations
    x[problem.layout.free] = problem.parameters[list(problem.free_index)]
    return problem, x


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_shipped_models(path, method):
    numeric = NumericModel(load_model(str(path))[0])
    model = numeric.model
    free = FREE.get(path.stem) or tuple(list(model.parameters)[:2])
    check(*problem_of(numeric, tuple(model.segments.values()) or (eventless(model.initial_mode),), method, free))


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
    check(*problem_of(numeric, segments, method, ("tau", "sigma", "w", "a"), n_periods=2))


def test_without_delays_the_matrix_is_sparse_and_its_pattern_is_kept():
    numeric = NumericModel(load_model(str(next(p for p in MODELS if p.stem == "wall_oscillator")))[0])
    mesh = Mesh(4, 1, segment_pieces(1, 1, equal_cuts([50])))
    problem = OrbitProblem(numeric, (numeric.model.segments["flight"],), mesh, Chain(2, 5), numeric.parameter_values, ("a",))
    assembler = Assembler(problem)
    x = start(problem)
    first = assembler(x)
    pattern = assembler.blocks.pattern
    assert sp.issparse(first)
    assert first.nnz < 0.08 * np.prod(first.shape)
    assembler(x + 0.1)
    assert assembler.blocks.pattern is pattern
