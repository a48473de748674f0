"""Numbers of points by name, and what is shown when nobody says."""

import numpy as np
import pytest

from pddecont.errors import ResultsError
from pddecont.plot.columns import (
    choose_monitor,
    choose_plane,
    choose_states,
    describe_differences,
    describe_point,
    find_state,
    keep_comparable,
    list_columns,
    read_column,
    read_parameter,
    share_values,
)
from tests.plot.synthetic import point


@pytest.mark.parametrize(("name", "own"), [("in_gain", "period"), ("resting", "x")])
def test_every_column_that_is_listed_can_be_read(every, resting, name, own):
    step = (every if name in every.steps else resting).step(name)
    assert {"K", "top", own, "n_unstable"} <= set(list_columns(step))
    assert all(read_column(step, name).shape == (len(step),) for name in list_columns(step))
    assert np.array_equal(read_column(step, "K"), read_parameter(step, "K"))


@pytest.mark.parametrize(
    ("read", "name", "message"),
    [
        (read_column, "tp", "no column 'tp'; did you mean 'top'"),
        (read_column, "kind", "no column 'kind'"),
        (read_parameter, "top", r"no parameter 'top' \(parameters: omega, K, tau_d\)"),
        (find_state, "w", r"no state 'w'.*\(states: x, v\)"),
    ],
)
def test_what_is_not_there_is_said(every, read, name, message):
    with pytest.raises(ResultsError, match=message):
        read(every.step("in_gain"), name)


def test_what_is_shown_when_nobody_says(every, made):
    assert choose_monitor(every.step("in_gain")) == "top"
    assert choose_monitor(made(b=([point(0.0, 0.1, 3, np.nan)], {})).step("b")) == "period"
    assert choose_states(every.step("orbit"), None, None) == ("x", "v")
    assert choose_states(every.step("orbit"), "v", "x") == ("v", "x")


def test_a_plane_is_that_of_the_first_curve(every):
    steps = [every.step(name) for name in ("in_gain", "grazing", "folds")]
    assert choose_plane(steps, None, None) == ("tau_d", "K")
    assert choose_plane(steps, "K", None) == choose_plane(steps, None, "tau_d") == ("K", "tau_d")
    assert choose_plane(steps[:1], "omega", "K") == ("omega", "K")
    with pytest.raises(ResultsError, match="give -x and -y"):
        choose_plane(steps[:1], "K", None)
    assert keep_comparable(steps) == steps[1:]
    assert keep_comparable(steps[:1]) == steps[:1]


def test_branches_at_other_values_are_another_picture(made):
    rows = {tau_d: [point(float(k), 0.1 * k, tau_d, 1.0) for k in range(4)] for tau_d in (3.8, 4.2)}
    file = made(a=(rows[3.8], {}), b=(rows[4.2], {}), c=(rows[3.8], {}))
    assert [step.name for step in keep_comparable(list(file.steps.values()))] == ["a", "c"]
    unknown = made(a=(rows[3.8], {}), b=([point(float(k), 0.1 * k, np.nan, 1.0) for k in range(4)], {}))
    assert [step.name for step in keep_comparable(list(unknown.steps.values()))] == ["b"]


def test_points_are_called_by_label_and_free_parameters(every):
    assert describe_point(every.step("in_gain"), 8) == "LP1  $K$ = 0.3"
    assert describe_point(every.step("grazing"), 0) == "$\\tau_{d}$ = 3.64  $K$ = 0.1"


def test_steps_are_called_by_what_differs():
    values = np.array([[1.0, 2.0, 3.0], [1.0, 2.5, 4.0]])
    names = ["omega", "K", "tau_d"]
    assert describe_differences(names, values) == ["$K$ = 2  $\\tau_{d}$ = 3", "$K$ = 2.5  $\\tau_{d}$ = 4"]
    assert describe_differences(names, values[:1]) == [""]


def test_values_are_shared_but_for_rounding(every):
    one, other = every.step("in_gain"), every.step("in_delay")
    assert share_values(one, every.step("doubled"), ["omega", "tau_d"])
    assert not share_values(one, other, ["tau_d"])
    assert not share_values(one, other, ["nothing"])
