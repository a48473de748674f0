"""The first point of a branch, with its direction towards larger values of the first parameter."""

import numpy as np
import pytest

from pddecont.bifurcation import BranchSettings
from pddecont.bifurcation.branch_start import BranchStart, find_forward_tangent, start_branch
from pddecont.collocation import MeshRule
from pddecont.orbit import parse_monitor
from tests.bifurcation.runs import free_amplitude

RULE = MeshRule(8, tol=1e-9)


def amplitude_of(orbit):
    return parse_monitor(orbit.numeric, "top", "max(x)").evaluate(orbit)


@pytest.mark.parametrize(("free", "slope"), [("F", 1.0), ("c", -0.1 * 4.0)])
def test_the_tangent_leads_to_the_orbits_beside(free_orbit, free, slope):
    """The amplitude A = F / |1 - w^2 + i c w| grows with F by A / F, and with c by -A^3 c w^2."""
    settings = BranchSettings((free,), ((0.0, 2.0),), RULE)
    start = start_branch(free_orbit, settings)
    point, A = start.point, free_amplitude(2.0)
    rate = point.tangent[-1]
    assert rate > 0.0
    assert point.system.scaling.length(point.tangent) == pytest.approx(1.0, abs=1e-12)
    ahead, behind = (amplitude_of(point.system.at(point.x + k * point.tangent).orbit) for k in (1e-3, -1e-3))
    expected = A * slope if free == "F" else A**3 * slope
    assert (ahead - behind) / (2e-3 * rate) == pytest.approx(expected, rel=1e-4)


def test_it_starts_on_the_orbit_itself(free_orbit):
    start = start_branch(free_orbit, BranchSettings(("c",), ((0, 1),), RULE))
    assert (start.kind, start.one_way) == ("", False)
    assert start.point.at.orbit.problem.free == ("c",)
    assert np.array_equal(start.point.at.orbit.values, free_orbit.values)
    assert start.point.solution is None
    assert isinstance(start, BranchStart)


def test_forward_is_the_way_of_the_first_parameter(hop_orbit):
    for free in ("wall", "r"):
        system, orbit = BranchSettings((free,), ((0, 1),), RULE).make_system(hop_orbit)
        at = system.at(orbit.x)
        tangent = find_forward_tangent(system, at)
        assert tangent[orbit.problem.unknowns.free.start] > 0.0
        assert np.max(np.abs(at.jacobian() @ tangent)) < 1e-8
