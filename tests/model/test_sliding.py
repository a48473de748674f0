"""Sliding: Filippov's field in numbers, when a motion leaves, two surfaces at once, and where nothing decides."""

import math
import random

import numpy as np
import pytest

from pddecont.errors import ModelError, PddecontError
from pddecont.model import find_start_mode
from pddecont.model.evaluation import evaluate
from tests.conftest import model_from
from tests.model.equations_models import STICK, TWO, field_at, numbers_at, one_law
from tests.runs import change


def plane(f_x, f_y, **more):
    """Return a model of two states with these equations."""
    given = {"name": "m", "states": ["x", "y"], "equations": {"x'": f_x, "y'": f_y}, "initial": {"x": 0.3, "y": 0.17}}
    return model_from({**given, **more})


def test_the_field_along_a_slanted_surface_is_filippovs_mean():
    """On 3 x - y + x y = 1 from both sides: f = (L+ f- - L- f+) / (L+ - L-)."""
    model, draw = plane("y - sign(3*x - y + x*y - 1)", "-x + 0.7*heaviside(3*x - y + x*y - 1)*x"), random.Random(5)
    on = next(mode for mode in model.modes if mode.endswith("_on"))
    for _ in range(30):
        x = draw.uniform(-0.6, 2.0)
        y = (3 * x - 1) / (1 - x) if abs(1 - x) > 0.1 else 0.5
        below, above = np.array([y + 1, -x]), np.array([y - 1, -x + 0.7 * x])
        normal = np.array([3 + y, -1 + x])
        rate_below, rate_above = normal @ below, normal @ above
        expected = (rate_above * below - rate_below * above) / (rate_above - rate_below)
        found = field_at(model, numbers_at(model, x=x, y=y), on)
        assert found == pytest.approx(expected, rel=1e-11, abs=1e-11)
        assert normal @ found == pytest.approx(0, abs=1e-10 * (1 + np.max(np.abs(expected))))


def test_along_a_surface_that_moves_the_motion_moves_with_it():
    """On x = 0.4 cos(3 t) the sliding velocity is that of the surface."""
    model = model_from(
        {
            "name": "m",
            "states": ["x", "y"],
            "forcing": {"period": "2*pi/3"},
            "equations": {"x'": "y - 5*sign(x - 0.4*cos(3*t))", "y'": "-y - x*sign(x - 0.4*cos(3*t))"},
            "initial": {"x": 1},
        }
    )
    for t in (0.1, 0.7, 1.9):
        x, y = 0.4 * math.cos(3 * t), 0.3
        speed = -1.2 * math.sin(3 * t)
        mean_sign = (y - speed) / 5
        found = field_at(model, numbers_at(model, t, x=x, y=y), "x_on")
        assert found == pytest.approx([speed, -y - x * mean_sign], abs=1e-13)


def test_a_motion_leaves_where_a_field_ceases_to_lead_back():
    model = model_from(STICK)
    for t, x in ((0.3, 0.4), (1.2, -0.9)):
        numbers = numbers_at(model, t, x=x, v=0.0)
        force = 1.5 * math.cos(t) - x
        up, down = (evaluate(model.events[f"slip_off_{way}"].function, numbers) for way in ("up", "down"))
        assert (up, down) == pytest.approx((force - 0.8, force + 0.8))
    ends = {s.event: (s.direction, s.to) for s in model.segments.values() if s.mode == "slip_on"}
    assert ends == {"slip_off_up": ("rising", "slip_above"), "slip_off_down": ("falling", "slip_below")}


def test_static_friction_holds_longer_by_its_grip():
    """Kinetic 0.4, static 0.6: what moves sees 0.4, what sticks leaves at 0.6."""
    model = model_from(change(STICK, "equations.v'", "F*cos(om*t) - x - coulomb(v, mu/2, 0.75*mu)"))
    numbers = numbers_at(model, 0.3, x=0.2, v=0.0)
    force = 1.5 * math.cos(0.3) - 0.2
    assert field_at(model, numbers, "slip_above")[1] == pytest.approx(force - 0.4)
    assert evaluate(model.events["slip_off_up"].function, numbers) == pytest.approx(force - 0.6)
    assert evaluate(model.events["slip_off_down"].function, numbers) == pytest.approx(force + 0.6)
    assert field_at(model, numbers, "slip_on")[1] == pytest.approx(0, abs=1e-15)


