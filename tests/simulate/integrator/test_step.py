"""Steps are as long as the tolerances, the stops and the longest step allow."""

import math

import numpy as np
import pytest

from pddecont.native.integrator import N_REJECTED, Status
from pddecont.simulate import Method
from tests.simulate.motions import trajectory_of
from tests.simulate.orders import bouncer_errors, oscillator_error

DECAY = "name: m\nstates: [x]\nmodes: {m: {x': RATE}}\n"


@pytest.mark.parametrize(("stop", "longest"), [(1e-6, 1e-6), (2.0, 2.0), (1e3, 3.0)])
def test_a_step_goes_no_farther_than_its_stop(interpreted, stop, longest):
    run = interpreted.start(DECAY.replace("RATE", "-x"), [1.0], method=Method(max_step=3.0))
    h, status = interpreted.step.make_step(run.core, 0.0, stop)
    assert status == Status.REACHED
    assert 0 < h <= longest
    assert run.core.trial[1] == pytest.approx(math.exp(-h), rel=1e-9)


def test_no_short_step_is_left_over(interpreted):
    """A stop less than a hundredth beyond the step wanted is reached; one at 1.5 steps by two steps of one length."""
    run = interpreted.start(DECAY.replace("RATE", "-x/100"), [1.0])
    run.core.next_step[0] = 0.1
    for stop, expected in ((0.1005, 0.1005), (0.15, 0.075), (0.3, 0.1)):
        run.core.next_step[0] = 0.1
        h, _ = interpreted.step.make_step(run.core, 0.0, stop)
        assert h == pytest.approx(expected)


def test_a_step_that_is_too_long_is_tried_again_shorter(interpreted):
    run = interpreted.start(DECAY.replace("RATE", "-100*x"), [1.0])
    run.core.next_step[0] = 10.0
    h, status = interpreted.step.make_step(run.core, 0.0, 20.0)
    assert status == Status.REACHED
    assert h < 0.2
    assert run.core.count[N_REJECTED] > 0
    assert run.core.trial[1] == pytest.approx(math.exp(-100 * h), rel=1e-8)


def test_a_step_grows_by_its_bound_at_most(interpreted):
    run = interpreted.start(DECAY.replace("RATE", "0"), [1.0])
    run.core.next_step[0] = 1.0
    interpreted.step.make_step(run.core, 0.0, 100.0)
    assert run.core.next_step[0] == interpreted.step.GROW


def test_a_motion_on_a_delay_takes_no_longer_steps_than_it():
    trajectory = trajectory_of("name: m\nstates: [x]\nmodes: {m: {x': -x(t - 0.5)/100}}\n", 20.0, initial=[1.0])
    assert np.max(trajectory.length) <= 0.5


@pytest.mark.parametrize("stiff", [False, True])
def test_the_error_falls_with_the_tolerance_over_six_decades(stiff):
    made = np.array([oscillator_error(Method(rtol, rtol, stiff)) for rtol in 10.0 ** -np.arange(6, 13)])
    assert np.all(made[1:] < made[:-1] / 2)
    assert made[-1] < 1e-4 * made[0]


@pytest.mark.parametrize("stiff", [False, True])
@pytest.mark.parametrize(
    "errors", [oscillator_error, lambda method: max(bouncer_errors(method))], ids=["smooth", "hybrid"]
)
def test_errors_fall_with_the_tolerance(errors, stiff):
    allowed = 10.0 ** -np.arange(4, 11)
    made = np.array([errors(Method(rtol, rtol, stiff)) for rtol in allowed])
    assert np.all(made < 5 * allowed)
    # The delay alone keeps the hybrid problem's steps short, so that loose tolerances change little there.
    assert made[-1] < 0.01 * made.max()


@pytest.mark.parametrize("unit", [1.0, 1e6, 1e12])
@pytest.mark.parametrize("stiff", [False, True])
def test_a_state_may_start_at_zero_in_a_unit_far_from_that_of_the_tolerance(unit, stiff):
    """x' = v / unit, v' = -unit x from (-0.05, 0): v has another unit, and tells nothing of its size at first."""
    text = "name: m\nstates: [x, v]\nparameters: {u: 1}\nmodes: {m: {x': v/u, v': -u*x}}\n"
    trajectory = trajectory_of(text, 3.0, Method(1e-9, 1e-17, stiff), initial=[-0.05, 0.0], u=unit)
    x, v = trajectory(3.0)
    assert x == pytest.approx(-0.05 * math.cos(3.0), rel=1e-6)
    assert v / unit == pytest.approx(0.05 * math.sin(3.0), rel=1e-6)
