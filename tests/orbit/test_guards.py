"""How far an orbit's conditions are from changing, and whether orbits whose conditions fail are motions."""

from dataclasses import replace

import numpy as np
import pytest

from pddecont.orbit import Orbit, Referee, find_violations, list_guarded, measure_guard
from pddecont.orbit.guards import is_alternative
from tests.guarded import LOW, MIDDLE, RAMP, TOP
from tests.orbits import settle_to_orbit
from tests.runs import change


def at(orbit, **values):
    """Return an orbit whose equations do not read some parameters, at other values of these."""
    p = orbit.parameters.copy()
    for name, value in values.items():
        p[orbit.numeric.parameter_index(name)] = value
    return Orbit(replace(orbit.problem, parameters=p), orbit.x)


@pytest.fixture(scope="module")
def orbit():
    return settle_to_orbit(RAMP)


def test_the_distance_is_that_of_the_sides_in_sizes_of_the_state(orbit):
    """The state swings from LOW to TOP; its size is half of that."""
    size = 0.5 * (TOP - LOW)
    after = {"tick>idle": TOP - 0.6, "tock>idle": MIDDLE - 0.6, "tock>feed": 0.6 - LOW}
    assert list_guarded(orbit.signature) == [0, 1, 2]
    for s, name in enumerate(orbit.signature.names):
        assert measure_guard(orbit, s) == pytest.approx(after[name] / size, abs=1e-8)


@pytest.mark.parametrize("unit", [1e-6, 1e6])
def test_units_do_not_matter(orbit, unit):
    rates = {"ramp": 0.6 * unit, "up": unit}
    scaled = settle_to_orbit(change(RAMP, "parameters", {**RAMP["parameters"], **rates}))
    for name in orbit.signature.names:
        found = [measure_guard(o, o.signature.names.index(name)) for o in (orbit, scaled)]
        assert found[1] == pytest.approx(found[0], rel=1e-9)


@pytest.mark.parametrize("ramp", [LOW + 1e-6, 0.7, MIDDLE - 1e-6])
def test_where_the_conditions_hold_the_orbit_is_a_motion(orbit, ramp):
    other = at(orbit, ramp=ramp)
    assert not find_violations(other)
    assert Referee(other.numeric, other.problem.delay).verify(other, strict=True).verified == 1


@pytest.mark.parametrize(
    ("ramp", "name"), [(LOW - 1e-6, "tock>feed"), (0.2, "tock>feed"), (MIDDLE + 1e-6, "tock>idle"), (1.1, "tock>idle")]
)
def test_where_one_fails_it_is_none(orbit, ramp, name):
    other = at(orbit, ramp=ramp)
    assert [(v.code, v.values["segment"]) for v in find_violations(other)] == [("guard", name)]
    for strict in (True, False):
        found = Referee(other.numeric, other.problem.delay).verify(other, strict=strict)
        assert (found.verified, found.reason.code, found.reason.values["segment"]) == (0, "guard", name)


def test_at_the_point_itself_an_orbit_counts_as_a_motion(orbit):
    for ramp in (LOW, np.nextafter(LOW, 0), np.nextafter(MIDDLE, 1)):
        other = at(orbit, ramp=ramp)
        assert Referee(other.numeric, other.problem.delay).verify(other).verified == 1


def test_alternatives_end_alike(orbit):
    s = orbit.signature.names.index("tick>idle")
    found = [is_alternative(orbit.signature, s, name) for name in ("tick>feed", "tick>idle", "tock>feed")]
    assert found == [True, False, False]
