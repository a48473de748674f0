"""Integrals over lags against closed forms."""

import cmath
import math

import numpy as np
import pytest

from pddecont.equilibrium.quadrature import find_panels, integrate, make_points
from pddecont.errors import ConvergenceError


def one(function):
    """Return a kernel of one function."""
    return lambda s: function(s)[None]


@pytest.mark.parametrize(
    ("function", "low", "high", "exact"),
    [
        (np.ones_like, 0.0, 1.0, 1.0),
        (np.exp, -1.0, 2.0, math.exp(2) - math.exp(-1)),
        (lambda s: s**3 * np.exp(-5 * s), 0.0, 40.0, 6 / 5**4),
        (lambda s: np.exp(-(((s - 5) / 0.01) ** 2)), 0.0, 10.0, 0.01 * math.sqrt(math.pi)),
        (lambda s: np.abs(s - 0.3), 0.0, 1.0, (0.09 + 0.49) / 2),
        (np.sqrt, 0.0, 1.0, 2 / 3),
        (lambda s: 1 / np.sqrt(s), 0.0, 1.0, 2.0),
        (np.log, 0.0, 1.0, -1.0),
        (np.exp, 1.0, 0.0, 1 - math.e),
        (np.exp, 1.0, 1.0, 0.0),
    ],
)
def test_integrals_are_those_of_closed_forms(function, low, high, exact):
    """To 5e-15: smooth ones, a narrow peak, a kink, weak singularities, limits the other way round."""
    assert integrate(one(function), low, high)[0] == pytest.approx(exact, rel=5e-15, abs=1e-300)


@pytest.mark.parametrize("rate", [0.0, 3.0, 50.0, 1e3, 1e4])
def test_points_are_enough_for_an_exponential(rate):
    """The error is that of the rounding of its argument."""
    edges = np.array([0.2, 1.0, 1.7])
    points, weights = make_points(edges, rate)
    for root in (1j * rate, rate + 0j, rate * cmath.exp(1j)):
        exact = (cmath.exp(-0.2 * root) - cmath.exp(-1.7 * root)) / root if root else 1.5
        size = max(1.0, 1.5 * abs(cmath.exp(-0.2 * root)))
        assert abs(np.exp(-root * points) @ weights - exact) < 1e-15 * size * (1.0 + rate / 50)


def test_several_functions_share_their_panels():
    kernel = lambda s: np.stack([np.ones_like(s), np.abs(s - 0.3)])  # noqa: E731
    assert np.allclose(integrate(kernel, 0.0, 2.0), [2.0, 0.045 + 1.445], rtol=1e-15)
    assert len(find_panels(kernel, 0.0, 2.0)) > 10


@pytest.mark.parametrize("function", [lambda s: 1 / s, lambda s: s**-1.5, lambda s: 1 / (s - 0.5)])
def test_where_there_is_no_integral_it_is_said(function):
    with np.errstate(all="ignore"), pytest.raises(ConvergenceError, match="no finite value"):
        integrate(one(function), 0.0, 1.0)
