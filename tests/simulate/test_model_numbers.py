"""The numbers of a model at given parameters, and how long its steps may be."""

import math

import numpy as np
import pytest

from pddecont.delay import Chain, Direct
from pddecont.simulate import Method, Simulator
from tests.conftest import numeric_from, shipped
from tests.simulate.motions import BALL

FORCED = (
    "name: m\nstates: [x]\nparameters: {tau: 0.5, p: 3}\nforcing: {period: p}\n"
    "modes: {m: {x': -x(t - tau) - x(t - 4*tau)}}\n"
)


def values_of(text, p, delay=None, method=None, longest=0.0):
    return Simulator(numeric_from(text), delay or Direct(), method or Method()).values(np.array(p), longest)


@pytest.mark.parametrize(
    ("p", "delay", "method", "longest_step"),
    [
        ([0.5, 3.0], Direct(), Method(), 0.5),  # the shortest delay
        ([0.5, 0.8], Direct(), Method(), 0.4),  # half the period of the forcing
        ([0.0, 3.0], Direct(), Method(), 1.5),  # a delay of zero bounds nothing
        ([0.5, 3.0], Chain(2, 3), Method(), 1.5),  # nor does one that is a chain
        ([0.5, 3.0], Direct(), Method(max_step=0.1), 0.1),
    ],
)
def test_a_step_is_no_longer_than_what_it_depends_on(p, delay, method, longest_step):
    assert values_of(FORCED, p, delay, method).max_step == longest_step


def test_the_past_is_kept_for_the_longest_delay_or_longer():
    assert values_of(FORCED, [0.5, 3.0]).longest == 2.0
    assert values_of(FORCED, [0.5, 3.0], longest=7.0).longest == 7.0
    assert values_of("name: m\nstates: [x]\nmodes: {m: {x': -x}}\n", []).max_step == math.inf


def test_events_stick_to_the_modes_that_the_method_names():
    simulator = Simulator(numeric_from(BALL), Direct(), Method(stick={"hit": "lie"}))
    assert list(simulator.numeric.model.segments) == ["hop", "hop>lie"]
    assert list(simulator.system.resting) == [1, -1]
    assert list(Simulator(numeric_from(BALL), Direct()).system.resting) == [-1]


def test_of_several_modes_of_rest_the_method_chooses():
    still = "lie: {y': 0, v': 0}"
    text = BALL.replace("to: fly}", "to: fly, rest: lie}").replace(still, f"{still}, {still.replace('lie', 'doze')}")
    assert list(Simulator(numeric_from(text), Direct()).system.resting) == [1, -1]
    simulator = Simulator(numeric_from(text), Direct(), Method(stick={"hit": "doze"}))
    assert list(simulator.numeric.model.segments) == ["hop", "hop>lie", "hop>doze"]
    assert list(simulator.system.resting) == [2, -1, -1]


def test_derivatives_are_compiled_for_those_who_use_them():
    numeric = shipped("impact_oscillator")

    def addresses(method, tangent):
        system = Simulator(numeric, Direct(), method, tangent=tangent).system
        return bool(np.all(system.field_jacobian)), bool(np.all(system.reset_jacobian))

    assert addresses(Method(), False) == (False, False)
    assert addresses(Method(stiff=True), False) == (True, False)
    assert addresses(Method(), True) == (True, True)
