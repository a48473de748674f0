"""What motions reach is built on the way: with the numbers, and the words, that all modes built at once give."""

import pickle

import numpy as np
import pytest

from pddecont.delay import Direct
from pddecont.model import derived_modes
from pddecont.simulate import Simulator, pack_motion, unpack_motion
from tests.conftest import numeric_from
from tests.runs import run

# Friction in one state, a wall in the other, a kick that may change both digits.
MODEL = {
    "name": "both",
    "states": ["x", "v", "y", "w"],
    "parameters": {"F": 1.5, "K": 0.05},
    "forcing": {"period": "2*pi/0.9"},
    "equations": {
        "x'": "v",
        "v'": "F*cos(0.9*t) - x - 0.1*v - 0.5*sign(v) + K*y",
        "y'": "w",
        "w'": "cos(0.9*t) - y - 0.3*w - 4*max(0, y - 0.6) - K*v",
    },
    "switches": {"slip": "v", "wall": "y - 0.6"},
    "jumps": {"kick": {"at": "y + 0.2", "direction": "falling", "reset": {"v": "v + 0.3", "w": "w - 0.1"}}},
    "initial": {"x": 0.5, "v": 0.1},
}
# A ball that comes to rest on a table beside a block that sticks.
RESTING = {
    "name": "table",
    "states": ["y", "v", "u"],
    "parameters": {"G": 1.3, "r": 0.5},
    "forcing": {"period": "2*pi"},
    "equations": {"y'": "v", "v'": "G*sin(t) - 1", "u'": "0.7*sin(t) - 0.5*sign(u)"},
    "switches": {"slip": "u"},
    "jumps": {"stop": {"at": "y", "direction": "falling", "reset": {"v": "-r*v"}, "rest": True}},
    "initial": {"y": 1, "u": 0.1},
}
RESTING_STEPS = [
    {"name": "transient", "simulate": {"t_end": 60}},
    {"name": "orbit", "orbit": {"from": "transient", "stability": True}},
    {"name": "swept", "sweep": {"over": {"G": [1.2, 1.4, 3]}, "transient": "20*pi"}},
]
SETTLED = "200*pi/0.9"
STEPS = [
    {"name": "transient", "simulate": {"t_end": 300}},
    {"name": "orbit", "orbit": {"from": "transient", "stability": True}},
    {"name": "less", "continue": {"from": "orbit", "free": ["F"], "range": {"F": [1.3, 1.6]}, "stability": True}},
    {"name": "swept", "sweep": {"over": {"F": [1.2, 1.6, 5]}, "transient": SETTLED, "lyapunov": True}},
    {"name": "carried", "sweep": {"over": {"F": [1.2, 1.6, 5]}, "transient": SETTLED, "carry": "up"}},
    {"name": "basin", "basin": {"over": {"x": [-1, 1, 3], "v": [-1, 1, 3]}, "transient": SETTLED}},
    {"name": "again", "orbit": {"from": {"step": "swept", "point": "A3"}}},
]


def build_as_reached(monkeypatch):
    """Let no model have so few modes that all of them are built at once."""
    monkeypatch.setattr(derived_modes, "FEW_MODES", 0)


@pytest.mark.parametrize(("model", "steps"), [(MODEL, STEPS), (RESTING, RESTING_STEPS)], ids=["walls", "rests"])
def test_a_whole_run_gives_the_same(monkeypatch, tmp_path, model, steps):
    """Rows, events and segments are those of all modes built at once, whatever the order in which they were reached."""
    whole = run({**model, "run": {"steps": steps}}, tmp_path / "whole.h5")
    build_as_reached(monkeypatch)
    reached = run({**model, "run": {"steps": steps}}, tmp_path / "reached.h5")
    for name in whole.steps:
        one, other = whole.step(name), reached.step(name)
        assert len(one) == len(other) > 0, name
        assert one.labels == other.labels
        for key, column in one.points.items():
            if key not in ("n_segments", "surfaces"):
                assert np.array_equal(column, other.points[key], equal_nan=column.dtype.kind == "f"), (name, key)
        if "n_segments" in one.points:
            for counts, others in zip(one.points["n_segments"], other.points["n_segments"], strict=True):
                assert count(one, counts) == count(other, others)
        for i in range(len(one)):
            for key in ("states", "unknowns", "signature", "returns", "event_time", "multipliers"):
                if key in one.orbit(i):
                    assert np.array_equal(one.orbit(i)[key], other.orbit(i)[key]), (name, key)
    assert 3 < len(names(reached)) <= len(names(whole))


def test_a_rest_is_reached_where_the_impacts_accumulate(monkeypatch):
    """A ball that falls from 1 lies after (1 + 2 r/(1 - r)) sqrt(2), in a mode that nothing has led to before.

    Then 0.7 sin t is below -0.5: what slides beside it slips down.
    """
    build_as_reached(monkeypatch)
    numeric = numeric_from({**RESTING, "parameters": {"G": 0, "r": 0.5}})
    simulator = Simulator(numeric, Direct())
    values = simulator.values(numeric.parameter_values)
    state = simulator.start(values)
    assert not any("stop_rest" in mode for mode in simulator.tables.modes)
    state, _ = simulator.advance(values, state, 3.0 * 2.0**0.5 - 1e-3)
    assert not any("stop_rest" in mode for mode in simulator.tables.modes)
    state, _ = simulator.advance(values, state, 3.0 * 2.0**0.5 + 1e-3)
    assert list(simulator.tables.modes)[state.count[0]] == "slip_below_stop_rest"
    assert np.max(np.abs(state.y[:2])) < 1e-12


