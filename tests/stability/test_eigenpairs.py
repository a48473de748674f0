"""The multipliers of an orbit that remembers one period: all outside a circle, or none said to be known."""

from dataclasses import dataclass
from functools import cached_property
from types import SimpleNamespace

import mpmath
import numpy as np
import pytest

from pddecont.stability import eigenpairs, find_multipliers
from pddecont.stability import multipliers as module_of_multipliers
from pddecont.stability.eigenpairs import FEW, LARGE, SHORT, find_all_outside, find_few, find_inside
from tests.known_orbits import hard_wall, impact_oscillator


@dataclass
class MapOnly:
    """A linear map as an orbit's map has it, nothing else of one."""

    scaled_matrix: np.ndarray
    kept: tuple = (None,)

    @property
    def problem(self):
        return SimpleNamespace(unknowns=SimpleNamespace(n_states=2))

    @property
    def size(self):
        return len(self.scaled_matrix)

    @cached_property
    def history_sizes(self):
        return np.logspace(-3, 3, self.size)

    def step(self, histories):
        sizes = self.history_sizes[:, None]
        return None, sizes * (self.scaled_matrix @ (histories / sizes))

    def apply_scaled(self, history):
        return self.scaled_matrix @ history


def map_with(values, n, seed=0, shear=1.0):
    """Return a map with some eigenvalues, the others below 0.3, of vectors that are far from orthogonal."""
    rng = np.random.default_rng(seed)
    diagonal = np.concatenate([values, rng.uniform(-0.3, 0.3, n - len(values))])
    upper = np.diag(diagonal) + shear * np.triu(rng.standard_normal((n, n)), 1) / n
    q, _ = np.linalg.qr(rng.standard_normal((n, n)))
    return q @ upper @ q.T


@pytest.mark.parametrize("n", [40, SHORT + 100])
def test_eigenvalues_come_with_small_residuals(n):
    given = [-2.5, 1.01, 0.97, 0.6]
    found = find_all_outside(MapOnly(map_with(given, n)), 8, 0.95)
    assert [m.value.real for m in found[:4]] == pytest.approx(given, abs=1e-12)
    assert all(m.residual < 1e-12 for m in found)


def test_those_that_are_too_small_are_left_out_but_one():
    small = MapOnly(map_with([0.9, 0.5, 1e-4], 3))
    assert [m.value.real for m in find_all_outside(small, 8, 0.95, 1e-3)] == pytest.approx([0.9, 0.5], abs=1e-12)
    assert [m.value.real for m in find_all_outside(small, 8, 0.95, 2.0)] == pytest.approx([0.9], abs=1e-12)
    (none,) = find_all_outside(MapOnly(np.zeros((5, 5))), 8, 0.95, 1e-3)
    assert (none.value, none.residual) == (0.0, 0.0)


@pytest.mark.parametrize("values", [[-2.0, 0.5], [1.0, 1.0, -0.3], []])
def test_a_map_is_looked_at_where_it_leads(values):
    """Most of a history is forgotten after one period or after two: what is left is as large as its multipliers."""
    n, k = 40, len(values)
    upper = np.diag([*values, *np.zeros(n - k)])
    upper[:k, k:] = 1.0
    upper[k : k + 8, k + 8 : k + 16] = np.eye(8)
    matrix = np.roll(upper, (7, 7), (0, 1))
    basis, inside = find_inside(matrix)
    assert len(inside) <= max(1, k) + 2
    assert basis.T @ basis == pytest.approx(np.eye(len(inside)), abs=1e-14)
    assert matrix @ basis == pytest.approx(basis @ inside, abs=1e-13)
    found = np.linalg.eigvals(inside)
    leading = np.sort(found[np.argsort(-np.abs(found))][:k].real)
    assert leading == pytest.approx(np.sort(values), abs=1e-13)


def test_a_map_that_forgets_nothing_is_looked_at_as_it_is():
    matrix = map_with([1.5, -0.7], 9)
    basis, inside = find_inside(matrix)
    assert inside is matrix and np.array_equal(basis, np.eye(9))


def test_a_small_multiplier_beside_large_entries_keeps_its_digits():
    """A map as it is near grazing; mpmath tells what multipliers it has."""
    matrix = np.array(
        [[-230.43, -230.43, 42.32, -36.507], [1, 1, 0, 0], [0, 0, 0, 0], [-1008.873, -1008.873, 186.61, -160.5347]]
    )
    with mpmath.workdps(40):
        exact = sorted((complex(v) for v in mpmath.eig(mpmath.matrix(matrix.tolist()))[0]), key=abs, reverse=True)
    found = find_all_outside(MapOnly(matrix), 4, 0.95)
    assert abs(exact[1]) < 1e-5 * abs(exact[0])
    assert [m.value for m in found][:2] == pytest.approx(exact[:2], rel=1e-9)


