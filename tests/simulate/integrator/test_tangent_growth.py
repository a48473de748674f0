"""The growth of a tangent over intervals."""

import numpy as np
import pytest

from pddecont.delay import Chain, Direct
from pddecont.native.integrator import Status
from pddecont.simulate import Simulator
from pddecont.simulate.integrator import enlarge, measure_growth
from tests.conftest import numeric_from


def grow(text, interval, n, delay=None):
    numeric = numeric_from(text)
    simulator = Simulator(numeric, delay or Direct(), tangent=True)
    values = simulator.values(numeric.parameter_values)
    state, logs, done = simulator.start(values), np.zeros(n), np.array([0.0, np.nan])
    while (
        status := measure_growth(simulator.system, values, state, simulator.work, interval, logs, done)
    ) == Status.CAPACITY:
        state = enlarge(state)
    return Status(status), logs, done, state


@pytest.mark.parametrize("rate", [-2.0, 0.3])
def test_a_linear_equation_grows_by_its_rate(rate):
    status, logs, done, state = grow(
        f"name: m\nstates: [x]\nmodes: {{m: {{x': {rate}*x}}}}\ninitial: {{x: 1}}\n", 0.5, 10
    )
    assert status == Status.REACHED
    assert logs == pytest.approx(np.full(10, 0.5 * rate), rel=1e-7)
    assert done[0] == 10
    assert state.y[1] == pytest.approx(1.0)


def test_resets_multiply_the_tangent():
    """x doubles at every whole time and does not move else: half the unit intervals hold no doubling."""
    text = (
        "name: m\nstates: [x, c]\nmodes: {m: {x': 0, c': 1}}\nevents: {e: c - 1}\nresets: {r: {x: 2*x, c: 0}}\n"
        "segments: {s: {mode: m, event: e, direction: rising, reset: r, to: m}}\ninitial: {x: 1}\n"
    )
    _, logs, _, _ = grow(text, 10.0, 20)
    # The tangent in c stays, so that of x outgrows it.
    assert np.sum(logs[5:]) == pytest.approx(150 * np.log(2.0))


def test_a_delay_equation_grows_by_its_largest_root():
    """x' = x(t - 1): the root of s = exp(-s) is 0.5671432904."""
    _, logs, _, _ = grow("name: m\nstates: [x]\nmodes: {m: {x': x(t - 1)}}\ninitial: {x: 1}\n", 2.0, 30)
    assert logs[-1] / 2 == pytest.approx(0.5671432904, rel=1e-6)


def test_a_chain_grows_by_its_own_root():
    """x' = x_n, with sum_k (delta s)^k/k! for each of n stages: s (1 + s/2 + s^2/8)^2 = 1 for order 2, n = 2."""
    root = np.max(
        [
            r.real
            for r in np.roots(
                np.polymul([1, 0], np.polymul([1 / 8, 1 / 2, 1], [1 / 8, 1 / 2, 1])) - np.array([0, 0, 0, 0, 0, 1])
            )
            if abs(r.imag) < 1e-12
        ]
    )
    _, logs, _, _ = grow("name: m\nstates: [x]\nmodes: {m: {x': x(t - 1)}}\ninitial: {x: 1}\n", 2.0, 30, Chain(2, 2))
    assert logs[-1] / 2 == pytest.approx(root, rel=1e-6)


def test_a_tangent_that_vanishes_ends_it():
    text = (
        "name: m\nstates: [x, c]\nmodes: {m: {x': 0, c': 1}}\nevents: {e: c - 1}\nresets: {r: {x: 1, c: 0}}\n"
        "segments: {s: {mode: m, event: e, direction: rising, reset: r, to: m}}\ninitial: {x: 1}\n"
    )
    _, logs, done, _ = grow(text.replace("c: 0}}", "c: 0}}"), 1.5, 10)
    assert done[0] <= 10
    assert np.all(logs[int(done[0]) :] == 0.0)
