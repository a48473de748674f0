"""Orbits that a jump puts on a surface: admissible as long as the field beyond leads to it."""

from dataclasses import replace

import numpy as np
import pytest

from pddecont.orbit import Orbit, find_violation, find_violations, list_repellers, solve_orbit
from tests.orbit.test_verification import FINE
from tests.orbits import settle_to_orbit
from tests.steps.test_repulsion import PUT


@pytest.fixture(scope="module")
def orbit():
    return settle_to_orbit({k: v for k, v in PUT.items() if k != "run"}, {"m": 0.5}, 80)


def follow(orbit, m):
    """Return the orbit of the same signature at another m."""
    problem = replace(orbit.problem, parameters=np.array([m, 2.0]))
    return solve_orbit(Orbit(problem, orbit.x), FINE).at.orbit


def test_the_field_beyond_the_surface_is_measured(orbit):
    """Below, x' = 1 + m; a rate of parameters alone counts as it is."""
    (repeller,) = list_repellers(orbit)
    assert repeller.measure(orbit) == pytest.approx(1.5, abs=1e-12)
    beyond = follow(orbit, -1.2)
    assert repeller.measure(beyond) == pytest.approx(-0.2, abs=1e-12)


def test_where_it_leads_away_the_orbit_is_no_motion(orbit):
    assert find_violation(orbit, None).code == ""
    (violation,) = find_violations(follow(orbit, -1.2))
    assert violation.code == "repels"
    assert {k: violation.values[k] for k in ("switch", "surface")} == {"switch": "x", "surface": "x"}
    assert [violation.values[k] for k in ("time", "below", "above")] == pytest.approx([2.0, -0.2, 2.2], abs=1e-9)
