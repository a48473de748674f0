"""Periods are found in the returns of a motion, the smallest one, and none where there is none."""

import math

import numpy as np
import pytest

from pddecont.delay import Direct
from pddecont.native.integrator import Status
from pddecont.simulate import ReturnSection, ReturnSettings, Simulator, find_attractor
from pddecont.simulate.integrator import make_return_buffer, make_returns
from tests.conftest import numeric_from

# At every whole t: y = r y (1 - y).
LOGISTIC = (
    "name: m\nstates: [y]\nparameters: {r: 4, w: 1}\nforcing: {period: w}\nmodes: {m: {y': 0}}\nevents: {tick: "
    "sin(2*pi*t)}\nresets: {fold: {y: r*y*(1 - y)}}\n"
    "segments: {s: {mode: m, event: tick, direction: rising, reset: fold, to: m}}\ninitial: {y: 0.3}\n"
)


@pytest.mark.parametrize(("r", "period"), [(2.8, 1), (3.2, 2), (3.5, 4), (3.55, 8), (3.831, 3), (3.9, 0)])
def test_periods_of_the_logistic_map(r, period):
    simulator = Simulator(numeric_from(LOGISTIC), Direct())
    values = simulator.values(np.array([r, 1.0]))
    found = find_attractor(simulator, values, simulator.start(values), ReturnSettings(1.0, 0.5, 1500.0, 16, 50))
    assert (found.period, found.failure) == (period, None)
    if period:
        assert found.turn == pytest.approx(period)
        y = found.states[:, 0]
        assert r * y * (1 - y) == pytest.approx(np.roll(y, -1), abs=1e-6)
        assert list(found.segment_counts.values()) == [period]


def returns_of(interpreted, run, states, gaps, max_period=8):
    """Return returns to a section, as the integrator records them."""
    buffer = make_return_buffer(run.system, len(states) + 1, max_period)
    returns = make_returns(run.system, buffer, 0.0)._replace(n_compared=1)
    for k, y in enumerate(states):
        buffer.states[k, 0], buffer.times[k], buffer.number[0] = y, np.sum(gaps[: k + 1]), k + 1
        interpreted.poincare._measure_sizes(run.core, returns, k + 1, gaps[k])
        for q in range(1, min(max_period, k) + 1):
            buffer.distances[k, q] = interpreted.poincare._measure_distance(returns, k, k - q)
    return returns


@pytest.mark.parametrize(
    ("cycle", "period"), [([1.0], 1), ([1.0, 2.0], 2), ([1.0, 2.0, 1.5], 3), ([1.0, 1.0, 1.0, 2.0], 4)]
)
def test_the_smallest_period_is_taken(interpreted, cycle, period):
    run = interpreted.start("name: m\nstates: [y]\nmodes: {m: {y': 0}}\n", [1.0])
    states = (cycle * 40)[:40]
    returns = returns_of(interpreted, run, states, [1.0] * 40)
    found = interpreted.poincare._find_period(returns, 8, 1e-7)
    assert found == period


def test_a_motion_that_still_settles_to_period_1_has_not_period_3(interpreted):
    """Multipliers near a third root of 1: every third return is close long before the next is."""
    run = interpreted.start("name: m\nstates: [y]\nmodes: {m: {y': 0}}\n", [1.0])
    states = [1 + 1e-3 * 0.999**k * math.cos(2 * math.pi * k / 3) for k in range(40)]
    returns = returns_of(interpreted, run, states, [1.0] * 40)
    assert interpreted.poincare._find_period(returns, 8, 1e-7) == 0


def test_returns_at_uneven_times_are_not_periodic(interpreted):
    run = interpreted.start("name: m\nstates: [y]\nmodes: {m: {y': 0}}\n", [1.0])
    gaps = np.linspace(1.0, 2.0, 40)
    returns = returns_of(interpreted, run, [1.0] * 40, gaps)
    assert interpreted.poincare._find_period(returns, 8, 1e-7) == 0


@pytest.mark.parametrize(
    ("phase", "t", "expected"), [(0.0, 0.0, 2.0), (0.25, 0.0, 0.5), (0.0, 1.9, 2.0), (0.5, 1.0, 3.0)]
)
def test_returns_by_the_forcing_are_at_its_phase(interpreted, phase, t, expected):
    run = interpreted.start("name: m\nstates: [y]\nmodes: {m: {y': 1}}\n", [0.0], t=t)
    stop = np.full(1, np.nan)
    status = interpreted.poincare.advance_to_return(run.core, 2.0, phase, 100.0, stop)
    assert status == Status.SECTION
    assert run.state.clock[0] == pytest.approx(expected, abs=1e-13)
    assert math.isnan(stop[0])


def test_returns_to_a_section_are_its_crossings():
    numeric = numeric_from("name: m\nstates: [x, v]\nmodes: {m: {x': v, v': -x}}\ninitial: {x: 1}\n")
    section = ReturnSection(expr=numeric.model.state_symbols[0] - 0.5, direction="falling")
    simulator = Simulator(numeric, Direct(), section=section)
    values = simulator.values(np.zeros(0))
    found = find_attractor(simulator, values, simulator.start(values), ReturnSettings(0.0, 0.0, 200.0, 4, 20))
    assert (found.period, found.turn) == (1, pytest.approx(2 * math.pi, abs=1e-7))
    assert found.states[0] == pytest.approx([0.5, -math.sqrt(0.75)], abs=1e-7)
