"""Products and exponentials of jets against derivatives that are known."""

import numpy as np

from pddecont.equilibrium.jets import list_partitions, make_decay, multiply


def test_partitions_are_counted_by_bell_numbers():
    assert [len(list_partitions(mask)) for mask in (0, 1, 3, 7, 15)] == [1, 1, 2, 5, 15]
    assert {tuple(sorted(parts)) for parts in list_partitions(7)} == {(7,), (1, 6), (2, 5), (3, 4), (1, 2, 4)}


def test_a_product_leaves_out_squares():
    """(1 + 2 e1)(3 + e1 + 5 e2) = 3 + 7 e1 + 5 e2 + 10 e1 e2."""
    found = multiply(np.array([1, 2, 0, 0], complex), np.array([3, 1, 5, 0], complex))
    assert found.tolist() == [3, 7, 5, 10]


def test_the_exponential_of_a_sum_is_the_product_of_exponentials():
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(2, 8)) + 1j * rng.normal(size=(2, 8))
    a[0] = b[0] = 0.0
    root = 0.3 + 1.7j
    together, apart = make_decay(root, a + b), multiply(make_decay(root, a), make_decay(root, b))
    assert np.allclose(together, apart, rtol=1e-14)
    # exp(-r (e1 + e2 + e3)) has the coefficient (-r)^k of each product of k of them.
    one = make_decay(root, np.array([0, 1, 1, 0, 1, 0, 0, 0], complex))
    assert np.allclose(one, [(-root) ** bin(mask).count("1") for mask in range(8)], rtol=1e-15)