def forgetful_map(values, n=80, rest=1e-8):
    """Return a map with some eigenvalues, all others no larger than ``rest``, and the pair 0.3 +- 0.4i besides."""
    rng = np.random.default_rng(3)
    matrix = np.diag(np.concatenate([[0.3, 0.3], values, rest * rng.uniform(-1, 1, n - 2 - len(values))]))
    matrix[0, 1], matrix[1, 0] = 0.4, -0.4
    leading = 2 + len(values)
    matrix[:leading] += np.triu(rng.standard_normal((n, n)), 2)[:leading] / n
    q, _ = np.linalg.qr(rng.standard_normal((n, n)))
    return q @ matrix @ q.T


@pytest.mark.parametrize("values", [[], [1.7, -0.9], [0.9, 0.02, -2e-3, 1.5e-4]])
def test_few_multipliers_are_found_where_the_map_leads(values):
    """Those given, in order, down to the least that is asked for, by vectors of the map; so says the whole map."""
    matrix, least = forgetful_map(values), 1e-3
    found, vectors = find_few(matrix, least)
    given = sorted([0.3 + 0.4j, 0.3 - 0.4j, *(v for v in values if abs(v) >= least)], key=abs, reverse=True)
    assert np.abs(found) == pytest.approx(np.abs(given), abs=1e-14)
    assert np.sort_complex(found) == pytest.approx(np.sort_complex(np.array(given)), abs=1e-14)
    assert matrix @ vectors == pytest.approx(vectors * found, abs=1e-13)
    listed = find_all_outside(MapOnly(matrix), 8, 0.95, least)
    assert [m.value for m in listed] == pytest.approx(found.tolist(), abs=1e-14)


@pytest.mark.parametrize(
    "matrix",
    [
        forgetful_map([0.5] * FEW),
        forgetful_map([], rest=0.9e-3),
        forgetful_map([]) * 1e-4,
        forgetful_map([]) * 10.0 * LARGE,
        map_with([2.0, 0.9], 80),
        np.diag(np.full(79, 1.0), 1),
    ],
    ids=["many", "others beside them", "none", "large", "slow", "shift"],
)
def test_where_few_directions_do_not_tell_the_whole_map_does(matrix):
    assert find_few(matrix, 1e-3) is None


def test_what_remembers_more_than_a_period_is_left_to_others():
    assert find_all_outside(MapOnly(map_with([1.5], 20), kept=(None, None)), 8, 0.95) is None


def test_a_map_that_is_not_finite_is_left_to_others():
    matrix = map_with([1.5], 20)
    matrix[3, 4] = np.inf
    assert find_all_outside(MapOnly(matrix), 8, 0.95) is None


@pytest.mark.parametrize("hidden", [1.2, 0.96, -3.0])
def test_a_list_that_lacks_one_is_refused(monkeypatch, hidden):
    """As Arnoldi's method does of several that coincide, one is left out of what it finds."""
    matrix = map_with([2.0, hidden], SHORT + 40)
    values, vectors = np.linalg.eig(matrix)
    keep = np.argsort(-np.abs(values))[:9]
    keep = keep[np.abs(values[keep] - hidden) > 1e-9]
    monkeypatch.setattr(eigenpairs, "find_eigenpairs", lambda *_: (values[keep], vectors[:, keep]))
    assert find_all_outside(MapOnly(matrix), 8, 0.95) is None


def test_more_than_are_asked_for_outside_the_circle_are_not_called_all():
    assert find_all_outside(MapOnly(map_with([1.1] * 12, SHORT + 40, shear=0.0)), 8, 0.95) is None


@pytest.mark.parametrize(("n", "factor"), [(60, 10.0), (8, 1e4)])
def test_a_history_that_is_only_shifted_and_magnified_tells_nothing(n, factor):
    """All multipliers are zero; with a perturbation by rounding they lie far outside the unit circle."""
    shift = np.diag(np.full(n - 1, factor), 1)
    q, _ = np.linalg.qr(np.random.default_rng(1).standard_normal((n, n)))
    matrix = q @ shift @ q.T
    assert np.max(np.abs(np.linalg.eigvals(matrix))) > 1.0
    assert find_all_outside(MapOnly(matrix), 8, 0.95) is None


@pytest.mark.parametrize("settle", [impact_oscillator, hard_wall])
def test_they_are_those_of_the_characteristic_matrix(monkeypatch, settle):
    """The same orbit's multipliers, corrected on the characteristic matrix and counted there."""
    orbit = settle()
    found = find_multipliers(orbit)
    monkeypatch.setattr(module_of_multipliers, "find_all_outside", lambda *_: None)
    other = find_multipliers(orbit)
    n = min(len(found.values), len(other.values))
    assert found.counted and other.counted
    assert np.sort_complex(found.values[:n]) == pytest.approx(np.sort_complex(other.values[:n]), abs=1e-9)
