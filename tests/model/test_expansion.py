"""A model of equations written by hand is the same model: fields, events, guards, resets, and its motions."""

import random

import numpy as np
import pytest

from pddecont.cli import main
from pddecont.model import expand_model, list_alternatives
from pddecont.model.conditions import holds
from pddecont.model.evaluation import evaluate
from tests.conftest import model_from, numeric_from
from tests.model.equations_models import STICK, TWO, numbers_at
from tests.runs import change, to_yaml
from tests.simulate.motions import trajectory_of

ECHO = {
    "name": "echo",
    "states": ["x", "v"],
    "parameters": {"om": 1.3, "F": 1.2, "K": 0.3, "tau": 0.7, "r": 0.8, "d": 0.9, "J": 0.2},
    "forcing": {"period": "2*pi/om"},
    "switches": {"wall": "x - d/2"},
    "equations": {
        "x'": "v",
        "v'": "F*cos(om*t) - x - 0.2*v + K*x(t - tau) - max(x - d/2, 0) - 0.2*sign(x(t - tau))"
        " - 0.1*square(t, 2*pi/om)",
    },
    "jumps": {
        "stop": {"at": "x - d", "direction": "rising", "reset": {"v": "-r*v"}},
        "kick": {"after": "stop", "delay": "tau/2", "reset": {"v": "v - J"}},
        "dose": {"every": "2*pi/om", "reset": {"x": "x - 0.1"}, "in": {"wall": "-"}},
    },
    "initial": {"x": "0.2 + 0.1*cos(om*t)", "v": 0.3},
}
MODELS = {
    "stick": STICK,
    "static": change(STICK, "equations.v'", "F*cos(om*t) - x - coulomb(v, mu/2, 0.75*mu)"),
    "two": TWO,
    "echo": ECHO,
    "relay": change(STICK, "equations.v'", "F*cos(om*t) - x - hysteresis(x, -mu, mu) - 0.3*v + mod(t, 2*pi/om)/9"),
    "nested": change(STICK, "equations.v'", "F*cos(om*t) - x - 0.3*v - max(abs(x) - mu, 0)"),
}


def both(name):
    """Return a model and the one read from its expansion."""
    model = model_from(MODELS[name])
    return model, model_from(expand_model(model))


@pytest.mark.parametrize("name", MODELS)
def test_it_has_the_same_parts(name):
    model, by_hand = both(name)
    assert by_hand.derived is None
    for part in ("states", "parameters", "initial_mode", "delays", "delayed"):
        assert getattr(model, part) == getattr(by_hand, part)
    for part in ("modes", "events", "segments"):
        assert list(getattr(model, part)) == list(getattr(by_hand, part))
    # Those that put orbits on their surface are no part of a file.
    assert {k for k in model.resets if not k.startswith("onto_")} == set(by_hand.resets)
    for k, segment in model.segments.items():
        other = by_hand.segments[k]
        assert (segment.mode, segment.event, segment.direction, segment.to) == (
            *(other.mode, other.event, other.direction, other.to),
        )


@pytest.mark.parametrize("name", MODELS)
def test_it_says_the_same_numbers(name):
    """At random points; terms may be added in another order."""
    model, by_hand = both(name)
    draw = random.Random(14)
    for _ in range(10):
        values = {s: draw.uniform(-1.5, 1.5) for s in (*model.states, "x_1")}
        numbers = numbers_at(model, draw.uniform(0, 6), **values)
        for k, body in model.modes.items():
            found = [evaluate(f, numbers) for f in by_hand.modes[k]]
            assert found == pytest.approx([evaluate(f, numbers) for f in body], abs=1e-13)
        for k, body in by_hand.resets.items():
            assert [evaluate(g, numbers) for g in model.resets[k]] == [evaluate(g, numbers) for g in body]
        for k, event in model.events.items():
            other = by_hand.events[k]
            if event.function is None:
                assert (event.after, event.delay) == (other.after, other.delay)
            else:
                expected = evaluate(event.function, numbers)
                assert evaluate(other.function, numbers) == pytest.approx(expected, abs=1e-13)
        for k, segment in model.segments.items():
            assert holds(segment.guard, numbers) == holds(by_hand.segments[k].guard, numbers)


@pytest.mark.parametrize("name", MODELS)
def test_just_one_alternative_holds_in_it(name):
    _, by_hand = both(name)
    draw = random.Random(15)
    for segment in by_hand.segments.values():
        numbers = numbers_at(by_hand, 0.4, **{s: draw.uniform(-1.5, 1.5) for s in (*by_hand.states, "x_1")})
        assert sum(holds(way.guard, numbers) for way in list_alternatives(by_hand, segment)) == 1


@pytest.mark.parametrize("name", ["stick", "echo", "relay"])
def test_its_motions_are_the_same(name):
    """What differs is rounding, and what the choice of steps makes of it: well below the tolerance of 1e-12 a step."""
    model = MODELS[name]
    own, by_hand = (trajectory_of(numeric_from(m), 20.0) for m in (model, expand_model(model_from(model))))
    assert own.events.segment == by_hand.events.segment
    assert len(own.events) > 5
    assert own.events.t == pytest.approx(by_hand.events.t, abs=1e-10)
    times = np.linspace(0, 20, 101)
    apart = times[np.min(np.abs(times[:, None] - own.events.t), axis=1) > 1e-6]
    assert np.max(np.abs(own(apart) - by_hand(apart))) < 1e-10


def test_the_command_writes_what_reads_back(tmp_path, capsys):
    path = tmp_path / "m.yaml"
    path.write_text(to_yaml(ECHO))
    with pytest.raises(SystemExit) as ended:
        main(["info", str(path), "--expand"])
    assert ended.value.code == 0
    model, by_hand = model_from(ECHO), model_from(capsys.readouterr().out)
    assert list(by_hand.modes) == list(model.modes)
    assert list(by_hand.segments) == list(model.segments)


def test_an_alternative_that_nothing_takes_is_left_out():
    law = "0.3 - 0.553*x + where(x - 0.2 > 0 or x > 0, -0.694, 0.509) - 1.18*max(0, x + 0.3)"
    law += " + 0.0723*heaviside(x - 0.2)*(1 - 0.3*x)"
    model = model_from({"name": "m", "states": ["x"], "equations": {"x'": law}, "initial": {"x": -0.435}})
    assert set(model_from(expand_model(model)).modes) == set(model.modes)


def test_definitions_are_put_in():
    model = model_from(
        {**STICK, "definitions": {"force": "mu*sign(v)"}, "equations": {"x'": "v", "v'": "F*cos(om*t) - x - force"}}
    )
    by_hand = model_from(expand_model(model))
    assert by_hand.definitions == {}
    assert by_hand.modes == model_from(change(STICK, "equations.v'", "F*cos(om*t) - x - mu*sign(v)")).modes
