"""What goes out to workers arrives as it was, and its functions are made once."""

import pickle

import numpy as np

from pddecont.codegen import machine_code
from pddecont.delay import Chain
from pddecont.simulate import InitialState, Method, MotionTask, ReturnSection
from tests.conftest import shipped


def task_of(name="impact_oscillator", **given):
    return MotionTask(shipped(name), Chain(2, 4), Method(1e-8, 1e-10), ReturnSection(event=None), **given)


def test_simulators_share_functions_but_no_intermediate_results():
    task = task_of()
    one, other = task.make_simulator(), task.make_simulator()
    assert one.functions is other.functions
    assert one.work is not other.work
    assert not np.shares_memory(one.work.stages, other.work.stages)


def test_functions_are_generated_once_for_all_chunks(monkeypatch):
    written, write = [], machine_code.write_machine_source
    monkeypatch.setattr(machine_code, "write_machine_source", lambda *a: written.append(a) or write(*a))
    task = task_of()
    for _ in range(3):
        assert task.make_simulator().system.field.all()
    assert len(written) == 5


def test_a_task_travels_and_gives_the_same_motion():
    task = task_of()
    simulator = task.make_simulator()
    assert simulator.system.field.all()
    arrived = pickle.loads(pickle.dumps(task))
    assert arrived.method == task.method
    ends = []
    for t in (task, arrived):
        simulator = t.make_simulator()
        values = simulator.values(t.numeric.parameter_values)
        state, _ = simulator.advance(values, simulator.start(values), 40.0)
        ends.append(state.y)
    assert np.array_equal(*ends)


def test_an_initial_state_travels():
    start = pickle.loads(pickle.dumps(InitialState(np.array([1.0, 2.0]), "m", True)))
    assert list(start.states) == [1.0, 2.0]
    assert (start.mode, start.constant) == ("m", True)
