"""What stands over the axis of a diagram."""

import numpy as np
import pytest

from pddecont.errors import ResultsError
from pddecont.plot.heights import choose_columns, choose_height, read_heights
from tests.plot.equilibria import orbit_around
from tests.plot.synthetic import point


def test_of_orbits_a_state_is_its_largest_and_smallest_value(resting):
    step = resting.step("cycles")
    K = np.linspace(0.3, 0.7, 9)
    r = K - 0.3
    high, low = read_heights(step, "x")
    assert high == pytest.approx(K + 0.4 * r, abs=1e-12)
    # The smallest value lies between base points; of those themselves the smallest would be K - 0.0875 r.
    assert low == pytest.approx(K - 0.09 * r, abs=1e-4 * 0.4)
    assert min(orbit_around(0.7)["states"][:, 0]) > low[-1] + 5e-4


def test_of_equilibria_it_is_the_state(resting):
    step = resting.step("resting")
    assert read_heights(step, "x").tolist() == [step.points["parameters"][:, 1].tolist()]


def test_a_monitor_or_another_number_is_one_line(resting, every):
    assert read_heights(resting.step("cycles"), "top").shape == (1, 9)
    assert read_heights(every.step("in_gain"), "period").tolist() == [[7.0] * 33]
    with pytest.raises(ResultsError, match="no column 'tp'; did you mean 'top'"):
        read_heights(resting.step("cycles"), "tp")


def test_what_is_shown_when_nobody_says(every, made, resting):
    assert choose_columns([every.step("in_gain")]) == ("K", "top")
    assert choose_columns([every.step("orbit")]) == ("omega", "top")
    unknown = made(b=([point(0.0, 0.1, 3, np.nan)], {})).step("b")
    assert choose_columns([unknown]) == ("K", "period")


def test_where_equilibria_are_shown_it_is_a_state(resting):
    assert choose_columns([resting.step("cycles")]) == ("K", "top")
    assert choose_columns([resting.step("resting")]) == ("K", "x")
    assert choose_columns([resting.step("resting"), resting.step("cycles")]) == ("K", "x")
    assert choose_columns([resting.step("all")]) == ("x", "v")


def test_a_state_that_stays_is_not_chosen(resting, every):
    constant = resting.step("one")
    assert choose_height([constant, resting.step("cycles")]) == "x"
    assert choose_height([constant]) == "x"
    # Along the branch v is zero, x is not; of these two x differs.
    assert choose_height([resting.step("all")]) == "x"
