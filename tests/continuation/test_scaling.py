"""Lengths in scaled unknowns."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.continuation import Scaling

numbers = st.floats(-10.0, 10.0)
positive = st.floats(0.01, 100.0)
scalings = st.integers(1, 5).flatmap(
    lambda n: st.tuples(
        *(st.lists(e, min_size=n, max_size=n).map(np.array) for e in (positive, positive, numbers, numbers))
    )
)


@settings(max_examples=50, deadline=None, derandomize=True)
@given(scalings)
def test_the_inner_product_is_the_weighted_sum(case):
    scale, weight, a, b = case
    scaling = Scaling(scale, weight)
    expected = math.fsum(w * (x / s) * (y / s) for s, w, x, y in zip(scale, weight, a, b, strict=True))
    bound = 1e-12 * math.fsum(w * abs(x * y) / s**2 for s, w, x, y in zip(scale, weight, a, b, strict=True))
    assert scaling.dot(a, b) == pytest.approx(expected, rel=0, abs=bound + 1e-300)
    assert float(scaling.covector(a) @ b) == pytest.approx(expected, rel=0, abs=bound + 1e-300)
    assert scaling.length(a) ** 2 == pytest.approx(scaling.dot(a, a), rel=1e-12)


@settings(max_examples=50, deadline=None, derandomize=True)
@given(scalings)
def test_one_unknown_alone_moves_by_its_size_in_a_length_of_one(case):
    scale, weight, a, _ = case
    scaling = Scaling(scale, weight)
    for k, size in enumerate(scaling.size):
        assert scaling.length(size * np.eye(len(scale))[k]) == pytest.approx(1.0, rel=1e-12)
    if scaling.length(a) > 1e-100:
        unit = scaling.normalise(a)
        assert scaling.length(unit) == pytest.approx(1.0, rel=1e-12)
        assert unit * scaling.length(a) == pytest.approx(a, rel=1e-12)
