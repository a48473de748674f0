"""A few motions tell how far and how fast others go, in any units of time."""

import numpy as np
import pytest

from pddecont.delay import Direct
from pddecont.exploration import fly_pilots, make_survey
from pddecont.simulate import Method
from tests.conftest import numeric_from, shipped

METHOD = Method(1e-8, 1e-10)


def survey_of(numeric, points, free=(0,)):
    own = list(range(numeric.n_states))
    return make_survey(numeric, fly_pilots(numeric, Direct(), METHOD, points, own), free, own)


def van_der_pol(unit):
    equations = {"x'": f"v/{unit}", "v'": f"(m*(1 - x**2)*v - x)/{unit}"}
    return {"name": "o", "states": ["x", "v"], "parameters": {"m": 1}, "modes": {"free": equations}}


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
def test_the_time_to_settle_follows_the_unit_of_time(unit):
    survey = survey_of(numeric_from(van_der_pol(unit)), [np.array([1.0])])
    period = 6.6632869 * unit
    assert 100 * period < survey.transient < 3000 * period
    # It goes from -2.0086 to 2.0086.
    assert -2.6 < survey.low[0] < -2.0 < 2.0 < survey.high[0] < 2.6


def test_motions_at_rest_have_a_box_around_them():
    model = {"name": "o", "states": ["x"], "parameters": {"a": 1}, "modes": {"free": {"x'": "-a*x"}}}
    survey = survey_of(numeric_from(model), [np.array([1.0])])
    assert survey.low[0] < 0.0 < survey.high[0]
    assert 10.0 < survey.transient < 1e4


def test_returns_are_counted_at_an_event_that_goes_on_happening():
    assert survey_of(shipped("relay"), [np.array([0.5, 1.0])]).event == "switch"


def test_returns_of_forced_motions_are_away_from_events():
    numeric = shipped("wall_oscillator")
    p = np.array(list(numeric.model.parameters.values()), dtype=float)
    # It hits at t = 1.0849389538 after whole periods, pi; farthest from that is half a period later.
    assert survey_of(numeric, [p]).phase == pytest.approx(1.0849389538 / np.pi + 0.5, abs=0.01)


def test_a_motion_that_cannot_be_followed_is_left_out():
    numeric = numeric_from(
        {"name": "o", "states": ["x"], "parameters": {"a": 1}, "modes": {"free": {"x'": "a + x**2"}}}
    )
    assert fly_pilots(numeric, Direct(), METHOD, [np.array([1.0])], [0]) == []
