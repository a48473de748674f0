"""Roots of models that read the past by delays that vary, as rates and as integrals, all at once."""

import numpy as np
import pytest

from pddecont.equilibrium import find_roots
from tests.equilibrium.mixed_systems import (
    MIXED,
    MOTION,
    bound_roots,
    correct_root,
    count_unstable,
    draw,
    find_determinant,
    linearise,
)


@pytest.mark.parametrize("seed", range(20))
def test_the_matrix_is_that_of_pen_and_paper(seed):
    p, matrix = draw(seed), linearise(draw(seed))
    rng = np.random.default_rng(seed)
    roots = rng.normal(size=40) * 3 + 1j * rng.uniform(0, 30, size=40)
    for z, many in zip(roots.tolist(), matrix.at_many(roots)[0], strict=True):
        exact = find_determinant(p, z)
        size = np.prod(np.sum(np.abs(matrix.at(z)[0]), axis=1))
        assert abs(np.linalg.det(matrix.at(z)[0]) - exact) < 1e-13 * size
        assert abs(np.linalg.det(many) - exact) < 1e-13 * size


@pytest.mark.parametrize("seed", range(6))
def test_its_derivative_is_that_in_lambda(seed):
    matrix, h = linearise(draw(seed)), 1e-6
    for root in (0.3 + 2.1j, -0.4 + 9j, 0.0):
        slope = (matrix.at(root + h)[0] - matrix.at(root - h)[0]) / (2 * h)
        assert np.allclose(matrix.at(root)[1], slope, atol=1e-8 * np.max(np.abs(slope)))


@pytest.mark.parametrize("seed", range(15))
def test_no_unstable_root_is_missed(seed):
    check(seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(15, 300))
def test_no_unstable_root_is_missed_in_more_systems(seed):
    check(seed)


def check(seed):
    """Compare roots with zeros in many digits, and their count with that of a contour integral."""
    p = draw(seed)
    roots, bound = find_roots(linearise(p)), bound_roots(p)
    assert roots.counted
    assert np.all(np.abs(roots.values[roots.values.real > 0]) <= bound)
    assert roots.n_unstable == count_unstable(p, 1.1 * bound)
    for z in roots.values[:8].tolist():
        assert abs(correct_root(p, z) - z) < 1e-11 * (1 + abs(z))


@pytest.mark.parametrize("seed", range(8))
def test_derivatives_of_the_field_at_rest_are_those_of_differences(seed):
    """In states and in all parameters, away from zero: to 1e-8, the error of central differences."""
    p = np.array(list(draw(seed).values()))
    x, h = np.array([0.13, -0.07]), 1e-5
    free = tuple(range(len(p)))
    value, in_x, in_p = MOTION.differentiate(x, p, free)
    assert np.allclose(value, MOTION.rate(x, p), rtol=1e-15, atol=1e-16)
    for column in range(2):
        ends = [MOTION.rate(x + sign * h * np.eye(2)[column], p) for sign in (-1, 1)]
        assert np.allclose(in_x[:, column], (ends[1] - ends[0]) / (2 * h), atol=1e-8 * (1 + np.max(np.abs(in_x))))
    for k, name in enumerate(MIXED["parameters"]):
        ends = [MOTION.rate(x, p + sign * h * np.eye(len(p))[k]) for sign in (-1, 1)]
        assert np.allclose(in_p[:, k], (ends[1] - ends[0]) / (2 * h), atol=1e-8), name


def test_the_derivatives_at_rest_are_the_matrix_at_zero():
    """At lambda = 0 the characteristic matrix is minus the Jacobian of the field at rest."""
    for seed in range(5):
        p = np.array(list(draw(seed).values()))
        x = np.array([0.2, 0.1])
        assert np.allclose(
            MOTION.linearise(x, p).at(0.0)[0], -MOTION.differentiate(x, p, ())[1], rtol=1e-13, atol=1e-14
        )
