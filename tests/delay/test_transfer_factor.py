"""What ways to discretise a delay do to exponentials."""

import cmath

import numpy as np
import pytest

from pddecont.delay import Chain, Chebyshev, Direct, find_transfer_factor

VALUES = [0.0, 0.3, -0.7 + 0.2j, 2.0j, 1.0 - 3.0j]


@pytest.mark.parametrize("s", VALUES)
def test_the_delay_itself_is_an_exponential(s):
    assert find_transfer_factor(Direct(), s) == (cmath.exp(-s), -cmath.exp(-s))


@pytest.mark.parametrize("s", VALUES)
@pytest.mark.parametrize(("order", "n"), [(1, 20), (2, 7), (3, 5)])
def test_a_chain_is_a_power_of_one_taylor_step(s, order, n):
    """A stage obeys sum_k u^(k) delta^k / k! = q, so exp(lambda t) comes out divided by the Taylor polynomial."""
    z = s / n
    step = sum(z**k / np.prod(np.arange(1, k + 1)) for k in range(order + 1))
    assert find_transfer_factor(Chain(order, n), s)[0] == pytest.approx(step**-n, abs=1e-13)


@pytest.mark.parametrize("s", VALUES)
def test_a_long_chebyshev_line_is_the_delay(s):
    assert find_transfer_factor(Chebyshev(24), s)[0] == pytest.approx(cmath.exp(-s), abs=1e-12)


@pytest.mark.parametrize("method", [Direct(), Chain(2, 9), Chain(3, 4), Chebyshev(8)])
@pytest.mark.parametrize("s", VALUES)
def test_the_derivative_is_that_of_the_factor(method, s):
    h = 1e-5
    ends = [find_transfer_factor(method, s + sign * h)[0] for sign in (-1.0, 1.0)]
    assert find_transfer_factor(method, s)[1] == pytest.approx((ends[1] - ends[0]) / (2 * h), abs=1e-8)
