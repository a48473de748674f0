"""Event functions: their slopes along the flow, and how near to zero they are zero."""

import math

import numpy as np
import pytest

from tests.simulate.motions import COUNTER

MODEL = (
    "name: m\nstates: [x, v]\nparameters: {k: 3, p: 1}\nforcing: {period: p}\n"
    "modes: {m: {x': v, v': -k*x + sin(2*pi*t)}}\n"
    "events: {e: x**2*v - cos(2*pi*t), d: x(t - 0.4) - x}\nresets: {n: {}}\n"
    "segments: {s: {mode: m, event: e, direction: rising, reset: n, to: m}, r: {mode: m, event: d, direction: rising, "
    "reset: n, to: m}}\ninitial: {x: 0.3*t, v: 1}\n"
)


@pytest.fixture
def run(interpreted):
    return interpreted.start(MODEL, [0.3, -0.7], t=0.1)


def test_values(interpreted, run):
    assert interpreted.event_functions.evaluate_event(run.core, 0, 0.1, run.core.y) == pytest.approx(
        0.09 * -0.7 - math.cos(0.2 * math.pi)
    )
    assert interpreted.event_functions.evaluate_event(run.core, 1, 0.1, run.core.y) == pytest.approx(0.3 * -0.3 - 0.3)


def test_a_slope_is_that_along_the_flow(interpreted, run):
    """d/dt of x^2 v - cos(2 pi t): 2 x v x' + x^2 v' + 2 pi sin(2 pi t); of x(t - 0.4) - x: 0.3 - v in the history."""
    slope, _ = interpreted.event_functions.evaluate_event_slope(run.core, 0, 0, 0.1, run.core.y)
    x, v, sine = 0.3, -0.7, math.sin(0.2 * math.pi)
    assert slope == pytest.approx(2 * x * v * v + x**2 * (-3 * x + sine) + 2 * math.pi * sine)
    slope, _ = interpreted.event_functions.evaluate_event_slope(run.core, 1, 0, 0.1, run.core.y)
    assert slope == pytest.approx(0.3 + 0.7)


@pytest.mark.parametrize("c", [1.0, 1e3, 1e6])
def test_what_is_zero_to_rounding_grows_with_the_terms(interpreted, c):
    run = interpreted.start(COUNTER.replace("H}", "sin(c) - cos(c)}").replace("DIR", "any"), [c, 0.0], t=c)
    zero = c - c % math.pi + math.pi / 4
    run.core.y[0] = zero
    value = interpreted.event_functions.evaluate_event(run.core, 0, zero, run.core.y)
    slope, size = interpreted.event_functions.evaluate_event_slope(run.core, 0, 0, zero, run.core.y)
    assert abs(slope) == pytest.approx(math.sqrt(2))
    assert abs(value) < size < 1e-12 * c
    assert np.sign(slope) == (1 if round((zero - math.pi / 4) / math.pi) % 2 == 0 else -1)
