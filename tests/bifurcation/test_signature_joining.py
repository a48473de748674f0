"""What joins where a signature ends: an orbit near the last one that is a motion of the model."""

import pytest

from pddecont.bifurcation.signature_joining import check_motion, check_near
from pddecont.errors import ConvergenceError
from pddecont.orbit import Orbit, Verification
from pddecont.reasons import make_reason
from tests.orbit.exact import circle


def grow(orbit, factor):
    """Return a circle of another radius."""
    unknowns = orbit.problem.unknowns
    return Orbit(orbit.problem, unknowns.join(factor * orbit.values, orbit.durations, orbit.start, orbit.free))


class Says:
    """A referee that says the same of every orbit, leniently."""

    def __init__(self, verified):
        self.verified = verified

    def verify(self, orbit, *, strict=False):
        return Verification(0 if strict else self.verified, reason=make_reason("halts"))


def test_an_orbit_near_the_last_one_joins():
    orbit = circle()
    # States go from -1 to 1 and are measured in half of that.
    assert check_near(grow(orbit, 1.1), orbit) == pytest.approx(0.1, abs=1e-6)


def test_an_orbit_half_as_large_again_does_not():
    with pytest.raises(ConvergenceError, match=r"does not join here: it is 0\.\d+ of the orbit's size away"):
        check_near(grow(circle(), 1.6), circle())


@pytest.mark.parametrize("verified", [1, -1])
def test_what_a_simulation_does_not_refuse_may_join(verified):
    check_motion(circle(), Says(verified))


def test_an_orbit_that_is_no_motion_does_not_join():
    with pytest.raises(ConvergenceError, match=r"is no motion of the model \(halts\)"):
        check_motion(circle(), Says(0))
    with pytest.raises(ConvergenceError, match="no motion"):
        check_motion(circle(), Says(1), strict=True)
