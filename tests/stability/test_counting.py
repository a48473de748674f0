"""Counts outside a circle, and where those are that a list lacks."""

from types import SimpleNamespace

import numpy as np
import pytest

from pddecont.errors import ConvergenceError
from pddecont.stability.characteristic import MapCharacteristic, PeriodCharacteristic
from pddecont.stability.counting import MORE_DETERMINANTS, MOST_DETERMINANTS, Counter

PAIR = 0.9 * np.exp(0.4j)
VALUES = np.array([1.5, -1.1, PAIR, PAIR.conjugate(), 0.3, 0.02])


def counter():
    rng = np.random.default_rng(0)
    blocks = np.diag([1.5, -1.1, 0.0, 0.0, 0.3, 0.02])
    blocks[2:4, 2:4] = [[PAIR.real, -PAIR.imag], [PAIR.imag, PAIR.real]]
    vectors = rng.normal(size=(6, 6))
    return Counter(MapCharacteristic(vectors @ blocks @ np.linalg.inv(vectors)))


@pytest.mark.parametrize("radius", [1.3, 1.0, 0.5, 0.1])
def test_without_a_list_all_outside_the_circle_are_counted(radius):
    assert counter().count_missing(np.zeros(0), radius) == np.sum(np.abs(VALUES) > radius)


@pytest.mark.parametrize("gone", [[0], [1], [2, 3], [0, 1], [0, 2, 3]])
def test_what_a_list_lacks_is_counted_and_found(gone):
    listed = np.delete(VALUES, gone)
    assert counter().count_missing(listed, 0.6) == len(gone)
    found = counter().find_missing(listed, 0.6)
    for value in VALUES[gone]:
        assert value.imag < 0 or np.min(np.abs(found - value)) < 1e-9


@pytest.mark.parametrize("n", [7, 8, 9, 16, 32, 100])
@pytest.mark.parametrize("radius", [1e-3, 0.05])
def test_many_far_outside_are_seen_though_they_turn_by_whole_turns_between_neighbours(n, radius):
    """At first points lie an eighth of a turn apart: of 8 multipliers each makes as much of one."""
    values = np.linspace(0.4, 2.0, n)
    for listed in (values[:0], values[8:], values[:1]):
        assert 0 < Counter(MapCharacteristic(np.diag(values))).count_missing(listed, radius) <= n - len(listed)
    assert Counter(MapCharacteristic(np.diag(values))).count_missing(values, radius) == 0


def test_what_a_list_holds_and_is_none_counts_less():
    assert counter().count_missing(np.append(VALUES, 1.2), 0.6) == -1


def test_a_circle_through_a_multiplier_has_no_count():
    assert counter().count_missing(np.zeros(0), 1.5) is None


@pytest.mark.parametrize("depth", [7, 50])
def test_histories_of_many_periods_crowd_the_circle_and_all_are_counted(depth):
    """1 - z^depth / 2: so many multipliers of modulus 2^(-1/depth)."""
    zeros = np.zeros(2, dtype=int)
    characteristic = PeriodCharacteristic(1, zeros, zeros, np.array([0, depth]), np.array([1.0, -0.5]))
    modulus = 0.5 ** (1 / depth)
    assert Counter(characteristic).count_missing(np.zeros(0), 0.99 * modulus) == depth
    assert Counter(characteristic).count_missing(np.zeros(0), 1.01 * modulus) == 0
    found = Counter(characteristic).find_missing(np.zeros(0), 0.99 * modulus)
    assert len(found) == depth // 2 + 1 and np.abs(found) == pytest.approx(np.full(len(found), modulus), rel=1e-9)


class Noisy(Counter):
    """A quotient that is known to so many digits only."""

    def __init__(self, missing, noise):
        super().__init__(SimpleNamespace(depth=1))
        self.missing, self.noise, self.random, self.asked = missing, noise, np.random.default_rng(1), 0

    def _at(self, angle, listed, radius):
        self.asked += 1
        z = complex(np.exp(1j * angle)) / radius
        return complex(np.sum(np.log(1.0 - z * self.missing))) + self.noise * self.random.standard_normal()


def test_rounding_in_the_determinant_is_no_multiplier():
    """With relative errors of 1e-8 the four are found to about that, and nothing is asked two thousand times."""
    missing = np.array([0.9, -0.5, 0.3 + 0.4j, 0.3 - 0.4j])
    counter = Noisy(missing, 1e-8)
    found = counter.find_missing(np.zeros(0), 0.3)
    assert counter.asked < 100
    for value in (0.9, -0.5, 0.3 + 0.4j):
        assert np.min(np.abs(found - value)) < 1e-5
    assert np.sum(np.abs(found) > 0.3) == 3


def test_a_determinant_that_is_all_rounding_tells_nothing():
    with pytest.raises(ConvergenceError, match="not known well enough"):
        Noisy(np.array([0.5]), 1.0).find_missing(np.zeros(0), 0.3)


def test_a_count_that_rounding_decides_ends():
    """Values 20 orders apart: rounding of the largest hides the others, and halving the circle's parts never ends."""
    noise = np.random.default_rng(3)

    class Noisy(Counter):
        def _log_determinant(self, z):
            known = len(self._known)
            exact = super()._log_determinant(z)
            if len(self._known) > known:
                self._known[z] = exact + complex(0.0, noise.uniform(-3.0, 3.0))
            return self._known[z]

    noisy = Noisy(MapCharacteristic(np.diag([1e18, 1e-2])))
    with pytest.raises(ConvergenceError, match="does not tell how many multipliers"):
        for radius in np.geomspace(1e-3, 1e3, 10_000):
            noisy.count_missing(np.zeros(0), float(radius))
    assert len(noisy._known) == MOST_DETERMINANTS + MORE_DETERMINANTS
