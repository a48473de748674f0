"""Simulations across the ends of an orbit's segments: where they begin and end, and what moves them."""

import numpy as np
import pytest

from pddecont.orbit import Referee
from pddecont.orbit.examination import Examination
from tests.orbit.exact import TURN, circle


def examine(orbit):
    referee = Referee(orbit.numeric, orbit.problem.delay)
    return Examination(orbit, referee.simulators, referee.is_driven)


def test_windows_together_hold_the_whole_orbit():
    examined = examine(circle("s", "s"))
    windows = examined.list_windows(0.3)
    assert [w.s for w in windows] == [0, 1]
    assert [w.begin for w in windows] == pytest.approx([0.3 * TURN, 1.3 * TURN])
    assert [w.end for w in windows] == pytest.approx([1.3 * TURN, 2.3 * TURN])
    assert [w.event for w in windows] == pytest.approx([TURN, 2 * TURN])


def test_a_motion_from_the_orbit_stays_on_it_and_one_moved_away_comes_nearer():
    """Both states are drawn to the circle at the rate 1 and the delayed ones are moved too: in closed form.

    The distance of x after the time t is that at its beginning times exp(-t); the event comes a little later or sooner
    and changes nothing.
    """
    examined = examine(circle("s", level=0.5))
    window = examined.list_windows(0.5)[0]
    assert examined.simulate(window).states == pytest.approx(window.target, abs=1e-8)
    moved = examined.simulate(window, 1e-3)
    assert moved.segments == ("s",)
    distance = (moved.states - window.target)[0]
    assert distance == pytest.approx(1e-3 * examined.sizes[0] * np.exp(-(window.end - window.begin)), rel=1e-4)