def two_fields(x, v, y, w, left, right):
    """Return the field of two masses with given signs of their speeds."""
    k, m, n, c = 0.6, 0.7, 0.4, 0.3
    return np.array(
        [
            v,
            -x + k * (y - x) + c * (w - v) - m * left + 0.2 * n * right,
            w,
            -y + k * (x - y) + c * (v - w) - n * right + 0.1 * m * left,
        ]
    )


def test_along_two_surfaces_at_once_one_linear_system_decides():
    model, draw = model_from(TWO), random.Random(6)
    for _ in range(10):
        x, y = draw.uniform(-1, 1), draw.uniform(-1, 1)
        numbers = numbers_at(model, x=x, v=0.0, y=y, w=0.0)
        assert field_at(model, numbers, "left_on_right_on") == pytest.approx([0, 0, 0, 0], abs=1e-14)
        # One of them leaves while the other goes on sticking: with its own sign +1 and the other's mean.
        other = two_fields(x, 0, y, 0, 1, 0)[3] / 0.4
        expected = two_fields(x, 0, y, 0, 1, other)[1]
        event = next(
            s.event for s in model.segments.values() if s.mode == "left_on_right_on" and s.to == "left_above_right_on"
        )
        assert evaluate(model.events[event].function, numbers) == pytest.approx(expected, abs=1e-13)


def test_while_one_sticks_the_other_moves_in_the_mean_of_its_law():
    model = model_from(TWO)
    x, y, w = 0.4, -0.3, 0.5
    stuck = 0.7**-1 * (-x + 0.6 * (y - x) + 0.3 * w + 0.2 * 0.4)
    expected = two_fields(x, 0, y, w, stuck, 1)
    found = field_at(model, numbers_at(model, x=x, v=0.0, y=y, w=w), "left_on_right_above")
    assert found == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize(
    "text",
    [
        "hysteresis(x, -1, 1)",
        "2*max(0, x)",
        "abs(x) + clip(y, -1, 1) + deadzone(x + y, 0.2)",
        "sign(x(t - 1))",
        "sign(y)*max(0, x)",
        "square(t, 2)*x",
        "sign(x - x(t - 1))",
    ],
)
def test_nothing_slides_along(text):
    """Continuous laws, relays with memory, delayed values and time alone; y' does not hold the sign of y."""
    assert not any("_on" in mode for mode in one_law(text).modes)


def test_surfaces_that_meet_nowhere_are_no_trouble():
    """Two belts with different speeds."""
    model = plane("y", "-x - 0.5*sign(y) - 0.3*sign(y - 0.3)")
    together = [("below", "below"), ("on", "below"), ("above", "below"), ("above", "on"), ("above", "above")]
    assert sorted(model.modes) == sorted(f"y_{a}_y2_{b}" for a, b in together)


@pytest.mark.parametrize(
    "law",
    [
        "-x - 0.5*sign(y)*max(0, x - 0.2) - 0.3*sign(y - 0.5) - 0.2*sign(x + 0.5*y)",
        "-x - 0.4*sign(y)*max(0, x + 0.4) - 0.05*sign(y + 0.3) - coulomb(y + 0.25, 0.3, 0.45)",
    ],
)
def test_surfaces_that_meet_in_a_point_or_nowhere_refuse_no_model(law):
    assert plane("y", law).derived is not None


def test_friction_without_a_normal_force_sticks_nowhere():
    model = plane("y", "-x - 0.5*sign(y)*max(0, x - 0.2)", switches={"wall": "x - 0.2"})
    assert [mode for mode in model.modes if "y_on" in mode] == ["wall_above_y_on"]


def test_laws_that_are_multiplied_are_refused():
    with pytest.raises(ModelError, match="'x' and 'y' at once: their laws are multiplied"):
        plane("-sign(x) - 0.5*sign(x)*sign(y)", "-sign(y) - 0.3*sign(x)*sign(y)")


@pytest.mark.parametrize(("x", "y"), [(0.0, 0.2), (0.0, -0.6)])
def test_a_start_where_both_fields_point_away_is_refused(x, y):
    model = plane("y + 2*sign(x)", "-y")
    with pytest.raises(PddecontError, match="both fields point away from it"):
        find_start_mode(model.derived, numbers_at(model, x=x, y=y))
