"""The amplitude of orbits that can shrink, with its sign."""

from dataclasses import replace

import numpy as np
import pytest

from pddecont.continuation import End
from pddecont.orbit import Orbit, bound_amplitude, measure_size
from pddecont.orbit.amplitude import NEAR, can_shrink
from tests.bifurcation.runs import NORMAL_FORM, SECTION
from tests.orbits import settle_to_orbit


class At:
    """An evaluation that holds an orbit."""

    def __init__(self, orbit):
        self.orbit = orbit


def scale_about_mean(orbit, factor):
    """Return an orbit with its values about their mean times a factor, as the same problem's."""
    mean = orbit.values.mean(axis=0)
    x = orbit.x.copy()
    x[orbit.problem.unknowns.values] = (mean + factor * (orbit.values - mean)).ravel()
    return Orbit(orbit.problem, x)


@pytest.mark.parametrize("model", [NORMAL_FORM, SECTION], ids=["by its phase", "by its event"])
def test_the_margin_is_the_signed_amplitude(model):
    orbit = settle_to_orbit(model).with_phase_reference()
    boundary = bound_amplitude(orbit)
    size = measure_size(orbit, boundary.sizes)
    assert size == pytest.approx(np.sqrt(0.5), rel=0.05)
    for factor in (1.0, 0.3, 1e-3, -1e-3, -0.1):
        (margin,) = boundary.margins(At(scale_about_mean(orbit, factor)))
        assert margin == pytest.approx(size * (factor - NEAR), abs=1e-12)


@pytest.mark.parametrize("model", [NORMAL_FORM, SECTION], ids=["by its phase", "by its event"])
def test_its_gradient_is_its_derivative(model):
    orbit = settle_to_orbit(model).with_phase_reference()
    boundary, rng = bound_amplitude(orbit), np.random.default_rng(1)
    direction, h = rng.standard_normal(len(orbit.x)), 1e-6
    ends = [boundary.margins(At(Orbit(orbit.problem, orbit.x + sign * h * direction)))[0] for sign in (-1.0, 1.0)]
    (gradient,) = boundary.gradients(At(orbit))
    slope = (ends[1] - ends[0]) / (2 * h)
    assert gradient @ direction == pytest.approx(slope, abs=1e-6)


def test_forced_orbits_and_those_that_jump_have_no_margin():
    forced = settle_to_orbit("wall_oscillator", t_end=300)
    boundary = bound_amplitude(forced)
    assert not can_shrink(forced)
    assert boundary.margins(At(forced)).shape == (0,)
    assert boundary.gradients(At(forced)).shape == (0, len(forced.x))
    kicked = {**SECTION, "resets": {"kick": {"x": "0.9*x"}}}
    kicked["segments"] = {"turn": {**SECTION["segments"]["turn"], "reset": "kick"}}
    assert not can_shrink(settle_to_orbit(kicked))


def test_it_ends_a_branch_as_one_that_shrinks():
    orbit = settle_to_orbit(NORMAL_FORM)
    boundary = bound_amplitude(orbit)
    assert boundary.end == End.SHRINKS
    assert boundary.reason(At(orbit), 0).code == "shrinks"


def test_an_orbit_whose_reference_does_not_move_has_only_its_own_size():
    orbit = settle_to_orbit(NORMAL_FORM)
    still = Orbit(replace(orbit.problem, reference=np.zeros_like(orbit.values)), orbit.x)
    boundary = bound_amplitude(orbit)
    assert boundary.margins(At(still)) == pytest.approx([-boundary.least], abs=1e-15)
