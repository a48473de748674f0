"""The two kinds of weights that delayed values are made with."""

from dataclasses import replace

import numpy as np
import pytest

from pddecont.delay import FullWeights, LocalWeights

LOCAL = LocalWeights(
    np.array([[0, 1], [2, 3], [1, 2]]),
    np.array([[0.5, 0.5], [1.0, 0.0], [2.0, -1.0]]),
    np.array([0, 2, 1]),
    np.array([0.5, 0.0, -1.0]),
    np.array([0, 1, 0]),
)


def full(weights, n):
    """Return local weights as a full matrix."""
    matrix = np.zeros((len(weights.weights), n))
    np.add.at(matrix, (np.arange(len(matrix))[:, None], weights.columns), weights.weights)
    return FullWeights(matrix)


def test_local_weights_are_a_sparse_matrix():
    values = np.array([[1.0, 10.0], [3.0, 20.0], [5.0, 40.0], [7.0, 80.0]])
    exact = np.array([[2.0, 15.0], [5.0, 40.0], [1.0, 0.0]])
    assert LOCAL.apply(values) == pytest.approx(exact)
    assert full(LOCAL, 4).apply(values) == pytest.approx(exact)


def test_reads_are_the_same_where_intervals_and_turns_are():
    assert LOCAL.reads_as(LOCAL)
    assert LOCAL.reads_as(replace(LOCAL, columns=LOCAL.columns.copy(), wraps=LOCAL.wraps.copy()))
    # Weights move with the unknowns, what is read does not.
    assert LOCAL.reads_as(replace(LOCAL, weights=2 * LOCAL.weights))
    assert not LOCAL.reads_as(replace(LOCAL, columns=LOCAL.columns + 1))
    assert not LOCAL.reads_as(replace(LOCAL, wraps=LOCAL.wraps + 1))


def test_amplification_is_the_most_that_an_error_can_grow():
    matrix = np.random.default_rng(0).normal(size=(6, 9))
    weights = FullWeights(matrix)
    worst = np.argmax(np.sum(np.abs(matrix), axis=1))
    error = np.sign(matrix[worst])[:, None]
    assert np.max(np.abs(weights.apply(error))) == pytest.approx(weights.amplification)
    assert FullWeights(np.zeros((0, 9))).amplification == 0.0