def count(step, counts):
    return {name: n for name, n in zip(step.meta["segments"], counts, strict=True) if n}


def names(results):
    return list(results.step("swept").meta["segments"])


def test_a_motion_goes_on_in_another_process(monkeypatch):
    """What it has reached goes along with it, in its own numbers."""
    build_as_reached(monkeypatch)
    numeric = numeric_from(MODEL)
    p = numeric.parameter_values
    simulator = Simulator(numeric, Direct())
    values = simulator.values(p)
    state, _ = simulator.advance(values, simulator.start(values), 40.0)
    row = pack_motion(simulator.tables, state)
    arrived = Simulator(pickle.loads(pickle.dumps(numeric)), Direct())
    fresh = Simulator(numeric_from(MODEL), Direct())
    ahead = Simulator(numeric, Direct())
    # Another motion has reached the modes in another order.
    there = ahead.values(p)
    ahead.advance(there, ahead.start(there, [-1.0, -1.0, 0.9, 0.0]), 11.0)
    end, _ = simulator.advance(values, state, 80.0)
    for other in (arrived, fresh, ahead):
        again, _ = other.advance(there, unpack_motion(other.reached, there, row), 80.0)
        assert np.array_equal(again.y, end.y)
        counted = dict(zip(other.tables.segments, again.segment_counts.tolist(), strict=True))
        for name, n in zip(simulator.tables.segments, end.segment_counts.tolist(), strict=True):
            assert counted[name] == n


@pytest.mark.parametrize("damage", [lambda r: r[:3], lambda r: -r, lambda r: np.full(9, 7.0), lambda r: r * np.inf])
def test_a_row_that_is_no_motion_is_refused(monkeypatch, damage):
    build_as_reached(monkeypatch)
    simulator = Simulator(numeric_from(MODEL), Direct())
    values = simulator.values(simulator.numeric.parameter_values)
    state, _ = simulator.advance(values, simulator.start(values), 20.0)
    with np.errstate(all="ignore"), pytest.raises(ValueError, match=r"not one of this model|too short"):
        unpack_motion(simulator.reached, values, damage(pack_motion(simulator.tables, state)))


def test_jumps_that_change_many_digits_ask_for_one_condition_each():
    """Eighteen walls, all hit at once: 2^18 sets of digits may follow, by eighteen comparisons."""
    n = 18
    equations = {f"x{k}'": f"-max(0, x{k} - {1 + 0.01 * k}) + cos(t + {k})" for k in range(n)}
    hit = {"every": "2*pi", "reset": {f"x{k}": f"-x{k} + {0.3 + 0.05 * k}" for k in range(n)}}
    numeric = numeric_from(
        {
            "name": "walls",
            "states": [f"x{k}" for k in range(n)],
            "forcing": {"period": "2*pi"},
            "equations": equations,
            "jumps": {"hit": hit},
            "initial": {f"x{k}": 2.0 - 0.1 * k for k in range(n)},
        }
    )
    simulator = Simulator(numeric, Direct())
    values = simulator.values(numeric.parameter_values)
    state = simulator.start(values)
    (ending,) = (e for e in simulator.tables.endings.values() if e.segment.event == "hit")
    assert ending.n_ways == 2**n
    assert len(ending.decisions) == n
    state, _ = simulator.advance(values, state, 20.0)
    mode = list(simulator.tables.modes)[state.count[0]]
    assert mode == "_".join(f"x{k}_{'above' if state.y[k] > 1 + 0.01 * k else 'below'}" for k in range(n))


def test_digits_that_hang_together_are_read_where_all_are_on_their_surfaces():
    """Seven blocks in a row stick to each other; all are kicked alike, and stick on, as their differences stay zero."""
    n = 7
    speeds = ["v0", *(f"v{k} - v{k - 1}" for k in range(1, n))]
    equations = {}
    for k in range(n):
        above = f" + 5*sign({speeds[k + 1]})" if k + 1 < n else ""
        equations |= {f"x{k}'": f"v{k}", f"v{k}'": f"0.1*cos(t) - 5*sign({speeds[k]}){above}"}
    numeric = numeric_from(
        {
            "name": "pile",
            "states": [name.removesuffix("'") for name in equations],
            "forcing": {"period": "2*pi"},
            "equations": equations,
            "switches": {f"s{k}": speed for k, speed in enumerate(speeds)},
            "jumps": {"halve": {"every": "2*pi", "reset": {f"v{k}": f"v{k}/2" for k in range(n)}}},
        }
    )
    simulator = Simulator(numeric, Direct())
    values = simulator.values(numeric.parameter_values)
    state, _ = simulator.advance(values, simulator.start(values), 7.0)
    mode = list(simulator.tables.modes)[state.count[0]]
    assert mode == "_".join(f"s{k}_on" for k in range(n))
    assert np.max(np.abs(state.y)) < 1e-15
