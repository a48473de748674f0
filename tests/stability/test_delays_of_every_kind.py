"""Multipliers of smooth orbits with delays that vary, rates and integrals of the past, against Hill's method."""

from __future__ import annotations

import numpy as np
import pytest

from pddecont.collocation import MeshRule
from pddecont.stability import find_multipliers, multipliers
from pddecont.stability.monodromy import linearise_period
from pddecont.stability.refinement import Refined
from tests.delay_kinds import KINDS, exact, solve

STEP = 1e-3


def hill_matrix(kind, exponent, n=40):
    """Return the matrix of a perturbation exp(l t) p(t), p a Fourier series of n harmonics, at equally spaced times.

    The field is differentiated by differences of the fourth order.
    """
    field, known = KINDS[kind][2], exact(kind)
    t = known.period * np.arange(2 * n + 1) / (2 * n + 1)
    columns = []
    for k in range(-n, n + 1):
        power = exponent + 2j * np.pi / known.period * k
        slope = 0.0
        for part, unit in ((np.real, 1.0), (np.imag, 1j)):
            for weight, h in ((8.0, STEP), (-8.0, -STEP), (-1.0, 2 * STEP), (1.0, -2 * STEP)):

                def read(s, derivative=0, part=part, h=h, power=power):
                    return known(s, derivative) + h * part(power**derivative * np.exp(power * s))[None]

                x = known(t) + h * part(np.exp(power * t))[None]
                slope = slope + unit * weight * field(t, x, read)[0] / (12 * STEP)
        # The common factor exp(l t) leaves the matrix well scaled.
        columns.append((power * np.exp(power * t) - slope) * np.exp(-exponent * t))
    return np.array(columns).T


@pytest.mark.parametrize("kind", KINDS)
def test_multipliers_against_hill_s_method(kind):
    found = find_multipliers(solve(kind, MeshRule(8, None, 1e-12)))
    period = exact(kind).period
    if not KINDS[kind][3]:
        assert np.min(np.abs(found.values - 1)) < 1e-9
    leading = [mu for mu in found.values if abs(mu) > 0.02 and abs(mu - 1) > 1e-6 and mu.imag >= 0][:3]
    assert leading
    for mu in leading:
        exponent = np.log(complex(mu)) / period
        matrix, h = hill_matrix(kind, exponent), 1e-5
        slope = (hill_matrix(kind, exponent + h) - hill_matrix(kind, exponent - h)) / (2 * h)
        u, s, vh = np.linalg.svd(matrix)
        missed = s[-1] / abs(u[:, -1].conj() @ slope @ vh[-1].conj())
        assert missed * period * abs(mu) < 1e-8


def test_a_multiplier_of_the_mesh_alone_is_left_out_of_an_orbit_with_rates(monkeypatch):
    """On one mesh of a transmission line -1.37 was one, its residual rounding; on no other mesh is it there."""
    orbit = solve("neutral", MeshRule(6, None, 1e-8))
    own = find_multipliers(orbit)
    spurious, find = Refined(-1.37 + 0j, 1e-15, np.zeros(0, dtype=complex), True), multipliers.find_all_outside

    def find_more(*given):
        found = find(*given)
        return None if found is None else [spurious, *found]

    monkeypatch.setattr(multipliers, "find_all_outside", find_more)
    assert find_more(linearise_period(orbit), 16, 0.95) is not None
    found = find_multipliers(orbit)
    assert np.array_equal(found.values, own.values) and found.counted and found.stable == own.stable
