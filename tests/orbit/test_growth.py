"""What may grow along a branch of orbits, and what is said of it."""

import numpy as np
import pytest

from pddecont.orbit import OrbitHorizon
from pddecont.reasons import make_reason
from tests.orbit.test_boundaries import at, free_orbit

HORIZON = OrbitHorizon(np.array([0.1, 3.0]))


def test_rows_give_the_quantities():
    here = at(free_orbit())
    sizes = HORIZON.sizes(here)
    assert HORIZON.rows(here) @ here.orbit.x == pytest.approx(sizes, rel=1e-14)
    assert sizes[0] == here.orbit.period
    assert np.all(sizes[1:] == np.max(np.abs(here.orbit.values), axis=0))


def test_what_grows_is_named_with_the_limits_of_all_parameters():
    here = at(free_orbit())
    assert np.all(here.orbit.x[HORIZON.find_parameters(here)] == here.orbit.free)
    limits, errors = np.array([0.25, 3.5]), np.array([1e-6, 1e-7])
    of_period, of_state = (HORIZON.reason(here, k, limits, errors) for k in (0, 1))
    assert (of_period.code, of_period.values["what"], of_period.values["name"]) == ("grows", "period", "")
    assert (of_state.values["what"], of_state.values["name"]) == ("state", here.orbit.numeric.model.states[0])
    assert of_state.values["value"] == np.max(np.abs(here.orbit.values[:, 0]))
    assert of_state.values["limit K"] == 0.25 and of_state.values["error tau_d"] == 1e-7


def test_simulations_that_leave_an_orbit_late_say_nothing_and_those_that_meet_something_do():
    assert HORIZON.is_lost(make_reason("drifts", number=1, segment="C"))
    assert not HORIZON.is_lost(make_reason("slides", number=1, segment="C", event="hit"))
