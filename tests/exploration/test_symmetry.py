"""Symmetries of models whose symmetries are known."""

import numpy as np
import pytest

from pddecont.exploration import find_symmetries
from tests.conftest import numeric_from, shipped


def describe_all(numeric):
    n = numeric.n_states
    p = numeric.parameter_values
    found = find_symmetries(numeric, np.array([p]), np.full(n, -1.5), np.full(n, 2.0))
    assert found[0].is_identity
    return [one.describe(numeric.model.states) for one in found[1:]]


def smooth(equations, parameters=None, **more):
    states = [name.rstrip("'") for name in equations]
    return numeric_from(
        {"name": "o", "states": states, "parameters": parameters or {}, "modes": {"free": equations}, **more}
    )


def test_the_lorenz_equations_turn_about_an_axis():
    equations = {"x'": "10*(y - x)", "y'": "x*(28 - z) - y", "z'": "x*y - 8*z/3"}
    assert describe_all(smooth(equations)) == ["x, y -> -x, -y"]


def test_alike_cells_take_each_others_place():
    cells = {"x1'": "-x1 + tanh(2*x2(t - a))", "x2'": "-x2 + tanh(2*x1(t - b))"}
    assert describe_all(smooth(cells, {"a": 1, "b": 1})) == [
        "x1, x2 -> -x1, -x2",
        "x1, x2 -> x2, x1",
        "x1, x2 -> -x2, -x1",
    ]
    # With other delays they are no longer alike.
    assert describe_all(smooth(cells, {"a": 1, "b": 2})) == ["x1, x2 -> -x1, -x2"]


def test_a_ring_of_many_cells_turns():
    cells = {f"x{k}'": f"-x{k} + x{k % 6 + 1}**2" for k in range(1, 7)}
    found = describe_all(smooth(cells))
    # Each reads the next one, so that the ring does not turn over.
    assert len(found) == 5
    assert "x1, x2, x3, x4, x5, x6 -> x2, x3, x4, x5, x6, x1" in found


@pytest.mark.parametrize(
    ("force", "found"),
    [("cos(w*t)", ["x, v -> -x, -v, half a forcing period later"]), ("0.1 + cos(w*t)", []), ("cos(2*w*t)", [])],
)
def test_a_forced_oscillator_is_its_image_half_a_period_later(force, found):
    equations = {"x'": "v", "v'": f"{force} - x**3 - 0.1*v"}
    assert describe_all(smooth(equations, {"w": 1.3}, forcing={"period": "2*pi/w"})) == found


@pytest.mark.parametrize(("gap", "found"), [(1, ["x, v -> -x, -v, half a forcing period later"]), (2, [])])
def test_stops_on_both_sides_are_images_of_each_other(gap, found):
    numeric = numeric_from(
        {
            "name": "o",
            "states": ["x", "v"],
            "parameters": {"w": 1.3, "d": gap},
            "forcing": {"period": "2*pi/w"},
            "modes": {"free": {"x'": "v", "v'": "cos(w*t) - x"}},
            "events": {"up": "x - 1", "down": "x + d"},
            "resets": {"hit": {"v": "-0.8*v"}},
            "segments": {
                "U": {"mode": "free", "event": "up", "direction": "rising", "reset": "hit", "to": "free"},
                "D": {"mode": "free", "event": "down", "direction": "falling", "reset": "hit", "to": "free"},
            },
        }
    )
    assert describe_all(numeric) == found


def test_modes_are_images_of_each_other():
    # A relay: where x is below zero it is pushed up, elsewhere down, with a delay.
    assert describe_all(shipped("relay")) == ["x -> -x"]


def test_models_without_symmetry_have_none():
    for name in ("bouncing_ball", "impact_oscillator", "wright"):
        assert describe_all(shipped(name)) == []
