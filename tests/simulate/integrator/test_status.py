"""An integration says why it came back."""

import pytest

from pddecont.delay import Direct
from pddecont.native.integrator import Status
from pddecont.simulate import ReturnSection, Simulator
from pddecont.simulate.integrator import enlarge, make_log, run
from tests.conftest import numeric_from
from tests.simulate.motions import BALL, COUNTER, RELAY

SMOOTH = "name: m\nstates: [x]\nmodes: {m: {x': RATE}}\ninitial: {x: 1}\n"
TICKS = COUNTER.replace("H}", "sin(2*pi*c)}").replace("DIR", "rising")


@pytest.mark.parametrize(
    ("text", "section", "log", "steps", "status"),
    [
        (SMOOTH.replace("RATE", "-x"), None, (0, 0), 1 << 40, Status.REACHED),
        (SMOOTH.replace("RATE", "-x"), None, (0, 0), 3, Status.PAUSED),
        (SMOOTH.replace("RATE", "-x"), None, (2, 0), 1 << 40, Status.LOG_FULL),
        (SMOOTH.replace("RATE", "x**2"), None, (0, 0), 1 << 40, Status.STEP_TOO_SMALL),
        (SMOOTH.replace("RATE", "log(x - 1)"), None, (0, 0), 1 << 40, Status.NOT_FINITE),
        (TICKS, "e", (0, 0), 1 << 40, Status.SECTION),
        (BALL, None, (0, 0), 1 << 40, Status.ZENO),
        (RELAY.replace("H}", "x}").replace("parameters: {tau: 1}\n", ""), None, (0, 0), 1 << 40, Status.SLIDING),
    ],
    ids=lambda value: value.name if isinstance(value, Status) else "",
)
def test_each_status_has_its_motion(text, section, log, steps, status):
    numeric = numeric_from(text)
    simulator = Simulator(numeric, Direct(), section=ReturnSection(event=section))
    values = simulator.values(numeric.parameter_values)
    state, log = simulator.start(values), make_log(numeric.n_states, *log)
    while (found := run(simulator.system, values, state, log, simulator.work, 100.0, steps)) == Status.CAPACITY:
        state = enlarge(state)
    assert found == status


def test_a_state_that_is_full_asks_for_a_larger_one():
    numeric = numeric_from(TICKS)
    simulator = Simulator(numeric, Direct())
    values = simulator.values(numeric.parameter_values)
    state, log = simulator.start(values), make_log(numeric.n_states, 0, 0)
    # Events have to fit that may come at one moment, whatever came before.
    assert run(simulator.system, values, state, log, simulator.work, 1e3, 1 << 40) == Status.CAPACITY
    state = enlarge(state)
    assert run(simulator.system, values, state, log, simulator.work, 10.5, 1 << 40) == Status.REACHED
    assert list(state.segment_counts) == [10]
