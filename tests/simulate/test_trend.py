"""Motions that rest, die away or grow are told from those that repeat themselves."""

import numpy as np
import pytest

from pddecont.simulate.trend import find_decay, find_growing_state, is_at_rest
from tests.simulate.motions import trajectory_of

OSCILLATOR = (
    "name: o\nstates: [x, v, z]\nparameters: {c: 0.05, g: 0}\n"
    "modes: {m: {x': v, v': -c*v - x, z': g}}\ninitial: {x: 1}\n"
)


def test_swings_that_shrink_by_one_factor_are_a_decay():
    """The amplitude goes with exp(-c t / 2); the later six tenths are six stretches of 40 time units."""
    decay = find_decay(trajectory_of(OSCILLATOR, 400.0, c=0.05))
    assert decay is not None
    assert decay.length == pytest.approx(40)
    # Tops come half a turn apart, so that they may lie so much earlier or later in one stretch than in the next.
    assert abs(np.log(decay.factor) + 0.05 * 40 / 2) < 0.05 * np.pi / 2


@pytest.mark.parametrize("c", [0.0, 1e-3, -0.05])
def test_a_motion_that_goes_on_hardly_shrinks_or_grows_does_not_decay(c):
    assert find_decay(trajectory_of(OSCILLATOR, 400.0, c=c)) is None


def test_a_motion_is_at_rest_where_no_state_moves():
    assert is_at_rest(trajectory_of(OSCILLATOR, 400.0, c=0.5))
    assert not is_at_rest(trajectory_of(OSCILLATOR, 400.0, c=0.0))
    # One long step says nothing of what happens within it.
    assert not is_at_rest(trajectory_of(OSCILLATOR, 400.0, c=0.5, g=1e-3))


@pytest.mark.parametrize(("g", "expected"), [(0.1, 2), (-0.1, 2), (0.0, None)])
def test_a_state_that_goes_one_way_is_found(g, expected):
    found = find_growing_state(trajectory_of(OSCILLATOR, 100.0, c=0.0, g=g))
    assert (None if found is None else found[0]) == expected
    if found is not None:
        assert found[1:] == pytest.approx((40 * g, 100 * g), rel=1e-6)
