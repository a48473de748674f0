"""An integration holds the records' arrays, each under its own name."""

import numpy as np
import pytest

from pddecont.delay import Direct

# Two states, two delays, an event that reads a delayed value, a delayed event, two modes.
MODEL = (
    "name: m\nstates: [x, v]\nparameters: {tau: 1, k: 2, d: 0.3}\n"
    "modes: {a: {x': v, v': -x(t - tau) - v(t - k*tau)}, b: {x': v, v': -x}}\n"
    "events: {up: x - 0.5 + v(t - tau), later: {after: up, delay: d}}\nresets: {turn: {v: -v}}\n"
    "segments:\n  one: {mode: a, event: up, direction: rising, reset: turn, to: b}\n"
    "  two: {mode: b, event: later, to: a}\n"
)
LENGTHS = {
    "dimension": 4,
    "n_pairs": 3,
    "n_delays": 2,
    "n_kept": 2,
    "n_segments": 2,
    "n_events": 2,
    "log_steps": 5,
    "log_events": 6,
}
LOG = {"log_n": "n", "event_before": "before", "event_after": "after"}


@pytest.fixture(scope="module")
def run(interpreted):
    return interpreted.prepare(MODEL, delay=Direct(), tangent=True, steps=5, events=6)


def record_of(run, name):
    """Return what a field of the core stands for in the records."""
    for record in (run.system, run.values, run.state, run.work):
        if name in record._fields:
            return getattr(record, name)
    name = LOG.get(name, name.removeprefix("log_") if name.startswith("log_") else name)
    return getattr(run.log, name)


def test_every_field_is_that_of_the_record_with_its_name(run):
    for name, value in run.core._asdict().items():
        if name in LENGTHS:
            assert value == LENGTHS[name], name
        elif name == "mask":
            assert value == len(run.state.past_time) - 1
            assert value & (value + 1) == 0
        elif isinstance(expected := record_of(run, name), np.ndarray):
            assert np.shares_memory(value, expected) or not expected.size, name
            assert value.dtype == expected.dtype, name
            assert value.size == expected.size, name
        else:
            assert value is expected or value == expected, name


def test_every_array_of_the_records_is_in_the_core(run):
    arrays = [a for r in (run.system, run.values, run.state, run.log, run.work) for a in r if isinstance(a, np.ndarray)]
    in_core = [a for a in run.core if isinstance(a, np.ndarray)]
    assert len(arrays) == len(in_core)
    for array in arrays:
        assert sum(np.shares_memory(array, other) for other in in_core) == 1 or not array.size
