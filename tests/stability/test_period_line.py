"""A delay line over one period: started as the periodic one is, it does what the periodic one does."""

import numpy as np
import pytest

from pddecont.collocation import MeshRule
from pddecont.delay import Chain, Chebyshev, LineOnMesh
from pddecont.orbit import Orbit, adapt_mesh
from pddecont.stability.period_line import make_period_line
from tests.known_orbits import chained_impact_oscillator

METHODS = {"chain": Chain(2, 3), "one stage": Chain(3, 1), "chebyshev": Chebyshev(5)}


def line_of(method):
    """Return the line of an orbit whose delay is discretised so; no solution, which is not needed."""
    orbit = adapt_mesh(chained_impact_oscillator(), MeshRule(4, intervals=10))
    problem = orbit.problem.__class__(
        orbit.signature, orbit.mesh, METHODS[method], orbit.parameters, (), orbit.problem.n_periods
    )
    return make_period_line(Orbit(problem, orbit.x), 0)


def periodic(line, inputs):
    """Return the states at the period's start of all stages of the periodic line, and its delayed values."""
    starts, u = [], inputs
    for stage in range(line.n_stages):
        states = line.closed.response @ u
        starts.append(states[0, 0])
        output = line.closed.output_at_points(states)
        u = line.closed.output_at_nodes(states) if stage + 1 < line.n_stages else u
    return np.array(starts), output


@pytest.mark.parametrize("method", METHODS)
def test_started_like_the_periodic_line_it_stays_periodic(method):
    line = line_of(method)
    mesh = line.open.mesh
    values = np.random.default_rng(0).normal(size=(mesh.n_base, len(line.states)))
    inputs = mesh.interpolate_at_nodes(values)
    starts, output = periodic(line, inputs)
    assert starts.shape == line.shape
    found = line.weights @ values + line.from_start(starts[..., None])[..., 0]
    assert found == pytest.approx(output, abs=1e-9 * np.max(np.abs(output)))
    still = np.zeros((mesh.n_segments, 1))
    assert line.end(starts[..., None], inputs[..., None], still)[..., 0] == pytest.approx(starts, abs=1e-9)


@pytest.mark.parametrize("segment", [0, 1])
@pytest.mark.parametrize("method", METHODS)
def test_durations_move_its_values_and_its_end(method, segment):
    """Against differences: the same states at the start and the same inputs, over periods of other durations."""
    line = line_of(method)
    mesh, theta = line.open.mesh, line.open.theta
    starts, _ = periodic(line, line.inputs)

    def run(amount):
        moved = theta + amount * np.eye(len(theta))[segment]
        one = LineOnMesh(line.open.line, mesh, moved, line.open.lag, line.n_stages, line.open.points, periodic=False)
        u, ends = line.inputs, []
        for start in starts:
            nothing = np.zeros((mesh.n_intervals, mesh.degree * one.size, start.shape[1]))
            states = one.response @ u + one.solve(nothing, start)
            ends.append(states[-1, -1])
            u, output = one.output_at_nodes(states), one.output_at_points(states)
        return output, np.array(ends)

    steps = [run(amount) for amount in (1e-3, -1e-3, 2e-3, -2e-3)]
    output, ends = ((8 * (a - b) - (c - d)) / 12e-3 for a, b, c, d in zip(*steps, strict=True))
    assert line.slopes[:, :, segment] == pytest.approx(output, abs=1e-7 * max(1.0, np.max(np.abs(output))))
    unit = np.eye(mesh.n_segments)[:, [segment]]
    nothing = np.zeros((*line.inputs.shape, 1))
    found = line.end(np.zeros((*line.shape, 1)), nothing, unit)[..., 0]
    assert found == pytest.approx(ends, abs=1e-7 * max(1.0, np.max(np.abs(ends))))


def test_what_runs_through_it():
    line = line_of("chain")
    assert line.n_stages == 3
    assert line.shape == (3, 2, 1)
    # The oscillator reads its delayed velocity.
    assert line.states == (1,)
    assert line.numbers == (0,)
