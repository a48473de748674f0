"""A full model without all its effects but the forcing is the linear oscillator that one writes by hand: in code,
unknowns and results.
"""

import json

import numpy as np
import pytest

from pddecont.codegen import NumericModel, machine_code
from pddecont.delay import Chain, Direct
from pddecont.model import TIME, leave_out_effects, load_model, parse_document
from pddecont.native.integrator import USED
from pddecont.results import read_results
from pddecont.runfile import Overrides
from pddecont.simulate import Simulator
from pddecont.steps import load_run_plan
from pddecont.steps.execution import execute
from tests.cli.test_cli import call
from tests.conftest import ROOT, shipped
from tests.runs import run

OFF = ("damping", "friction", "impact", "cutting", "feedback")
WHOLE = load_model(str(ROOT / "models" / "full_oscillator.yaml"))[0]
LEAN = leave_out_effects(WHOLE, OFF)
HAND = load_model(str(ROOT / "models" / "linear_oscillator.yaml"))[0]


def test_what_is_left_is_what_one_writes_by_hand():
    for part in (
        "states",
        "modes",
        "events",
        "resets",
        "segments",
        "delays",
        "delayed",
        "period",
        "history",
        "initial_mode",
    ):
        assert getattr(LEAN, part) == getattr(HAND, part), part
    used = {s for body in LEAN.modes.values() for e in body for s in e.free_symbols} - {*LEAN.state_symbols, TIME}
    assert {s.name for s in used} == set(HAND.parameters)


def generated(model, monkeypatch):
    """Return the text of every function that is generated for a model: over arrays with all derivatives, and for the
    integrator.
    """
    numeric, texts = NumericModel(model), []
    free = tuple(range(len(HAND.parameters)))
    made = [
        *(numeric.mode(m) for m in model.modes),
        *(numeric.event(e) for e in model.events),
        *(numeric.reset(r) for r in model.resets),
        numeric.delays.function,
        numeric.period.function,
    ]
    arrays = [f._source(key) for f in made for key in (None, free)]
    nothing = type("Nothing", (), {"address": 0})
    monkeypatch.setattr(machine_code, "load_machine_code", lambda text: texts.append(text) or nothing)
    _ = Simulator(NumericModel(model), Direct(), tangent=True).system
    return arrays, texts


def test_generated_code_is_the_same_text(monkeypatch):
    lean, hand = generated(LEAN, monkeypatch), generated(HAND, monkeypatch)
    assert lean == hand
    # The field, its Jacobian, the history: nothing else happens.
    assert len(hand[1]) == 3
    assert generated(WHOLE, monkeypatch) != hand


def test_the_integrator_gets_the_same_numbers():
    one, other = (Simulator(NumericModel(m), Direct()) for m in (LEAN, HAND))
    for name, value in one.system._asdict().items():
        assert np.array_equal(value, getattr(other.system, name)), name
    sizes = [[np.shape(a) for a in s.start(s.values(s.numeric.parameter_values))] for s in (one, other)]
    assert sizes[0] == sizes[1]


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    """The run of each model's own file, the full one's without its effects."""
    folder = tmp_path_factory.mktemp("full")
    for name, off in (("full_oscillator", OFF), ("linear_oscillator", ())):
        path = ROOT / "models" / f"{name}.yaml"
        plan = load_run_plan(parse_document(path.read_text(), str(path)), Overrides(without=off))
        execute(plan, folder / f"{name}.h5")
    return read_results(folder / "full_oscillator.h5"), read_results(folder / "linear_oscillator.h5")


def test_unknowns_meshes_and_results_are_the_same(both):
    lean, hand = both
    for name in ("orbit", "branch"):
        a, b = lean.step(name), hand.step(name)
        assert len(a) == len(b)
        for column in set(a.points) - {"parameters"}:
            assert np.array_equal(a.points[column], b.points[column], equal_nan=a.points[column].dtype.kind == "f"), (
                column
            )
        for column in a.orbits:
            assert np.array_equal(a.orbits[column], b.orbits[column]), column
    a, b = lean.step("transient"), hand.step("transient")
    assert np.array_equal(a.orbits["time"], b.orbits["time"])
    assert np.array_equal(a.orbits["states"], b.orbits["states"])


