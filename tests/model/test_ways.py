"""What may follow an event: of the conditions just one holds, and it is that of the fields."""

import random

import pytest

from pddecont.model import find_start_mode, list_alternatives
from pddecont.model.conditions import holds
from pddecont.model.evaluation import evaluate
from tests.conftest import model_from
from tests.model.equations_models import STICK, TWO, numbers_at, one_law
from tests.runs import change

KICKED = {**TWO, "jumps": {"kick": {"at": "x - 0.5", "direction": "rising", "reset": {"v": "-v", "w": "w - v"}}}}
MODELS = {
    "stick": STICK,
    "static": change(STICK, "equations.v'", "F*cos(om*t) - x - coulomb(v, mu/2, 0.75*mu)"),
    "two": TWO,
    "kicked": KICKED,
    "nested": change(STICK, "equations.v'", "F*cos(om*t) - x - mu*sign(v)*max(0, abs(x) - 0.3) - 0.2*sign(v)"),
    "relay": {
        **change(STICK, "equations.v'", "F*cos(om*t) - x - hysteresis(x, -mu, mu) - 0.3*sign(v)"),
        "jumps": {"kick": {"at": "v - 1", "reset": {"x": "-x", "v": "v - 1.2"}}},
    },
}


@pytest.mark.parametrize("name", MODELS)
def test_of_what_may_follow_just_one_holds(name):
    """At random states, and at states on the surfaces, where guards are equal to zero."""
    model, draw = model_from(MODELS[name]), random.Random(8)
    first = {s.written or s.name: s for s in reversed(list(model.segments.values()))}
    asked = 0
    for segment in first.values():
        ways = list_alternatives(model, segment)
        if len(ways) < 2:
            continue
        for _ in range(12):
            values = {s: draw.choice((0.0, draw.uniform(-1.5, 1.5))) for s in model.states}
            numbers = numbers_at(model, draw.uniform(0, 6), **values)
            assert sum(holds(way.guard, numbers) for way in ways) == 1, segment.name
            asked += 1
    assert asked >= 24


@pytest.mark.parametrize("name", ["stick", "static"])
def test_what_follows_a_speed_of_zero_is_what_the_forces_say(name):
    model, draw = model_from(MODELS[name]), random.Random(9)
    least = 0.8 if name == "stick" else 0.6
    for segment in model.segments.values():
        if segment.written != "slip_up":
            continue
        for _ in range(30):
            x, t = draw.uniform(-2, 2), draw.uniform(0, 6)
            numbers = numbers_at(model, t, x=x, v=0.0)
            force = evaluate(model.modes["slip_above"][1], numbers) + (0.8 if name == "stick" else 0.4)
            expected = "slip_above" if force > least else "slip_on"
            assert holds(segment.guard, numbers) == (segment.to == expected)


def test_after_a_jump_digits_are_those_of_the_states_it_leaves():
    """A kick leaves the speeds (-v, w - v): the mode after it is the one read from these."""
    model, draw = model_from(KICKED), random.Random(10)
    for _ in range(40):
        x, v, y, w = (draw.uniform(-1, 1) for _ in range(4))
        mode = find_start_mode(model.derived, numbers_at(model, x=x, v=v, y=y, w=w))
        after = numbers_at(model, x=x, v=-v, y=y, w=w - v)
        ways = [s for s in model.segments.values() if s.mode == mode and "kick" in s.event]
        (taken,) = [s.to for s in ways if holds(s.guard, after)]
        assert taken == find_start_mode(model.derived, after)


def test_a_kick_from_sliding_onto_the_surface_again_is_judged_by_the_forces():
    """A jump of x does not move v: a motion that sticks goes on sticking where the new force is small enough."""
    model = model_from({**STICK, "jumps": {"push": {"at": "x - 0.1", "reset": {"x": "x + 0.9"}}}})
    ways = [s for s in model.segments.values() if s.mode == "slip_on" and s.event == "push"]
    assert {s.to for s in ways} == {"slip_on", "slip_above", "slip_below"}
    for t, x in ((0.0, 1.0), (0.0, -0.4), (3.1, 1.0), (3.1, -1.0)):
        numbers = numbers_at(model, t, x=x, v=0.0)
        (taken,) = [s.to for s in ways if holds(s.guard, numbers)]
        assert taken == find_start_mode(model.derived, numbers)


def test_a_relay_after_a_jump_keeps_its_digit_between_the_thresholds():
    model = one_law("-hysteresis(x, -1, 1)", jumps={"kick": {"at": "y", "reset": {"x": "x + y"}}})
    for before, x, after in (
        ("x_below", 0.5, "x_below"),
        ("x_below", 1.5, "x_above"),
        ("x_above", 0.5, "x_above"),
        ("x_above", -1.5, "x_below"),
    ):
        numbers = numbers_at(model, x=x, y=0.0, x_1=0.0)
        (taken,) = [
            s.to for s in model.segments.values() if s.mode == before and s.event == "kick" and holds(s.guard, numbers)
        ]
        assert taken == after
