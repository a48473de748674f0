"""Coefficients of normal forms, against expansions of small orbits in many digits and closed forms."""

import math

import numpy as np
import pytest

from pddecont.equilibrium import Equilibrium, find_birth
from pddecont.equilibrium.normal_forms import Forms, find_cubic_coefficient
from tests.equilibrium import harmonic_balance
from tests.equilibrium.hopf_models import ALL
from tests.equilibrium.motions import make_motion


@pytest.fixture(scope="module")
def births():
    """Return Hopf points from equations written in Python alone."""
    return {
        name: harmonic_balance.find_birth(made.field, made.states, made.frequency, made.near)
        for name, made in ALL.items()
    }


def make_equilibrium(model, parameters, states, method=None):
    """Return an equilibrium of a model at ``parameters``, a mapping, of which others keep their values."""
    motion, p = make_motion(model, method)
    for name, value in parameters.items():
        p[motion.numeric.parameter_index(name)] = value
    return Equilibrium(motion, np.array(states, dtype=float), p)


@pytest.mark.parametrize("name", ALL)
def test_the_cubic_coefficient_is_that_of_small_orbits(births, name):
    """To rounding: both parts, for up to three delays, and functions that are no polynomials."""
    made, expected = ALL[name], births[name]
    at = make_equilibrium(made.model, {made.free: expected.parameter}, expected.states)
    forms = Forms(at)
    critical = forms.find_critical(1j * expected.frequency)
    assert abs(np.vdot(critical.right, expected.vector)) == pytest.approx(1.0, abs=1e-12)
    assert abs(find_cubic_coefficient(forms, critical) - expected.cubic) < 1e-11 * abs(expected.cubic)


@pytest.mark.parametrize("name", ALL)
def test_orbits_grow_as_small_orbits_do(births, name):
    """The speed of the root is a central difference over 1e-5 of the range."""
    made, expected = ALL[name], births[name]
    at = make_equilibrium(made.model, {made.free: expected.parameter}, expected.states)
    birth = find_birth(at, at.motion.numeric.parameter_index(made.free), made.range_[1] - made.range_[0])
    assert birth.frequency == pytest.approx(expected.frequency, rel=1e-12)
    assert birth.coefficient == pytest.approx(expected.cubic.real / expected.frequency, rel=1e-10)
    assert birth.growth == pytest.approx(expected.growth, rel=1e-9)


def test_wrights_coefficient_in_closed_form(births):
    closed = -(3 * math.pi - 2) / 10 * (math.pi / 2) / (1 + math.pi**2 / 4)
    assert births["wright"].cubic.real == pytest.approx(closed, rel=1e-14)
    assert births["wright"].growth == pytest.approx(10 / (3 * math.pi - 2), rel=1e-14)
