"""Modes made of equations: their names, the segments between them, and digits read from names again."""

from itertools import product

import pytest

from pddecont.model import ABOVE, BELOW, ON
from pddecont.model.conditions import holds
from tests.conftest import model_from
from tests.model.equations_models import STICK, TWO, numbers_at, one_law
from tests.runs import change


def test_a_model_without_nonsmooth_functions_has_one_mode_and_no_segments():
    model = one_law("-x + y**2")
    assert (list(model.modes), model.events, model.segments, model.smooth) == (["smooth"], {}, {}, True)
    assert model.derived.equations.find_digits("smooth") == ()
    assert model.derived.equations.find_digits("other") is None


def test_one_surface_along_which_motions_slide():
    model = model_from(STICK)
    assert list(model.modes) == ["slip_below", "slip_above", "slip_on"]
    assert {s.name: (s.mode, s.event, s.direction, s.to) for s in model.segments.values()} == {
        "slip_up>slip_above": ("slip_below", "slip", "rising", "slip_above"),
        "slip_up>slip_on": ("slip_below", "slip", "rising", "slip_on"),
        "slip_down>slip_below": ("slip_above", "slip", "falling", "slip_below"),
        "slip_down>slip_on": ("slip_above", "slip", "falling", "slip_on"),
        "slip_off_up": ("slip_on", "slip_off_up", "rising", "slip_above"),
        "slip_off_down": ("slip_on", "slip_off_down", "falling", "slip_below"),
    }
    assert model.initial_mode == "slip_above"


def test_one_corner_has_two_modes_and_no_guards():
    model = one_law("max(0, x - a)", switches={"wall": "x - a"})
    assert {s.name: (s.mode, s.to) for s in model.segments.values()} == {
        "wall_up": ("wall_below", "wall_above"),
        "wall_down": ("wall_above", "wall_below"),
    }


@pytest.mark.parametrize(
    "switches",
    [{"left": "v", "right": "w"}, {"a": "v", "a_on": "w"}, {"a_on": "v", "a": "w"}, {"a_on_b": "v", "a": "w"}],
)
def test_digits_are_read_from_names_again(switches):
    """Names of switches may end like words for digits."""
    equations = model_from({**TWO, "switches": switches}).derived.equations
    names = set()
    for digits in product((BELOW, ABOVE, ON), repeat=2):
        name = equations.name_mode(digits)
        names.add(name)
        assert equations.find_digits(name) == digits
    assert len(names) == 9


def test_what_is_no_mode_has_no_digits():
    equations = model_from(TWO).derived.equations
    for name in ("", "left", "left_on", "left_on_right", "left_on_right_off", "right_on_left_on"):
        assert equations.find_digits(name) is None


def test_each_mode_is_left_by_every_switch_of_its_own():
    model = model_from(TWO)
    assert len(model.modes) == 9
    for mode in model.modes:
        digits = model.derived.equations.find_digits(mode)
        ends = {(s.event, s.direction) for s in model.segments.values() if s.mode == mode}
        assert len(ends) == sum(2 if d == ON else 1 for d in digits)
        for segment in (s for s in model.segments.values() if s.mode == mode):
            after = model.derived.equations.find_digits(segment.to)
            assert after is not None
            assert after != digits


def test_a_name_with_an_underscore_more_is_no_mode():
    assert model_from(TWO).derived.equations.find_digits("left_on_right_on_") is None


def test_where_a_nested_argument_jumps_the_digit_is_read_anew():
    """The inner sign carries sign(x)*y over zero where x passes zero; x' is positive in every mode."""
    model = one_law("2 + max(0, sign(x)*y)", switches={"inner": "x", "outer": "sign(x)*y"})
    for before in ("above", "below"):
        ways = [s for s in model.segments.values() if s.mode == f"inner_below_outer_{before}" and s.event == "inner"]
        for y in (-0.7, 0.7):
            numbers = numbers_at(model, x=0.0, y=y, x_1=0.0)
            (taken,) = [s.to for s in ways if holds(s.guard, numbers)]
            assert taken == f"inner_above_outer_{'above' if y > 0 else 'below'}"


def test_events_that_are_the_same_in_several_modes_are_one():
    model = one_law("2*max(y, 0) + max(x, 0) - max(0, abs(x) - a)", switches={"outer": "abs(x) - a"})
    assert set(model.events) == {"x", "y", "outer_x_below", "outer_x_above"}


@pytest.mark.parametrize(
    ("only", "modes"),
    [
        ({"slip": "+"}, {"slip_above"}),
        ({"slip": "-"}, {"slip_below"}),
        ({"slip": "0"}, {"slip_on"}),
        ({}, {"slip_below", "slip_above", "slip_on"}),
    ],
)
def test_a_jump_happens_with_the_signs_it_asks_for(only, modes):
    model = model_from({**STICK, "jumps": {"kick": {"at": "x - 1.2", "reset": {"x": "x - 0.1"}, "in": only}}})
    assert {s.mode for s in model.segments.values() if s.event.startswith("kick")} == modes


@pytest.mark.parametrize(
    ("when", "modes"),
    [
        ("v > 0", {"slip_above"}),
        ("v < 0", {"slip_below"}),
        ("not v < 0", {"slip_above"}),
        ("v > 0 or v < 0", {"slip_below", "slip_above"}),
    ],
)
def test_a_jump_happens_under_a_condition(when, modes):
    """A motion that sticks is on neither side."""
    model = model_from({**STICK, "jumps": {"kick": {"at": "x - 1.2", "reset": {"x": "x - 0.1"}, "when": when}}})
    assert {s.mode for s in model.segments.values() if s.event.startswith("kick")} == modes


def test_a_jump_that_moves_a_state_of_no_switch_leaves_the_digits():
    model = model_from(change({**STICK, "jumps": {}}, "jumps.kick", {"at": "v - 0.5", "reset": {"x": "x - 0.1"}}))
    moving = [s for s in model.segments.values() if s.event == "kick" and s.mode != "slip_on"]
    assert {(s.mode, s.to) for s in moving} == {("slip_below", "slip_below"), ("slip_above", "slip_above")}


@pytest.mark.parametrize(
    "more",
    [
        {"jumps": {"k": {"at": "abs(x) - 1", "reset": {"y": 0}}, "j": {"after": "k", "delay": 1, "reset": {"y": 1}}}},
        {"switches": {"k": "abs(x) - a"}, "jumps": {"j": {"after": "k", "delay": 1, "reset": {"y": 1}}}},
    ],
)
def test_what_a_delayed_jump_comes_after_is_an_event(more):
    model = one_law("-x + max(0, abs(x) - a)", **more)
    assert any(event.starts(model.events["j"]) for event in model.events.values())
    assert not model.events["j"].starts(model.events["j"])
