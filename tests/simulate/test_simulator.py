"""A model ready to be integrated: starts, histories, chains, and what it refuses."""

import math

import numpy as np
import pytest
import sympy

from pddecont.delay import Chain, Direct
from pddecont.errors import ConvergenceError
from pddecont.model.expression import TIME
from pddecont.native.integrator import Status, T
from pddecont.simulate import Method, ReturnSection, Simulator
from tests.conftest import numeric_from, shipped

WAVE = (
    "name: w\nstates: [x, v]\nparameters: {a: 2, tau: 0.6}\n"
    "modes: {m: {x': v, v': -x(t - tau)}, n: {x': 0, v': 0}}\nevents: {e: x - 100}\n"
    "segments: {s: {mode: m, event: e, direction: rising, to: n}, r: {mode: n, event: e, direction: falling, to: m}}\n"
    "initial: {x: sin(a*t), v: 3}\n"
)


def start(delay=None, p=(2.0, 0.6), **given):
    simulator = Simulator(numeric_from(WAVE), delay or Direct())
    values = simulator.values(np.array(p))
    return simulator, values, simulator.start(values, **given)


def test_a_motion_starts_from_its_history():
    _, _, state = start(t=0.3)
    assert state.clock[T] == 0.3
    assert state.y == pytest.approx([math.sin(0.6), 3.0])


def test_states_and_mode_may_be_given():
    simulator, values, state = start(states=[5.0, 6.0], mode="n")
    assert list(state.y) == [5.0, 6.0]
    state, status = simulator.advance(values, state, 4.0)
    assert status == Status.REACHED
    assert list(state.y) == [5.0, 6.0]


def test_the_history_has_its_derivatives():
    simulator, values, _ = start()
    past = simulator.evaluate_history(values.p, 0.1)
    for k, derivative in enumerate(past):
        assert derivative[0] == pytest.approx(2.0**k * math.sin(0.2 + k * math.pi / 2))
    assert [d[1] for d in past] == [3.0, 0.0, 0.0, 0.0]


def test_a_history_may_be_replaced():
    simulator = Simulator(numeric_from(WAVE), Direct(), history=(TIME**2, sympy.Integer(7)))
    values = simulator.values(np.array([2.0, 0.6]))
    assert list(simulator.start(values, t=3.0).y) == [9.0, 7.0]


def test_a_chain_starts_from_the_history_and_its_derivatives():
    """Stage i is at t - (i + 1) tau/n; its variables are derivatives times powers of tau/n."""
    simulator, _, state = start(Chain(3, 4))
    w, delta = state.y[2:].reshape(4, 3), 0.15
    assert len(simulator.numeric.model.delayed) == 1
    for i in range(4):
        t = -(i + 1) * delta
        expected = [delta**k * 2.0**k * math.sin(2 * t + k * math.pi / 2) for k in range(3)]
        assert w[i] == pytest.approx(expected)


def test_a_constant_history_has_no_derivatives():
    _, _, state = start(Chain(3, 4), states=[5.0, 6.0], constant=True)
    assert state.y[2:].reshape(4, 3) == pytest.approx(np.array([[5.0, 0.0, 0.0]] * 4))
    _, _, state = start(states=[5.0, 6.0], constant=True)
    assert list(state.constant) == [5.0, 6.0]


def test_a_tangent_starts_in_the_same_direction_every_time():
    simulators = [Simulator(numeric_from(WAVE), Direct(), tangent=True) for _ in range(2)]
    tangents = [s.start(s.values(np.array([2.0, 0.6]))).y[2:] for s in simulators]
    assert np.array_equal(*tangents)
    assert np.linalg.norm(tangents[0]) > 0.1


def test_it_stops_at_each_return_to_its_section():
    numeric = numeric_from("name: m\nstates: [x, v]\nmodes: {m: {x': v, v': -x}}\ninitial: {x: 1}\n")
    section = ReturnSection(expr=numeric.model.state_symbols[0], direction="rising")
    simulator = Simulator(numeric, Direct(), section=section)
    values = simulator.values(np.zeros(0))
    state, times = simulator.start(values), []
    while True:
        state, status = simulator.advance(values, state, 20.0)
        if status != Status.SECTION:
            break
        times.append(state.clock[T])
    assert times == pytest.approx([1.5 * math.pi, 3.5 * math.pi, 5.5 * math.pi], abs=1e-8)


def test_other_parameters_hold_from_now_on():
    numeric = numeric_from("name: m\nstates: [x]\nparameters: {a: 1}\nmodes: {m: {x': a}}\n")
    simulator = Simulator(numeric, Direct())
    values = simulator.values(np.array([1.0]))
    state, _ = simulator.advance(values, simulator.start(values), 2.0)
    state, values = simulator.change_parameters(state, values, np.array([10.0]))
    state, _ = simulator.advance(values, state, 3.0)
    assert state.y[0] == pytest.approx(12.0)


def test_a_chain_of_high_order_and_a_stiff_tangent_are_refused():
    with pytest.raises(ConvergenceError, match="a chain of order 5 has growing solutions"):
        Simulator(shipped("wright"), Chain(5, 10))
    with pytest.raises(ConvergenceError, match="Lyapunov exponents go with the explicit method"):
        Simulator(shipped("wright"), Direct(), Method(stiff=True), tangent=True)


def test_functions_live_as_long_as_their_model():
    numeric = shipped("relay")
    one, other = Simulator(numeric, Direct()), Simulator(numeric, Direct(), tangent=True)
    assert one.functions is other.functions
    assert np.array_equal(one.system.field, other.system.field)
