"""Entries in places that were found once."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.orbit.sparsity import SparsityPattern


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.tuples(st.integers(1, 6), st.integers(1, 6)), st.integers(0, 30), st.integers(0, 1000))
def test_entries_at_one_place_add_up(shape, n, seed):
    rng = np.random.default_rng(seed)
    rows, columns = rng.integers(0, shape[0], n), rng.integers(0, shape[1], n)
    pattern = SparsityPattern(shape, rows, columns)
    for _ in range(2):
        values = rng.normal(size=n)
        exact = np.zeros(shape)
        np.add.at(exact, (rows, columns), values)
        matrix = pattern.fill(values)
        assert matrix.shape == shape
        assert matrix.toarray() == pytest.approx(exact, abs=1e-14)
        assert pattern.fill_dense(values) == pytest.approx(exact, abs=1e-14)
        # In order, each place once, as a factorisation wants it.
        assert matrix.has_canonical_format
        assert matrix.nnz == len(set(zip(rows.tolist(), columns.tolist(), strict=True)))