def test_the_amplitude_is_the_closed_forms(both):
    # x'' + x = a omega^2 sin(omega t)
    step = both[0].step("branch")
    omega, a = (step.points["parameters"][:, step.meta["parameters"].index(name)] for name in ("omega", "a"))
    assert len(omega) > 5
    assert step.points["monitors"][:, 0] == pytest.approx(a * omega**2 / (1 - omega**2), rel=1e-9)
    assert np.all(step.points["period"] == pytest.approx(2 * np.pi / omega, rel=1e-12))


def test_tables_hold_the_values_that_effects_set(both):
    step = both[0].step("branch")
    at = dict(zip(step.meta["parameters"], step.points["parameters"].T, strict=True))
    for name in ("zeta", "F", "k_c", "K"):
        assert np.all(at[name] == 0.0)
    assert np.all(at["beta"] == WHOLE.parameters["beta"])


def test_info_of_the_results_lists_what_was_left_out_and_why(both):
    data = json.loads(call("info", both[0].path, "--json")[1])["left out"]
    assert data["effects"] == list(OFF)
    assert data["states"] == {"w": "nothing left reads it without effect 'feedback'"}
    assert set(data["modes"]) == {"free_down", "hit_up", "hit_down"}
    assert data["delays"] == {
        "tau_c": "nothing left is delayed by it without effect 'cutting'",
        "tau_d": "nothing left is delayed by it without effect 'feedback'",
    }
    assert "impact: it never happens without effect 'impact'" in call("info", both[0].path)[1]
    assert json.loads(call("info", both[1].path, "--json")[1])["left out"] == {}


@pytest.mark.parametrize(
    ("model", "delay", "kept"),
    [
        ("full_oscillator", Direct(), ["x", "w"]),
        ("impact_oscillator", Direct(), ["v"]),
        ("linear_oscillator", Direct(), []),
        ("impact_oscillator", Chain(2, 5), []),
    ],
)
def test_histories_and_chains_are_of_delayed_quantities_only(model, delay, kept):
    numeric = shipped(model)
    simulator = Simulator(numeric, delay)
    values = simulator.values(numeric.parameter_values)
    state, _ = simulator.advance(values, simulator.start(values), 30.0)
    if isinstance(delay, Chain):
        assert simulator.system.n_full == numeric.n_states + len(numeric.model.delayed) * delay.order * delay.n
        assert len(numeric.model.delayed) == 1
    else:
        assert [numeric.model.states[i] for i in simulator.system.kept] == kept
        assert state.past_coefficients.shape[2] == len(kept)
    assert (state.count[USED] > 0) == bool(kept)
    # Nothing reads the inside of a step where there are no delays, no events and no log.
    assert np.any(simulator.work.extension) == (model != "linear_oscillator")


EVENTS = {
    "name": "m",
    "states": ["x", "v"],
    "parameters": {"c": 0.1},
    "forcing": {"period": "2*pi"},
    "modes": {"low": {"x'": "v", "v'": "cos(t) - c*v - x"}, "high": {"x'": "v", "v'": "cos(t) - c*v - x"}},
    "events": {"up": "x - 0.5", "down": "log(x + 9) - log(9.3)"},
    "segments": {
        "rise": {"mode": "low", "event": "up", "direction": "rising", "to": "high"},
        "fall": {"mode": "high", "event": "down", "direction": "falling", "to": "low"},
    },
    "run": {
        "monitors": {"top": "max(x)"},
        "steps": [
            {"name": "transient", "simulate": {"t_end": "80*pi"}},
            {"name": "orbit", "orbit": {"from": "transient"}},
        ],
    },
}


def test_an_event_is_watched_only_where_it_can_end_a_segment(tmp_path):
    # In mode low x falls to -10, where log(x + 9) has no value: looking at it would warn and spoil the extrema.
    orbit = run(EVENTS, tmp_path / "m.h5").step("orbit")
    assert orbit.points["admissible"][0] == 1
    # The vector field is one, so the orbit is the linear oscillator's: x = sin(t)/c.
    assert orbit.points["monitors"][0, 0] == pytest.approx(10.0, rel=1e-7)
