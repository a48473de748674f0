"""Corrected multipliers: exact, with small residuals, real ones real; what is none is dropped."""

import numpy as np
import pytest

from pddecont.stability.characteristic import MapCharacteristic
from pddecont.stability.refinement import find_vector, refine

VALUES = np.array([1.2, 0.7, -0.4, 0.01])


def make_map(values=VALUES, seed=0):
    vectors = np.random.default_rng(seed).normal(size=(len(values), len(values)))
    return MapCharacteristic(vectors @ np.diag(values) @ np.linalg.inv(vectors))


@pytest.mark.parametrize("exact", VALUES)
@pytest.mark.parametrize("off", [0.0, 1e-9, 1e-3])
def test_a_multiplier_is_found_from_nearby_and_stays_real(exact, off):
    found = refine(make_map(), complex(exact * (1 + off)))
    assert found.value == pytest.approx(exact, rel=1e-12)
    assert complex(found.value).imag == 0.0
    assert found.residual < 1e-14 and not found.clustered


def test_complex_pairs_are_found():
    turn = 0.6 * np.array([[np.cos(1.0), -np.sin(1.0)], [np.sin(1.0), np.cos(1.0)]])
    found = refine(MapCharacteristic(turn), 0.33 + 0.5j)
    assert found.value == pytest.approx(0.6 * np.exp(1j), rel=1e-13)


def test_where_several_coincide_they_are_left_as_they_came():
    """A Jordan block: each of its eigenvalues is good for half of all digits, their sum for all."""
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    block = MapCharacteristic(turn @ np.array([[0.5, 1.0], [0.0, 0.5]]) @ turn.T)
    for guess in (0.5 + 1e-8j, 0.5 - 1e-8j):
        found = refine(block, guess)
        assert found.clustered and found.value == pytest.approx(guess, abs=1e-14)


def test_what_is_no_multiplier_is_dropped():
    assert refine(MapCharacteristic(np.array([[0.0, 1.0], [0.0, 0.0]])), 0.1 + 0j) is None


def test_the_vector_is_that_of_the_nearest():
    characteristic = make_map()
    vector = find_vector(characteristic, 0.69)
    assert characteristic.map @ vector == pytest.approx(0.7 * vector, abs=1e-12)
    assert np.max(np.abs(vector)) == pytest.approx(1.0)


@pytest.mark.parametrize("value", [0.85, -0.37])
def test_a_state_that_nothing_else_acts_on_has_its_multiplier(value):
    """Its row of the characteristic matrix has one entry, which is the one that vanishes."""
    found = refine(MapCharacteristic(np.diag([0.85, -0.37, 0.05])), complex(value * 1.001))
    assert found.value == pytest.approx(value, rel=1e-13)
