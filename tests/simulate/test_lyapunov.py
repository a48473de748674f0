"""Lyapunov exponents of motions whose exponents are known."""

import math

import numpy as np
import pytest
from scipy.special import lambertw

from pddecont.delay import Direct
from pddecont.simulate import (
    FailureReason,
    LyapunovExponent,
    Method,
    MotionFailure,
    ReturnSection,
    ReturnSettings,
    Simulator,
    find_attractor,
    find_lyapunov_exponent,
)
from tests.conftest import numeric_from, shipped
from tests.simulate.motions import BALL, with_parameters


def exponent(numeric, settings, duration, section=None, **given):
    p = with_parameters(numeric, **given)
    simulator = Simulator(numeric, Direct(), Method(), section or ReturnSection())
    values = simulator.values(p)
    attractor = find_attractor(simulator, values, simulator.start(values), settings)
    assert attractor.failure is None
    found = find_lyapunov_exponent(simulator, values, attractor, duration)
    assert found.failure is None
    return attractor, found.value, found.uncertainty


def test_exponent_of_a_linear_delay_equation_is_its_largest_root():
    numeric = numeric_from(
        "name: l\nstates: [x]\nparameters: {p: 1}\nforcing: {period: p}\nmodes: {m: {x': -x(t - 1) + sin(2*pi*t)}}\n"
    )
    _, value, error = exponent(numeric, ReturnSettings(1.0, 0.0, 400.0, 4, 50), 400.0)
    assert error < 3e-3
    assert value == pytest.approx(lambertw(-1).real, abs=error)


@pytest.mark.parametrize(
    ("name", "period", "given", "expected"),
    [
        ("pulsed_control", 1.0, {"b": 0.5, "q": 0.55}, math.log(0.9375213103)),
        ("wall_oscillator", math.pi, {}, math.log(abs(0.6829504 + 0.0321948j)) / math.pi),
        # The orbit takes two forcing periods.
        ("impact_oscillator", 2 * math.pi / 0.8, {"K": 0.12}, math.log(0.327612842) / (4 * math.pi / 0.8)),
    ],
)
def test_exponent_of_an_orbit_is_its_multiplier_s_logarithm(name, period, given, expected):
    _, value, error = exponent(shipped(name), ReturnSettings(period, 0.0, 400 * period, 8, 50), 300 * period, **given)
    assert error < 3e-3
    assert value == pytest.approx(expected, abs=error)


@pytest.mark.parametrize(
    ("name", "event"), [("relay", "switch"), ("on_off_control", "switch"), ("spiking_neuron", "spike")]
)
def test_exponent_of_an_autonomous_orbit_is_zero(name, event):
    _, value, error = exponent(shipped(name), ReturnSettings(0.0, 0.0, 100.0, 4, 50), 200.0, ReturnSection(event=event))
    assert error < 0.01
    assert value == pytest.approx(0.0, abs=error)


def test_a_bouncing_ball_in_step_with_its_table():
    attractor, value, error = exponent(
        shipped("bouncing_ball"), ReturnSettings(2 * math.pi, 0.0, 3000.0, 8, 200), 2000.0, G=0.6
    )
    # The product of a bounce's multipliers is r^2, and they are complex: each has modulus r.
    assert (attractor.period, value) == (1, pytest.approx(math.log(0.8) / (2 * math.pi), abs=error))


def test_a_motion_that_forgets_where_it_came_from_has_minus_infinity():
    """Each tick sets x to 1, and the phase is the forcing's."""
    numeric = numeric_from(
        "name: m\nstates: [x]\nparameters: {w: 1}\nforcing: {period: w}\nmodes: {m: {x': -x}}\n"
        "events: {tick: sin(2*pi*t)}\nresets: {one: {x: 1}}\n"
        "segments: {s: {mode: m, event: tick, direction: rising, reset: one, to: m}}\n"
    )
    _, value, error = exponent(numeric, ReturnSettings(1.0, 0.5, 100.0, 4, 20), 50.0)
    assert (value, error) == (-np.inf, 0.0)


def ball_attractor(failure=None):
    """The ball in flight, as if that were an attractor: a motion that comes to a halt."""
    numeric = numeric_from(BALL)
    simulator = Simulator(numeric, Direct(), Method(), ReturnSection(event="hit"))
    values = simulator.values(numeric.parameter_values)
    attractor = find_attractor(simulator, values, simulator.start(values), ReturnSettings(0.0, 0.0, 2.0, 1, 3))
    object.__setattr__(attractor, "failure", failure)
    return simulator, values, attractor


def test_a_motion_that_cannot_be_followed_says_why():
    found = find_lyapunov_exponent(*ball_attractor(), 50.0)
    assert found.failure is not None
    assert found.failure.is_like(MotionFailure(FailureReason.ACCUMULATION, event="hit"))
    assert np.isnan(found.value)


def test_a_motion_that_failed_has_none():
    simulator, values, attractor = ball_attractor(MotionFailure(FailureReason.NOT_SETTLED))
    found = find_lyapunov_exponent(simulator, values, attractor, 50.0)
    assert isinstance(found, LyapunovExponent)
    assert np.isnan(found.value)
    assert found.failure is None
