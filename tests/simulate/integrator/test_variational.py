"""The tangent at events: neighbours meet them earlier or later."""

import numpy as np
import pytest

from pddecont.delay import Direct
from pddecont.simulate import Method, ReturnSection, Simulator
from tests.conftest import shipped
from tests.simulate.motions import with_parameters

BOUNCE = (
    "name: b\nstates: [y, v]\nparameters: {r: 0.8}\nmodes: {m: {y': v, v': -10}}\nevents: {hit: y}\n"
    "resets: {b: {v: -r*v}}\nsegments: {s: {mode: m, event: hit, direction: falling, reset: b, to: m}}\n"
)


def test_a_neighbour_meets_an_event_later_by_its_distance_over_the_speed(interpreted):
    run = interpreted.start(BOUNCE, [0.0, -4.0], tangent=True)
    run.core.y[2:] = [0.5, 3.0]
    assert interpreted.variational.find_event_shift(run.core, 0, 0, 0.0) == pytest.approx(0.5 / 4.0)


def test_the_jump_at_an_impact_is_the_saltation_matrix(interpreted):
    """v+ = -r v-: dy+ = -r dy, dv+ = -r dv + (1 + r) a dy / v (Mueller 1995), with a = -10, v = -4."""
    run = interpreted.start(BOUNCE, [0.0, -4.0], tangent=True)
    c, variational, r, v, a = run.core, interpreted.variational, 0.8, -4.0, -10.0
    dy, dv = 0.5, 3.0
    c.y[2:] = [dy, dv]
    shift = variational.find_event_shift(c, 0, 0, 0.0)
    variational.map_tangent(c, 0, 0, 0.0, shift)
    c.y[:2] = [0.0, -r * v]
    variational.set_tangent(c, 0, 0.0, shift)
    assert c.y[2:] == pytest.approx([-r * dy, -r * dv + (1 + r) * a * dy / v])


@pytest.mark.parametrize(
    ("name", "given", "t"),
    [("impact_oscillator", {"K": 0.12}, 26.0), ("relay", {"a": 0.5}, 9.0), ("pulsed_control", {}, 4.3)],
)
def test_a_tangent_is_the_difference_of_two_motions(name, given, t):
    """Over events, and over the delays after them at which their jumps come back; the histories are constant."""
    numeric, h = shipped(name), 1e-6
    p = with_parameters(numeric, **given)
    simulator = Simulator(numeric, Direct(), Method(1e-12, 1e-13), ReturnSection(), tangent=True)
    values, n = simulator.values(p), numeric.n_states
    start = simulator.start(values, constant=True).y[:n].copy()
    direction = np.random.default_rng(2).normal(size=n)
    state = simulator.start(values, start, constant=True)
    state.y[n:] = direction
    state, _ = simulator.advance(values, state, t)
    ends = []
    for sign in (1, -1):
        # The history stays as it is.
        other = simulator.start(values, start, constant=True)
        other.y[:n] += sign * h * direction
        other, _ = simulator.advance(values, other, t)
        assert list(other.segment_counts) == list(state.segment_counts)
        ends.append(other.y[:n].copy())
    assert state.segment_counts.sum() > 1
    assert state.y[n:] == pytest.approx((ends[0] - ends[1]) / (2 * h), rel=1e-4, abs=1e-5)
