"""What of a simulation speaks against an orbit, and where the orbit's own error leaves both answers open."""

from dataclasses import replace

import numpy as np
import pytest

from pddecont.orbit import Referee, find_event_profile
from pddecont.orbit.examination import Examination
from pddecont.orbit.judgement import find_unexpected, judge
from pddecont.simulate import FailureReason, MotionFailure, MotionRecord
from tests.orbit.exact import TURN, circle

# The level of an orbit that all but touches its surface: it rises through it at a rate of 1e-4.
NEARLY_TOUCHING = float(np.sqrt(1.0 - 1e-8))
SLIDES = MotionFailure(FailureReason.SLIDING, 0.0, "e", "m")
UNDEFINED = MotionFailure(FailureReason.UNDEFINED, 0.0, None, "m")


class Scripted(Examination):
    """An orbit whose moved simulations are written down."""

    def simulate(self, window, moved=0.0):
        return self.others[int(moved < 0.0)]


def examine(level=0.5, *, others=(None, None), names=("s",)):
    orbit = circle(*names, level=level)
    referee = Referee(orbit.numeric, orbit.problem.delay)
    examined = Scripted(orbit, referee.simulators, referee.is_driven)
    object.__setattr__(examined, "others", others)
    return examined, examined.list_windows(0.5)[0]


def record(examined, window, *, events=((0.0, "s"),), off=0.0, failure=None, fails=0.0):
    """Return what a motion does: events at times after the one expected, in turns, and how far off it ends."""
    turn, at = examined.orbit.period, examined.orbit.start + window.event
    times = np.array([at + late * turn for late, _ in events])
    failure = failure and replace(failure, time=at + fails * turn)
    states = window.target + off * examined.sizes
    return MotionRecord(times, tuple(name for _, name in events), states, failure)


def test_a_motion_that_ends_elsewhere_is_not_excused_by_others_that_go_another_way():
    """Moved by its error it meets no event at all, far from any border: that does not make 10 % of its size right."""
    examined, window = examine()
    other = record(examined, window, events=())
    examined, window = examine(others=(other, other))
    found = judge(examined, window, record(examined, window, off=0.1), strict=False)
    assert (found.verified, found.reason.code) == (0, "drifts")
    assert found.deviation == pytest.approx(0.1)


def test_a_motion_that_ends_as_far_away_as_its_error_is_carried_is_the_orbit():
    examined, window = examine()
    near, same = record(examined, window, off=0.2), record(examined, window, off=0.1)
    examined, window = examine(others=(near, record(examined, window, events=())))
    for strict in (False, True):
        assert judge(examined, window, same, strict=strict).verified == 1


def test_at_a_border_that_moved_motions_cross_its_error_may_be_carried_anywhere_unless_strict():
    examined, window = examine(NEARLY_TOUCHING)
    other = record(examined, window, events=())
    examined, window = examine(NEARLY_TOUCHING, others=(other, other))
    off = record(examined, window, off=0.1)
    assert judge(examined, window, off, strict=False).verified == 1
    assert judge(examined, window, off, strict=True).verified == 0


@pytest.mark.parametrize(
    ("does", "verified"),
    [
        # The surface is missed, or met once more; what follows is another matter.
        ({"events": ()}, 1),
        ({"events": ((0.0, "s"), (0.001, "s"))}, 1),
        ({"failure": SLIDES}, 1),
        ({"events": (), "failure": UNDEFINED, "fails": 0.1}, 1),
        # Something else happens before, or at the event.
        ({"events": ((-0.2, "s"), (0.0, "s"))}, 0),
        ({"events": (), "failure": UNDEFINED, "fails": -0.2}, 0),
        ({"failure": UNDEFINED}, 0),
    ],
)
def test_what_a_touched_surface_excuses(does, verified):
    """The orbit meets its surface at a rate of 1e-4 in its size and period: within its error it may miss it."""
    examined, window = examine(NEARLY_TOUCHING)
    profile = find_event_profile(examined.orbit, "e")
    assert profile.end_slope(0) == pytest.approx(1e-4, rel=1e-3)
    found = judge(examined, window, record(examined, window, **does), strict=False)
    assert found.verified == verified
    assert np.isnan(found.deviation)
    assert judge(examined, window, record(examined, window, **does), strict=True).verified == 0


@pytest.mark.parametrize("does", [{"events": ()}, {"failure": SLIDES}, {"events": ((0.0, "s"), (0.001, "s"))}])
def test_a_surface_that_is_crossed_excuses_nothing(does):
    examined, window = examine(0.5)
    assert judge(examined, window, record(examined, window, **does), strict=False).verified == 0


def test_a_simulation_of_too_many_steps_says_nothing():
    examined, window = examine()
    found = judge(examined, window, None, strict=True)
    assert (found.verified, found.reason.code) == (-1, "too_many_steps")


def test_an_event_like_the_expected_one_but_at_another_time_is_told():
    """The orbit rises through its level once a turn; a motion that does so twice has one event more."""
    examined, window = examine(0.5)
    twice = record(examined, window, events=((-0.3, "s"), (0.0, "s")))
    assert find_unexpected(examined, window, twice) == (pytest.approx(window.event - 0.3 * TURN), "s")
    found = judge(examined, window, twice, strict=False)
    assert (found.reason.code, found.reason.values["number"]) == ("happens", 1)
    assert find_unexpected(examined, window, record(examined, window)) is None
