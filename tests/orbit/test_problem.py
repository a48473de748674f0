"""What a problem knows of its unknowns and delays."""

import numpy as np
import pytest

from pddecont.collocation import Mesh, equal_cuts
from pddecont.delay import Chain, Direct, FullWeights, LocalWeights
from pddecont.orbit import OrbitProblem, Signature
from tests.conftest import numeric_from
from tests.orbits import segment_pieces

TWO_DELAYS = """
name: m
states: [x, y]
parameters: {a: 1, tau: 0.7, s: 1.1}
forcing: {period: 3}
modes: {m: {x': y(t - tau) - a*x, y': x(t - 2*s) - y}}
events: {e: x}
segments: {s: {mode: m, event: e, to: m}}
"""


def problem_of(method, free=()):
    numeric = numeric_from(TWO_DELAYS)
    mesh = Mesh(3, 2, segment_pieces(2, 4, equal_cuts([3, 2])))
    return OrbitProblem(
        Signature(numeric, (numeric.model.segments["s"],) * 2), mesh, method, numeric.parameter_values, free
    )


def test_unknowns_of_a_forced_problem():
    problem = problem_of(Direct(), ("s", "a"))
    assert problem.free_index == (2, 0)
    unknowns = problem.unknowns
    assert (unknowns.n_states, unknowns.forced, unknowns.n_free) == (2, True, 2)
    assert unknowns.size == 17 * 2 + 2 + 1 + 2
    assert [segment.name for segment in problem.segments] == ["s", "s"]


def test_each_delay_is_a_component_of_theta():
    assert problem_of(Direct()).lags.tolist() == [[0, 0, 1, 0], [0, 0, 0, 1]]


@pytest.mark.parametrize(("method", "kind"), [(Direct(), LocalWeights), (Chain(2, 3), FullWeights)])
def test_an_operator_for_each_delay(method, kind):
    problem = problem_of(method)
    theta = np.array([2.0, 1.0, 0.7, 2.2])
    points = problem.mesh.equation_points
    operators = problem.make_operators(theta, points)
    assert len(operators) == 2
    assert all(isinstance(operator.weights, kind) for operator in operators)
    values = np.cos(2 * np.pi * problem.mesh.base_times(theta) / 3)[:, None]
    for operator, lag in zip(operators, problem.lags, strict=True):
        assert operator.weights.apply(values) == pytest.approx(
            problem.delay.operator(problem.mesh, theta, lag, points).weights.apply(values)
        )
    assert operators[0].weights.apply(values) != pytest.approx(operators[1].weights.apply(values), abs=0.1)
