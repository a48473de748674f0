"""What runs say of equilibria whose lags would be negative, and of neutral equations."""

import numpy as np
import pytest

from pddecont.errors import ConvergenceError
from pddecont.tables import describe_done
from pddecont.tables.equilibria import list_equilibria
from tests.runs import parameter, run

ADVANCE = {
    "name": "advance",
    "states": ["x"],
    "parameters": {"b": 0.5, "c": 1.0},
    "modes": {"m": {"x'": "b - x(t - 1 + c*x)"}},
    "initial": {"x": 0.5},
}
NEUTRAL = {
    "name": "neutral",
    "states": ["x"],
    "parameters": {"b": -0.5, "c": 0.5, "tau": 1.0},
    "modes": {"m": {"x'": "-x + b*x(t - tau) + c*x'(t - tau)"}},
    "initial": {"x": 0.0},
}


def with_steps(model, *steps):
    """Return a model with a run."""
    return {**model, "run": {"steps": list(steps)}}


def test_a_branch_ends_where_its_lag_at_rest_is_zero(tmp_path):
    """x = b, the lag 1 - b."""
    made = with_steps(
        ADVANCE,
        {"name": "rest", "equilibrium": {"from": {"x": 0.5}}},
        {"name": "branch", "continue": {"from": "rest", "free": ["b"], "range": {"b": [0, 3]}, "stability": True}},
    )
    step = run(made, tmp_path / "r.h5").step("branch")
    assert np.max(parameter(step, "b")) == pytest.approx(1.0, abs=1e-9)
    assert "delay '-c*x + 1' becomes negative beyond x = 1, b = 1" in describe_done(step)
    assert np.all(step.points["stable"] >= 0)


def test_an_equilibrium_that_would_read_the_future_is_refused(tmp_path):
    made = with_steps(ADVANCE, {"name": "rest", "set": {"b": 2}, "equilibrium": {"from": {"x": 2}}})
    with pytest.raises(ConvergenceError, match="the delay '-c\\*x \\+ 1' is -1: it would read the future"):
        run(made, tmp_path / "r.h5")


def test_a_search_says_of_such_an_equilibrium_that_it_has_no_roots(tmp_path):
    made = with_steps(ADVANCE, {"name": "all", "set": {"b": 2}, "equilibrium": {"search": {"x": [-3, 3]}}})
    step = run(made, tmp_path / "r.h5").step("all")
    assert step.points["stable"].tolist() == [-1] and "would read the future" in describe_done(step)


@pytest.mark.parametrize(
    ("c", "words"), [(0.5, None), (0.95, "near 1: infinitely many"), (1.3, "1.3 together, not below 1")]
)
def test_coefficients_of_past_rates_near_one_are_warned_of(tmp_path, c, words):
    made = with_steps(NEUTRAL, {"name": "rest", "set": {"c": c}, "equilibrium": {"from": {"x": 0}}})
    step = run(made, tmp_path / "r.h5").step("rest")
    (row,) = list_equilibria(step)
    assert (row["note"] == "") if words is None else (words in row["note"] and words in describe_done(step))
    assert row["counted"] == (c < 1) and (row["stable"] is None) == (c > 1)


def test_a_branch_says_at_how_many_points_it_is_near_one(tmp_path):
    made = with_steps(
        NEUTRAL,
        {"name": "rest", "equilibrium": {"from": {"x": 0}}},
        {"name": "branch", "continue": {"from": "rest", "free": ["c"], "range": {"c": [0.4, 0.98]}, "stability": True}},
    )
    step = run(made, tmp_path / "r.h5").step("branch")
    near = int(np.sum(parameter(step, "c") >= 0.9))
    assert near > 0 and f"at {near} of the points the coefficients of delayed rates come to 0.98" in describe_done(step)
