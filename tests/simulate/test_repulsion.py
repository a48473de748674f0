"""Surfaces that repel: what nothing decides is an error that names the surface, the point and the fields."""

import re

import numpy as np
import pytest

from pddecont.delay import Direct
from pddecont.errors import ConvergenceError
from pddecont.model import derived_modes
from pddecont.simulate import simulate
from tests.conftest import numeric_from
from tests.runs import to_yaml
from tests.simulate.motions import STIFF, TIGHT, trajectory_of, with_parameters

FORCED = {"forcing": {"period": 4}}
# x falls to -3 and is put on the surface x = 1, or where the second jump says.
FALLS = {"at": "x + 3", "direction": "falling", "reset": {"x": 1}}
RATE = {"x'": "1 + 2*sign(x - 1)"}


def model(equations, initial, **more):
    """Return a model of equations as text."""
    states = [key[:-1] for key in equations]
    return to_yaml({"name": "m", "states": states, "equations": equations, "initial": initial, **more})


# Each with when and where nothing decides, and the rates below and above.
REPELLED = {
    # A jump puts x on the surface: it falls from 0 to -3 with rate -1.
    "jump": (model(RATE, {"x": 0}, jumps={"j": FALLS}), "t = 3", "x - 1", "x = 1", "-1 below and 3 above"),
    # Another switch turns round the law that held x: y rises through 1 at t = 1.
    "other switch": (
        model({"x'": "0.2 - sign(x)*sign(1 - y)", "y'": 1}, {"x": 0.5}),
        "t = 1",
        "x",
        "x = 0, y = 1",
        "-0.8 below and 1.2 above",
    ),
    # A relay with memory does: it rises through 1 at t = 1.5.
    "relay": (
        model({"x'": "hysteresis(z, -1, 1)*sign(x)", "z'": 1}, {"x": 0.1, "z": -0.5}),
        "t = 1.5",
        "x",
        "x = 0, z = 1",
        "-1 below and 1 above",
    ),
    # The edge of a wave does.
    "wave": (
        model({"x'": "-sign(x)*square(t, 4)"}, {"x": 0.5}, **FORCED),
        "t = 2",
        "x",
        "x = 0",
        "-1 below and 1 above",
    ),
    # The tick of a clock does: it comes at t = 3.5, and the ramp falls from -2.5 to 1.5.
    "clock": (
        model({"x'": "sign(x)*(1.5 - mod(t + 0.5, 4))"}, {"x": -2}, **FORCED),
        "t = 3.5",
        "x",
        "x = 0, clock = 0",
        "-1.5 below and 1.5 above",
    ),
    # What holds x changes its sign smoothly: both fields begin to point away at once.
    "both": (model({"x'": "-cos(pi*t/2)*sign(x)"}, {"x": 0.1}, **FORCED), "t = 1", "x", "x = 0", "0 below and 0 above"),
    # The past does: x(t - 1) falls through 0.2 at t = 1.3.
    "past": (
        model({"x'": "-sign(x)*sign(x(t - tau) - 0.2)"}, {"x": 0.5}, parameters={"tau": 1}),
        "t = 1.3",
        "x",
        "x = 0",
        "-1 below and 1 above",
    ),
}


@pytest.mark.parametrize("few", [0, derived_modes.FEW_MODES], ids=["reached", "all"])
@pytest.mark.parametrize("method", [TIGHT, STIFF], ids=["explicit", "stiff"])
@pytest.mark.parametrize("name", REPELLED)
def test_it_says_when_and_where_and_how_fast(monkeypatch, name, method, few):
    """Modes that are built as motions reach them have the same conditions."""
    monkeypatch.setattr(derived_modes, "FEW_MODES", few)
    text, when, surface, where, rates = REPELLED[name]
    with pytest.raises(ConvergenceError) as caught:
        trajectory_of(text, 9.0, method)
    # What is zero may be rounding.
    said = re.sub(r"-?\d\.?\d*e-\d\d", "0", str(caught.value))
    assert f"at {when} the motion is on the surface {surface} = 0 of switch 'x' at {where}, " in said
    assert f"away from it (its rate is {rates}): nothing decides on which side it goes on" in said


def test_a_field_along_the_surface_does_not_repel():
    """Below, x stands still: from the surface it goes on above."""
    t = trajectory_of(model({"x'": "-heaviside(2 - y) + 2*heaviside(x)*heaviside(y - 2)", "y'": 1}, {"x": 9}), 3.0)
    assert t(3.0) == pytest.approx([9 - 2 + 2, 3], abs=1e-12)


