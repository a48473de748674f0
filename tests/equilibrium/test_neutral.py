"""How strong rates of the past are."""

import numpy as np
import pytest

from pddecont.delay import Direct
from pddecont.equilibrium import CharacteristicMatrix, find_roots
from pddecont.equilibrium.neutral import find_neutral_radius

TURNING = np.array([[0.3, 2.0], [-0.2, 0.1]])


def test_coefficients_of_one_state_add_up_whatever_their_signs():
    parts = [np.array([[c]]) for c in (0.4, -0.3, 0.2)]
    assert find_neutral_radius(parts, [1.0, 2.0, 5.0]) == pytest.approx(0.9, abs=1e-15)
    assert find_neutral_radius(parts, [1.0, 1.0, 5.0]) == pytest.approx(0.3, abs=1e-15)
    assert find_neutral_radius([], []) == 0.0


def test_of_one_delay_it_is_the_spectral_radius():
    assert find_neutral_radius([TURNING], [1.0]) == pytest.approx(np.max(np.abs(np.linalg.eigvals(TURNING))), rel=1e-15)


def test_phases_of_several_delays_are_independent():
    """No phase on a fine grid gives more, and one gives as much."""
    other = np.array([[0.1, -0.3], [0.2, 0.2]])
    angles = np.linspace(0, 2 * np.pi, 20_001)
    radii = np.max(np.abs(np.linalg.eigvals(TURNING + np.exp(1j * angles)[:, None, None] * other)), axis=1)
    assert find_neutral_radius([TURNING, other], [1.0, 2.3]) == pytest.approx(np.max(radii), abs=1e-6)
    assert find_neutral_radius([TURNING, other], [1.0, 2.3]) >= np.max(radii) - 1e-12


def test_roots_are_counted_where_moduli_alone_would_not_bound_them():
    """rho(N) < 1 < rho(|N|)."""
    strong = 1.3 * TURNING
    assert np.max(np.abs(np.linalg.eigvals(strong))) < 1 < np.max(np.abs(np.linalg.eigvals(abs(strong))))
    present, through = np.array([[0.2, 0.5], [0.3, -2.0]]), np.array([[0.2, 0.5], [-0.7, 0.1]])
    matrix = CharacteristicMatrix(
        present, (strong, through), np.array([1.0, 1.0]), Direct(), np.array([1, 0], dtype=np.intp)
    )
    roots = find_roots(matrix)
    assert roots.counted and np.max(np.abs(roots.values[roots.values.real > 0])) < matrix.bound < np.inf
    assert roots.neutral_radius == pytest.approx(1.3 * 0.6557438524302, rel=1e-12)


def test_without_rates_nothing_is_said():
    assert find_roots(CharacteristicMatrix(TURNING, (), np.zeros(0), Direct())).neutral_radius == 0.0
