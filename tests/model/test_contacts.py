"""Jumps of equations at which motions rest: the modes made of them, their forces, and what is refused."""

import numpy as np
import pytest
import yaml

from pddecont.errors import ModelError
from pddecont.model import expand_model, leave_out_effects
from pddecont.model.conditions import holds
from tests.conftest import model_from
from tests.model.equations_models import field_at, numbers_at
from tests.runs import change

BALL = {
    "name": "ball",
    "states": ["y", "v"],
    "parameters": {"G": 1.3, "r": 0.5},
    "forcing": {"period": "2*pi"},
    "equations": {"y'": "v", "v'": "G*sin(t) - 1"},
    "jumps": {"stop": {"at": "y", "direction": "falling", "reset": {"v": "-r*v"}, "rest": True}},
    "effects": {"floor": {"drop": ["stop"]}, "table": {"set": {"G": 0}}},
    "initial": {"y": 1},
}
TWO = {
    "name": "two",
    "states": ["x", "v", "y", "w"],
    "parameters": {"r": 0.5, "m": 2.5, "k": 4},
    "forcing": {"period": "2*pi"},
    "equations": {"x'": "v", "v'": "-1 + where(sin(t) > 0.5, 1.8, 0)", "y'": "w", "w'": "-k*y - w"},
    "jumps": {
        "meet": {
            "at": "x - y",
            "direction": "falling",
            "reset": {"v": "(v + m*w - m*r*(v - w))/(1 + m)", "w": "(v + m*w + r*(v - w))/(1 + m)"},
            "rest": True,
        }
    },
    "initial": {"x": 1},
}


def test_a_ball_has_a_mode_in_which_it_lies():
    model = model_from(BALL)
    y, v = model.state_symbols
    assert list(model.modes) == ["smooth", "stop_rest"]
    assert model.modes["stop_rest"] == (v, 0)
    assert [(s.name, s.mode, s.to) for s in model.segments.values()] == [
        ("stop", "smooth", "smooth"),
        ("stop>stop_rest", "smooth", "stop_rest"),
        ("stop_off", "stop_rest", "smooth"),
    ]
    assert (model.segments["stop_off"].event, model.segments["stop_off"].direction) == ("stop_off", "rising")
    assert model.resets["stop>stop_rest"] == (y, 0)
    assert model.initial_mode == "smooth"


def test_what_is_pressed_upwards_leaves_downwards():
    """Under a ceiling: the force holds as long as the ball would rise."""
    model = model_from(change(change(BALL, "jumps.stop.direction", "rising"), "equations.v'", "G*sin(t) + 1"))
    assert model.segments["stop_off"].direction == "falling"
    assert str(model.events["stop_off"].function) == "G*sin(t) + 1"


def test_two_bodies_move_together_as_their_momentum_says():
    """Masses 1 and m: both accelerate by the mean of what each would do, weighted with the masses."""
    model = model_from(TWO)
    assert len(model.modes) == 4
    for name, force in (("t_below_meet_rest", -1.0), ("t_above_meet_rest", 0.8)):
        found = field_at(model, numbers_at(model, x=0.3, v=0.7, y=0.3, w=0.7), name)
        together = (force + 2.5 * (-4 * 0.3 - 0.7)) / 3.5
        assert found == pytest.approx([0.7, together, 0.7, together], rel=1e-14)


def test_a_force_that_jumps_may_lift_what_rests():
    model = model_from(TWO)
    ways = [s for s in model.segments.values() if s.written == "meet_rest_t_up"]
    assert [s.to for s in ways] == ["t_above", "t_above_meet_rest"]
    # It is lifted if the first body would rise from the second: 1.8 - 1 + k y + w > 0.
    lifted = [holds(ways[0].guard, numbers_at(model, x=y, v=w, y=y, w=w)) for y, w in ((0, -0.7), (0, -0.9), (-0.3, 0))]
    assert lifted == [True, False, False]


def test_a_model_written_by_hand_from_it_reads_back_as_the_same():
    for given in (BALL, TWO):
        model = model_from(given)
        again = model_from(yaml.safe_load(yaml.safe_dump(expand_model(model))))
        assert set(again.modes) == set(model.modes)
        assert {s.name: (s.mode, s.to, s.rests) for s in again.segments.values()} == {
            s.name: (s.mode, s.to, s.rests) for s in model.segments.values()
        }
        numbers = numbers_at(model, **dict(zip(model.states, np.linspace(0.2, 0.7, 4), strict=False)))
        for mode in model.modes:
            assert field_at(again, numbers, mode) == pytest.approx(field_at(model, numbers, mode), rel=1e-13)


def test_without_the_stop_there_is_no_rest_and_without_forcing_no_leaving():
    assert list(leave_out_effects(model_from(BALL), ["floor"]).modes) == ["smooth"]
    still = leave_out_effects(model_from(BALL), ["table"])
    assert list(still.modes) == ["smooth", "stop_rest"]
    assert str(still.events["stop_off"].function) == "-1"


def test_of_two_walls_the_one_does_not_concern_the_other():
    walls = change(
        change(BALL, "jumps.top", {"at": "y - 2", "direction": "rising", "reset": {"v": "-r*v"}, "rest": True}),
        "parameters.d",
        2,
    )
    walls = change(walls, "jumps.top.at", "y - d")
    model = model_from(walls)
    assert {s.event for s in model.segments.values() if s.mode == "stop_rest"} == {"stop_off"}
    # Nothing rests at both.
    assert list(model.modes) == ["smooth", "top_rest", "stop_rest"]


REFUSED = {
    "side": ("stop.direction", "any", "say 'direction: rising' or 'falling'"),
    "bat": ("stop.reset.v", "1 - r*v", r"this reset lets a motion go on that comes with rate zero \(v\)"),
    "carried": ("stop.reset.y", "y + 1", "this reset changes the function of 'at'"),
    "time": ("stop.at", "sin(t)", "a surface of states, and this function reads none"),
    "delayed": ("stop.at", "y - y(t - 1)", "neither this function nor its rate reads a delayed value"),
    "kicked": ("dose", {"every": "pi", "reset": {"v": "v + 1"}}, "jump 'dose' moves what rests here"),
}


@pytest.mark.parametrize("key", REFUSED)
def test_rest_that_nothing_decides_is_refused_where_it_is_written(key):
    where, value, message = REFUSED[key]
    with pytest.raises(ModelError, match=rf"m\.yaml:\d+:\d+: .*{message}"):
        model_from(change(BALL, f"jumps.{where}", value))


@pytest.mark.parametrize(
    ("law", "message"),
    [
        ("G*sin(t) - 1 - 0.1*sign(v)", "switch 'v' is zero where a motion rests"),
        ("G*sin(t) - 1 - 0.1*sign(v - cos(t))", "pushes it across switch"),
    ],
)
def test_friction_along_the_push_is_refused(law, message):
    with pytest.raises(ModelError, match=message):
        model_from(change(BALL, "equations.v'", law))


def test_a_function_whose_rate_jumps_is_refused():
    with pytest.raises(ModelError, match="the rate of this function jumps with a switch"):
        model_from(change(BALL, "equations.y'", "v + sign(sin(t))"))
