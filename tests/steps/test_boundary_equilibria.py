"""Equilibria that meet the surface on which their equations change."""

import pytest

from tests.runs import labels, parameter, run

# x' = a - x - b max(0, x - 1): x = a up to the corner, x = (a + b)/(1 + b) beyond it.
CORNER = {
    "name": "corner",
    "states": ["x"],
    "parameters": {"a": 0.5, "b": 0},
    "equations": {"x'": "a - x - b*max(0, x - 1)"},
}


def follow(b, tmp_path, a=0.5):
    steps = [
        {"name": "rest", "set": {"a": a, "b": b}, "equilibrium": {"from": {"x": a}}},
        {"name": "in_a", "continue": {"from": "rest", "free": ["a"], "range": {"a": [0, 2]}}},
    ]
    return run({**CORNER, "run": {"steps": steps}}, tmp_path / "a.h5").step("in_a")


@pytest.mark.parametrize("b", [-3.0, -1.5, -1.1, -0.9, -0.5, 0.5, 4.0])
def test_a_corner_is_a_nonsmooth_fold_where_the_slope_changes_its_sign(b, tmp_path):
    branch = follow(b, tmp_path)
    assert labels(branch) == ["BE1"]
    row = branch.row("BE1")
    assert parameter(branch, "a", "BE1") == pytest.approx(1.0, abs=1e-14)
    assert branch.points["states"][row, 0] == pytest.approx(1.0, abs=1e-14)
    assert branch.points["admissible"][row] == 1
    nature = branch.reason(row).values["nature"]
    assert nature == ("nonsmooth fold" if b < -1.0 else "persistence")
    a, x = parameter(branch, "a"), branch.points["states"][branch.order, 0]
    beyond = x > 1.0 + 1e-12
    assert x[~beyond] == pytest.approx(a[~beyond], abs=1e-14)
    assert x[beyond] == pytest.approx((a[beyond] + b) / (1 + b), abs=1e-11)
    assert beyond.any()
    # Two equilibria for a < 1 and none beyond it, or one everywhere.
    assert a.max() == pytest.approx(1.0 if b < -1.0 else 2.0, abs=1e-14)
    stable = branch.points["stable"][branch.order] == 1
    assert (stable[beyond] == (b > -1.0)).all()
    assert stable[~beyond & (a < 1.0)].all()
