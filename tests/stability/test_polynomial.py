"""Multipliers of orbits without memory, however far apart, against products that are known."""

from dataclasses import dataclass

import numpy as np
import pytest

from pddecont.stability.polynomial import find_outside

STEPS = 40


@dataclass
class Cycle:
    """A linear motion in steps, x_{k+1} = A_k x_k, of which the last leads to the next period."""

    steps: np.ndarray
    depth: int = 1

    @property
    def size(self):
        return self.steps.shape[0] * self.steps.shape[1]

    def matrix(self, z):
        (n, d, _), z = self.steps.shape, z if np.imag(z) else np.real(z)
        result = np.eye(n * d) * (1.0 + 0.0 * z)
        for k, step in enumerate(self.steps):
            before = (k - 1) % n
            rows, columns = slice(k * d, (k + 1) * d), slice(before * d, (before + 1) * d)
            result[rows, columns] -= (z if k == 0 else 1.0) * step
        return result

    def row_sizes(self, z):
        return np.max(np.abs(self.matrix(abs(z) + 0.0)), axis=1)


def make_cycle(multipliers, seed=1):
    """Return steps whose product has these multipliers (pairs upper one first), in directions that turn."""
    rng, d = np.random.default_rng(seed), len(multipliers)
    turns = [np.linalg.qr(rng.standard_normal((d, d)))[0] for _ in range(STEPS)]
    root = np.zeros((d, d))
    i = 0
    while i < d:
        value = complex(multipliers[i])
        if value.imag:
            part = value ** (1.0 / STEPS)
            root[i : i + 2, i : i + 2] = [[part.real, -part.imag], [part.imag, part.real]]
            i += 2
        else:
            root[i, i] = abs(value.real) ** (1.0 / STEPS)
            i += 1
    steps = []
    for k in range(STEPS):
        signs = np.array([-1.0 if k == 0 and complex(m).real < 0 and not complex(m).imag else 1.0 for m in multipliers])
        upper = root * signs + np.triu(0.1 * rng.standard_normal((d, d)), 2)
        steps.append(turns[k] @ upper @ turns[k - 1].T)
    return Cycle(np.array(steps))


def get_leading(multipliers):
    """Return the leading multiplier, or pair."""
    return np.array(multipliers[: 2 if complex(multipliers[0]).imag else 1], dtype=complex)


@pytest.mark.parametrize(
    "multipliers",
    [
        [2.0, 0.5],
        [-3e5, 1e-9],
        [5e15, 1e-12],
        [1e28, -1e12],
        [4e9, 0.3, 1e-6],
        [2e20, 3.0 + 2.0j, 3.0 - 2.0j],
        [-1e9, 1e8, 0.9, 1e-14],
        [0.5j, -0.5j, 1e-8],
    ],
)
def test_all_outside_are_found_to_many_digits(multipliers):
    cycle = make_cycle(multipliers)
    for radius in (1e-3, 0.05):
        known = sorted((complex(m) for m in multipliers if abs(m) > radius), key=lambda m: (-abs(m), -m.imag))
        found = find_outside(cycle, len(multipliers), radius, get_leading(multipliers))
        assert found is not None
        assert len(found) == len(known)
        # A multiplier is told from a circle up to 1e4 times smaller.
        assert found == pytest.approx(np.array(known), rel=1e-7)


def test_where_rounding_may_hide_them_nothing_wrong_is_said():
    multipliers = [3e37, 2e22, -7e12, 4e3, 1e-9]
    found = find_outside(make_cycle(multipliers), 5, 1e-3, get_leading(multipliers))
    assert found is None or found == pytest.approx(np.array(multipliers[:4]), rel=1e-7)


def test_more_dimensions_than_there_are_do_no_harm():
    found = find_outside(make_cycle([3.0, 0.4]), 5, 0.1, get_leading([3.0]))
    assert found == pytest.approx(np.array([3.0, 0.4]), rel=1e-10)


def test_one_on_the_circle_is_not_told():
    assert find_outside(make_cycle([3.0, 0.5]), 2, 0.5, get_leading([3.0])) is None


def test_without_any_outside_there_is_none():
    assert len(find_outside(make_cycle([1e-5, 1e-7]), 2, 1e-3, get_leading([1e-5]))) == 0
