"""Rotation numbers of motions whose rotation numbers are known."""

import numpy as np
import pytest

from pddecont.exploration import find_rotation_number

SCALE = np.array([2.0, 200.0, 10.0])
GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)


def on_a_curve(rho, n, wobble=0.0):
    """Return points of a curve in three states, on which a turn of ``rho`` becomes one that wobbles."""
    phase = 2 * np.pi * rho * np.arange(n) + 0.3
    angle = phase + wobble * np.sin(phase)
    size = 1.0 + 0.2 * np.cos(3 * angle)
    return np.column_stack([5 + size * np.cos(angle), 100 * size * np.sin(angle), np.full(n, 7.0)])


# The last is so near to 1/2 that the returns beat only four times.
@pytest.mark.parametrize(
    ("rho", "error"), [(GOLDEN, 1e-8), (np.sqrt(2.0) - 1, 1e-8), (0.013 * np.pi, 1e-8), (0.5 - 0.001 * np.e, 1e-5)]
)
@pytest.mark.parametrize("wobble", [0.0, 0.6])
def test_the_rotation_of_a_curve_is_found(rho, error, wobble):
    found = find_rotation_number(on_a_curve(rho, 800, wobble), SCALE)
    assert found.value == pytest.approx(min(rho, 1 - rho), abs=error)
    assert abs(found.value - min(rho, 1 - rho)) <= found.error + 1e-12


def test_more_returns_give_more_digits():
    errors = [abs(find_rotation_number(on_a_curve(GOLDEN, n, 0.6), SCALE).value - (1 - GOLDEN)) for n in (100, 400)]
    assert errors[1] < 1e-2 * errors[0]


@pytest.mark.parametrize(("p", "q"), [(1, 3), (2, 5), (3, 7), (1, 11)])
def test_a_periodic_motion_has_a_fraction(p, q):
    found = find_rotation_number(on_a_curve(p / q, q, 0.4), SCALE, is_periodic=True)
    assert (found.value, found.error) == (pytest.approx(p / q, abs=1e-15), 0.0)


@pytest.mark.parametrize(
    "returns",
    [
        np.random.default_rng(1).uniform(size=(400, 2)),
        np.tile([1.0, 2.0], (400, 1)),
        np.outer(np.sin(np.arange(400.0)), [1.0, 2.0]),
        on_a_curve(GOLDEN, 20),
        1e-7 * on_a_curve(GOLDEN, 400),
    ],
    ids=["cloud", "point", "line", "few", "small"],
)
def test_what_does_not_go_round_a_curve_has_none(returns):
    assert find_rotation_number(returns, np.ones(returns.shape[1])) is None