def test_a_surface_that_repels_is_crossed_by_what_jumps_over_it():
    """From x = 0 down to -3 at t = 3, then from 2 upwards with rate 3."""
    text = model(RATE, {"x": 0}, jumps={"j": {**FALLS, "reset": {"x": 2}}})
    assert trajectory_of(text, 5.0)(5.0) == pytest.approx([8], abs=1e-12)


def test_another_jump_of_the_same_moment_may_move_it_off():
    text = model(RATE, {"x": 0}, jumps={"j": FALLS, "k": {"after": "j", "delay": 0, "reset": {"x": 2}}})
    assert trajectory_of(text, 5.0)(5.0) == pytest.approx([8], abs=1e-12)


def test_the_mode_that_is_given_decides_at_a_start():
    text, end = model(RATE, {"x": 0.9}), 2.0
    with pytest.raises(ConvergenceError, match="at t = 0 the motion is on the surface x - 1 = 0 of switch 'x'"):
        trajectory_of(text, end, initial=[1.0])
    assert trajectory_of(text, end, initial=[1.0], mode="x_above")(end) == pytest.approx([7], abs=1e-12)
    assert trajectory_of(text, end, initial=[1.0], mode="x_below")(end) == pytest.approx([-1], abs=1e-12)


def test_two_surfaces_of_which_one_begins_to_repel():
    """x and y slide; z turns round what holds y."""
    text = model(
        {"x'": "0.3 - sign(x)", "y'": "0.1 - sign(y)*sign(3 - z)", "z'": 1}, {"x": 0.2, "y": -0.4}, switches={"Y": "y"}
    )
    with pytest.raises(ConvergenceError, match=r"at t = 3 the motion is on the surface y = 0 of switch 'Y' at x = 0, "):
        trajectory_of(text, 9.0)


def test_what_is_torn_off_may_tear_off_another():
    """Until t = 2 both blocks stick: the upper one with 3, its static friction, holds the lower one against 4.

    Torn off it holds with 1, and friction with the ground, 2.5, is not enough.
    """
    upper, ground = "coulomb(w - v, 1, 3)", "2.5*sign(v)"
    text = model({"v'": f"{upper} - {ground} - 4", "w'": f"0.5*z - {upper}", "z'": 1}, {"z": 4})
    t = trajectory_of(text, 4.0)
    assert t.events.t == pytest.approx([2.0], abs=1e-12)
    # v' = 1 + 2.5 - 4 and w' = z/2 - 1 from then on.
    assert t(4.0) == pytest.approx([-1.0, 5.0, 8.0], abs=1e-11)


CHANGED = {
    # What held it does no more: x' = 2 - 1.
    "law": ({"g": 2.0}, [5.0]),
    # The surface is elsewhere: x' = 1.5 up to 3, where it is held.
    "surface": ({"V": 3.0}, [3.0]),
    "beyond": ({"V": 30.0}, [7.5]),
    # It is held all the same.
    "held": ({"g": 0.8}, [0.0]),
}


@pytest.mark.parametrize("name", CHANGED)
def test_other_parameters_from_some_time_on_may_let_a_motion_go(name):
    given, end = CHANGED[name]
    numeric = numeric_from(model({"x'": "g - sign(x - V)"}, {"x": 1}, parameters={"g": 0.5, "V": 0}))
    p = numeric.parameter_values
    t = simulate(numeric, p, Direct(), 10.0, TIGHT, schedule=[(5.0, with_parameters(numeric, **given))])
    assert t(np.array([4.9, 10.0])).ravel() == pytest.approx([0.0, *end], abs=1e-11)


def test_a_relay_remembers_where_parameters_change():
    """z rises from 0 with rate 1, is between the thresholds at t = 2, and has been beyond the upper one at 1."""
    text = model(
        {"z'": "1 - 2*s", "s'": "a*heaviside(z - 9)", "y'": "hysteresis(z, -1, 1)"},
        {"z": 0},
        parameters={"a": 0},
        jumps={"turn": {"at": "z - 1.2", "direction": "rising", "reset": {"s": 1}}},
    )
    numeric = numeric_from(text)
    end = simulate(numeric, np.array([0.0]), Direct(), 2.5, TIGHT, schedule=[(2.0, np.array([1.0]))])(2.5)
    assert end == pytest.approx([1.2 - 1.3, 1, -1 + 1.5], abs=1e-11)


def test_other_parameters_may_turn_round_what_held_it():
    numeric = numeric_from(model({"x'": "0.2 - a*sign(x)"}, {"x": 1}, parameters={"a": 1}))
    with pytest.raises(
        ConvergenceError, match=r"at t = 5 the motion is on .* \(its rate is -0.8 below and 1.2 above\)"
    ):
        simulate(numeric, np.array([1.0]), Direct(), 9.0, TIGHT, schedule=[(5.0, np.array([-1.0]))])
