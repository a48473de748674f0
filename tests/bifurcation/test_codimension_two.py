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


def follow_through(model, branch, found_on, label, name, free, ranges):
    """Return a model whose run follows what goes on from a point of a curve."""
    steps = [step for step in model["run"]["steps"] if step["name"] in ("t", "o", branch, found_on)]
    more = {"from": {"step": found_on, "point": label}, "free": free, "range": ranges, "stability": True}
    return change(model, "run.steps", [*steps, {"name": name, "continue": more}])


@pytest.mark.parametrize(
    ("found_on", "label", "kind"), [("LP", "FF1", "PD"), ("PD", "FF1", "LP"), ("LP", "FT1", "TR"), ("PD", "PT2", "TR")]
)
def test_the_other_curve_goes_on_from_where_two_meet(tmp_path, found_on, label, kind):
    """The linear map of a product doubles, folds or has its pair on the circle at c = -1 or 1, whatever a is."""
    linear = ("c*y", "0.2*z") if label == "FF1" else ("c*(0.6*y - 0.8*z)", "c*(0.8*y + 0.6*z)")
    model = change(change(PRODUCT, "resets.g.y", linear[0]), "resets.g.z", linear[1])
    ranges = {"a": [-2, 2], "c": [-1.3, 1.3]}
    results = run(follow_through(model, "n", found_on, label, "other", ["c", "a"], ranges), tmp_path / "a.h5")
    step = results.step("other")
    start = parameter(results.step(found_on), "c", label)
    assert step.meta["curve"] == kind
    c, ordinary = parameter(step, "c"), step.points["kind"] == b""
    assert c[ordinary] == pytest.approx(np.full(np.sum(ordinary), start), abs=1e-8)
    # Where both maps double at once the equation has a double zero.
    assert c == pytest.approx(np.full(len(step), start), abs=1e-6)
    assert np.ptp(parameter(step, "a")) > 1.0
    assert len(step.endings) == 2


def test_tori_go_on_from_resonances_on_other_curves(tmp_path):
    """Henon's map preserves areas at b = -1: its pair is on the circle between 1:1 at a = -1 and 1:2 at a = 3."""
    ranges = {"a": [-2, 4], "b": [-2, 0.3]}
    for found_on, label, far in (("LP", "R1_1", "R2"), ("PD", "R2_1", "R1")):
        model = follow_through(HENON, "c", found_on, label, "tori", ["a", "b"], ranges)
        step = run(model, tmp_path / f"{found_on}.h5").step("tori")
        assert step.meta["curve"] == "TR"
        assert parameter(step, "b") == pytest.approx(np.full(len(step), -1.0), abs=1e-8)
        assert f"{far}_1" in labels(step)
        at = {"R1": -1.0, "R4": 0.0, "R3": 1.25, "R2": 3.0}
        for found in labels(step):
            assert parameter(step, "a", found) == pytest.approx(at[found[:2]], abs=1e-7)
        # Beyond a resonance the same equations hold of two real multipliers, and no tori are born.
        assert len(step.endings) == 1
        assert "meets on the real axis" in describe_endings(step)[0]
