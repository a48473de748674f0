"""Integrations go on with other parameters; machine code does what its Python source does."""

import numpy as np
import pytest

from pddecont.delay import Chain, Direct
from pddecont.native.integrator import N_STEPS, Status, T
from pddecont.simulate import Simulator, simulate
from pddecont.simulate.integrator import enlarge
from tests.conftest import numeric_from
from tests.simulate.integrator.conftest import make_plain_core
from tests.simulate.motions import TIGHT

BOUNCING = (
    "name: m\nstates: [x, v, y]\nparameters: {tau: 0.8, w: 2}\nforcing: {period: 2*pi/w}\n"
    "modes: {m: {x': v, v': cos(w*t) - x, y': x(t - tau) - y}}\nevents: {hit: x, kick: {after: hit, delay: tau}}\n"
    "resets: {turn: {v: -0.9*v}, push: {y: y + 1}}\n"
    "segments:\n  a: {mode: m, event: hit, direction: falling, reset: turn, to: m}\n"
    "  b: {mode: m, event: kick, reset: push, to: m}\ninitial: {v: 1}\n"
)


@pytest.mark.parametrize("delay", [Direct(), Chain(2, 3)])
def test_machine_code_does_what_its_source_does(interpreted, delay):
    numeric = numeric_from(BOUNCING)
    simulator = Simulator(numeric, delay)
    values = simulator.values(numeric.parameter_values)
    compiled, status = simulator.advance(values, simulator.start(values), 3.0)
    assert status == Status.REACHED
    run = interpreted.start(BOUNCING, [0.0, 1.0, 0.0], delay=delay)
    state = run.state
    state.y[:] = simulator.start(values).y
    status = interpreted.advance.run(run.core, 3.0, 1 << 40)
    while status == Status.CAPACITY:
        state = enlarge(state)
        core = make_plain_core(run.system, run.values, state, run.log, run.work)
        status = interpreted.advance.run(core, 3.0, 1 << 40)
    assert status == Status.REACHED
    assert list(state.segment_counts) == list(compiled.segment_counts) != [0, 0]
    assert state.count[N_STEPS] == compiled.count[N_STEPS]
    assert state.clock[T] == compiled.clock[T] == 3.0
    assert state.y == pytest.approx(compiled.y, rel=1e-12, abs=1e-14)


def test_as_many_steps_are_made_as_are_allowed(interpreted):
    run = interpreted.start("name: m\nstates: [x]\nmodes: {m: {x': -x}}\n", [1.0])
    for steps in (1, 2, 3):
        status = interpreted.advance.run(run.core, 1e9, 1)
        assert status == Status.PAUSED
        assert run.state.count[N_STEPS] == steps


# Parameters that change.
def test_a_delay_that_changes_on_the_way():
    """c = t, x' = c(t - tau) with tau 1, then 3, then 1/2; c = 0 before 0."""
    numeric = numeric_from("name: h\nstates: [x, c]\nparameters: {tau: 1}\nmodes: {m: {x': c(t - tau), c': 1}}\n")
    trajectory = simulate(
        numeric, np.array([1.0]), Direct(), 6.0, TIGHT, schedule=[(2.0, np.array([3.0])), (4.0, np.array([0.5]))]
    )
    half_squares = [max(u, 0) ** 2 / 2 for u in (-1, 1, -1, 1, 3.5, 5.5)]
    assert trajectory(6.0)[0] == pytest.approx(
        half_squares[1] - half_squares[0] + half_squares[3] - half_squares[2] + half_squares[5] - half_squares[4],
        abs=1e-12,
    )


def test_a_delay_that_changes_reads_the_jumps_of_the_past_again():
    numeric = numeric_from(
        "name: r\nstates: [x, y, c]\nparameters: {tau: 1}\nmodes: {m: {x': 0, y': x(t - tau), c': 1}}\n"
        "events: {e: c - 1}\n"
        "resets: {up: {x: x + 1, c: 0}}\nsegments: {s: {mode: m, event: e, direction: rising, reset: up, "
        "to: m}}\n"
    )
    schedule = [(5.25, np.array([3.2])), (11.1, np.array([0.3]))]
    trajectory = simulate(numeric, np.array([1.0]), Direct(), 20.5, TIGHT, schedule=schedule)

    def area(u):
        whole, part = divmod(max(u, 0.0), 1.0)
        return whole * (whole - 1) / 2 + whole * part

    expected = area(4.25) + area(11.1 - 3.2) - area(5.25 - 3.2) + area(20.2) - area(10.8)
    assert trajectory(20.5)[1] == pytest.approx(expected, abs=1e-11)


def test_a_chain_keeps_its_derivatives_where_a_delay_changes():
    """x = t: the chain's stages are lines too, whose derivatives do not change with the delay."""
    numeric = numeric_from(
        "name: h\nstates: [c, y]\nparameters: {tau: 1}\nmodes: {m: {c': 1, y': c(t - tau)}}\ninitial: {c: t}\n"
    )
    simulator = Simulator(numeric, Chain(3, 4))
    values = simulator.values(np.array([1.0]))
    state, _ = simulator.advance(values, simulator.start(values), 2.0)
    w = state.y[2:].reshape(4, 3).copy()
    state, _ = simulator.change_parameters(state, values, np.array([0.25]))
    assert state.y[2:].reshape(4, 3) == pytest.approx(w * [1, 0.25, 0.25**2])
    assert w[:, 1] == pytest.approx([0.25] * 4)
