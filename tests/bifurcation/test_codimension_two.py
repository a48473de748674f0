"""Special points on curves of special points, of maps whose curves are known in closed form."""

import numpy as np
import pytest

from pddecont.tables import describe_endings
from tests.runs import change, labels, parameter, run

HENON = {
    "name": "henon",
    "states": ["x", "y"],
    "parameters": {"a": 0.3, "b": 0.2},
    "forcing": {"period": 1},
    "modes": {"m": {"x'": 0, "y'": 0}},
    "events": {"pulse": "sin(2*pi*t)"},
    "resets": {"g": {"x": "1 - a*x**2 + y", "y": "b*x"}},
    "segments": {"s": {"mode": "m", "event": "pulse", "direction": "rising", "reset": "g", "to": "m"}},
    "initial": {"x": 0.5, "y": 0.1},
    "run": {
        "mesh": {"degree": 3, "tol": 1e-09},
        "steps": [
            {"name": "t", "simulate": {"t_end": 200.5}},
            {"name": "o", "orbit": {"from": "t"}},
            {
                "name": "c",
                "continue": {
                    "from": "o",
                    "free": ["a"],
                    "range": {"a": [-0.3, 1]},
                    "stability": True,
                    "max_points": 60,
                },
            },
            {
                "name": "LP",
                "continue": {
                    "from": {"step": "c", "point": "LP1"},
                    "free": ["a", "b"],
                    "range": {"a": [-2, 2], "b": [-2, 0.3]},
                    "stability": True,
                },
            },
            {
                "name": "PD",
                "continue": {
                    "from": {"step": "c", "point": "PD1"},
                    "free": ["a", "b"],
                    "range": {"a": [-1, 4], "b": [-2, 0.3]},
                    "stability": True,
                },
            },
            {
                "name": "turned",
                "continue": {
                    "from": {"step": "c", "point": "PD1"},
                    "free": ["b", "a"],
                    "range": {"a": [-1, 4], "b": [-2, 0.3]},
                    "stability": True,
                },
            },
            {
                "name": "twice",
                "continue": {
                    "from": {"step": "c", "point": "PD1"},
                    "branch": "switch",
                    "free": ["a"],
                    "range": {"a": [-0.3, 1.2]},
                    "stability": True,
                },
            },
        ],
    },
}


def test_henons_map_as_a_reset(tmp_path):
    """Folds 4 a = -(1 - b)^2 with multipliers 1, -b; doublings 4 a = 3 (1 - b)^2 with -1, b: 1:1 at (-1, -1), 1:2 at
    (3, -1), both
    defective. The doubled orbit doubles at 4 a = 4 (1 - b)^2 + (1 + b)^2."""

    results = run(HENON, tmp_path / "a.h5")
    for name, factor, resonance, at in (
        ("LP", -1, "R1_1", (-1, -1)),
        ("PD", 3, "R2_1", (3, -1)),
        ("turned", 3, "R2_1", (3, -1)),
    ):
        step = results.step(name)
        a, b = parameter(step, "a"), parameter(step, "b")
        assert factor * (1 - b) ** 2 / 4 == pytest.approx(a, abs=1e-9)
        assert labels(step) == [resonance]
        assert (parameter(step, "a", resonance), parameter(step, "b", resonance)) == pytest.approx(at, abs=1e-9)
    twice = results.step("twice")
    assert parameter(twice, "a", "PD1") == pytest.approx(0.8**2 + 1.2**2 / 4, abs=1e-9)


PRODUCT = {
    "name": "product",
    "states": ["x", "y", "z"],
    "parameters": {"a": 0.3, "c": 0.5, "d": 0.3},
    "forcing": {"period": 1},
    "modes": {"m": {"x'": 0, "y'": 0, "z'": 0}},
    "events": {"pulse": "sin(2*pi*t)"},
    "resets": {"g": {"x": "1 - a*x**2", "y": "BLOCK_Y", "z": "BLOCK_Z"}},
    "segments": {"s": {"mode": "m", "event": "pulse", "direction": "rising", "reset": "g", "to": "m"}},
    "initial": {"x": 0.5},
    "run": {
        "mesh": {"degree": 3, "tol": 1e-09},
        "steps": [
            {"name": "t", "simulate": {"t_end": 200.5}},
            {"name": "o", "orbit": {"from": "t"}},
            {
                "name": "n",
                "continue": {
                    "from": "o",
                    "free": ["a"],
                    "range": {"a": [-0.3, 1]},
                    "stability": True,
                    "max_points": 60,
                },
            },
            {
                "name": "LP",
                "continue": {
                    "from": {"step": "n", "point": "LP1"},
                    "free": ["c", "a"],
                    "range": {"a": [-2, 2], "c": [-1.3, 1.3]},
                    "stability": True,
                },
            },
            {
                "name": "PD",
                "continue": {
                    "from": {"step": "n", "point": "PD1"},
                    "free": ["c", "a"],
                    "range": {"a": [-1, 4], "c": [-1.3, 1.3]},
                    "stability": True,
                },
            },
        ],
    },
}


@pytest.mark.parametrize(
    ("y", "z", "found"),
    [
        ("c*y", "0.2*z", {"LP": {"R1_1": 1, "FF1": -1}, "PD": {"FF1": 1, "R2_1": -1}}),
        ("c*(0.6*y - 0.8*z)", "c*(0.8*y + 0.6*z)", {"LP": {"FT1": -1, "FT2": 1}, "PD": {"PT1": -1, "PT2": 1}}),
    ],
)
def test_points_of_codimension_two_of_products_of_maps(tmp_path, y, z, found):
    """A quadratic map beside a linear one with the multiplier c, or c times a rotation: both happen on c = 1 and c =
    -1.
    """
    model = change(change(PRODUCT, "resets.g.y", y), "resets.g.z", z)
    results = run(model, tmp_path / "a.h5")
    for name, a in (("LP", -0.25), ("PD", 0.75)):
        step = results.step(name)
        assert sorted(labels(step)) == sorted(found[name])
        assert parameter(step, "a") == pytest.approx(np.full(len(step), a), abs=1e-9)
        assert not any("WARNING" in t for t in describe_endings(step))
        places = sorted(parameter(step, "c", label) for label in labels(step))
        assert places == pytest.approx(sorted(found[name].values()), abs=1e-8)
