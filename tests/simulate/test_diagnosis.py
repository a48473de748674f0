"""Why an integration came to a halt: the reason, the time, the mode, and what has no value."""

import numpy as np
import pytest

from pddecont.delay import Chain, Direct
from pddecont.errors import ConvergenceError
from pddecont.native.integrator import LAST_EVENT, ZENO_TIME, Status
from pddecont.simulate import FailureReason, Simulator, simulate
from tests.conftest import numeric_from
from tests.simulate.motions import BALL


def test_overflow_names_the_mode_and_the_time():
    numeric = numeric_from("name: m\nstates: [x]\nmodes: {up: {x': x**2}}\ninitial: {x: 1}\n")
    with pytest.raises(ConvergenceError, match=r"mode 'up'|step size"):
        simulate(numeric, numeric.parameter_values, Chain(2, 15), 2.0)
    numeric = numeric_from("name: m\nstates: [x]\nmodes: {down: {x': sqrt(x) - 5}}\ninitial: {x: 1}\n")
    with pytest.raises(ConvergenceError, match="mode 'down'"):
        simulate(numeric, numeric.parameter_values, Chain(2, 15), 2.0)


def failure_of(text, status, change=lambda state: None):
    numeric = numeric_from(text)
    simulator = Simulator(numeric, Direct())
    values = simulator.values(numeric.parameter_values)
    state = simulator.start(values, t=3.0)
    change(state)
    return simulator.diagnose(state, status, values.p)


@pytest.mark.parametrize(
    ("status", "reason"), [(Status.ZENO, FailureReason.ACCUMULATION), (Status.SLIDING, FailureReason.SLIDING)]
)
def test_events_without_a_way_on_are_named_with_their_time(status, reason):
    def change(state):
        state.clock[ZENO_TIME], state.count[LAST_EVENT] = 4.5, 0

    failure = failure_of(BALL, status, change)
    assert (failure.reason, failure.time, failure.event, failure.mode) == (reason, 4.5, "hit", "fly")


@pytest.mark.parametrize(
    ("status", "reason"),
    [(Status.NOT_FINITE, FailureReason.NOT_FINITE), (Status.STEP_TOO_SMALL, FailureReason.STEP_TOO_SMALL)],
)
def test_a_field_with_a_value_leaves_the_integrators_reason(status, reason):
    failure = failure_of("name: m\nstates: [x]\nmodes: {up: {x': x**2}}\ninitial: {x: 1}\n", status)
    assert (failure.reason, failure.time, failure.event, failure.mode) == (reason, 3.0, None, "up")


@pytest.mark.parametrize(
    ("rate", "detail"),
    [
        ("log(x - 1)", "log(x - 1) takes the logarithm of zero in x' of mode 'up', at t = 3, x = 1"),
        ("sqrt(x - 1 - 1e-13) - 1", "takes a root of a negative number"),
        ("1/(x - 1)", "divides by zero"),
        ("-1e6 + sqrt(x - 1)", "takes a root of a negative number"),  # a short way ahead
    ],
)
def test_a_part_without_a_value_is_named(rate, detail):
    failure = failure_of(
        f"name: m\nstates: [x]\nmodes: {{up: {{x': {rate}}}}}\ninitial: {{x: 1}}\n", Status.STEP_TOO_SMALL
    )
    assert failure.reason == FailureReason.UNDEFINED
    assert detail in failure.detail


def test_delayed_values_are_those_read_last():
    numeric = numeric_from("name: m\nstates: [x]\nmodes: {up: {x': log(x(t - 1))}}\ninitial: {x: 1}\n")
    simulator = Simulator(numeric, Direct())
    values = simulator.values(np.zeros(0))
    state = simulator.start(values)
    simulator.work.xd[0] = -2.0
    failure = simulator.diagnose(state, Status.STEP_TOO_SMALL, values.p)
    assert "takes the logarithm of a negative number (-2)" in failure.detail
