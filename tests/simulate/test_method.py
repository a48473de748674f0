"""How to integrate: the defaults that the documentation states, and what they do."""

import numpy as np
import pytest

from pddecont.simulate import Method
from tests.simulate.motions import trajectory_of

OSCILLATOR = "name: o\nstates: [x, v]\nmodes: {m: {x': v, v': -x}}\ninitial: {x: 1}\n"


def test_the_defaults():
    method = Method()
    assert (method.rtol, method.atol, method.stiff, method.max_step) == (1e-9, 1e-11, False, np.inf)
    assert method.stick == {}


@pytest.mark.parametrize("stiff", [False, True])
def test_no_step_is_longer_than_the_longest(stiff):
    trajectory = trajectory_of(OSCILLATOR, 10.0, Method(max_step=0.01, stiff=stiff))
    assert np.max(trajectory.length) <= 0.01


def test_tolerances_are_met():
    loose, tight = (trajectory_of(OSCILLATOR, 10.0, Method(rtol, rtol))(10.0)[0] for rtol in (1e-4, 1e-10))
    assert abs(tight - np.cos(10)) < 1e-9 < abs(loose - np.cos(10)) < 1e-2
