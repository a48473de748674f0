"""How many intervals pieces get, and where: shares, densities, and what an error asks for."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.collocation import (
    MAX_INTERVALS,
    Density,
    Mesh,
    MeshRule,
    cut_pieces,
    equal_cuts,
    has_wanted_intervals,
    interval_density,
    refine_evenly,
)
from pddecont.collocation.mesh_selection import FIRST_INTERVALS, LEAST_CHANGE, MOST_CHANGE, SAFETY, share_intervals
from tests.collocation.meshes import make_pieces, meshes

LENGTHS = st.lists(st.floats(0.01, 100.0), min_size=1, max_size=8)


@settings(max_examples=50, deadline=None, derandomize=True)
@given(LENGTHS, st.integers(0, 40))
def test_intervals_go_where_they_are_longest(lengths, more):
    lengths = np.array(lengths)
    counts = share_intervals(lengths, len(lengths) + more)
    assert np.sum(counts) == len(lengths) + more
    assert np.min(counts) >= 1
    # None could be taken from one piece to shorten the longest interval of another.
    longest, shared = np.max(lengths / counts), counts > 1
    assert np.all((lengths / np.maximum(counts - 1, 1))[shared] >= longest * (1 - 1e-12))


def test_equal_cuts():
    assert [c.tolist() for c in equal_cuts([1, 4])] == [[0, 1], [0, 0.25, 0.5, 0.75, 1]]


@settings(max_examples=50, deadline=None, derandomize=True)
@given(
    widths=st.lists(st.floats(0.1, 2.0), min_size=1, max_size=5),
    heights=st.lists(st.floats(0.1, 30.0), min_size=5, max_size=5),
    ends=st.tuples(st.floats(0.0, 0.45), st.floats(0.55, 1.0)),
)
def test_cuts_share_the_density_equally(widths, heights, ends):
    """Every interval holds the same part of the integral, and no more than one."""
    edges = np.concatenate([[0.0], np.cumsum(widths)])
    density = Density(edges, np.array(heights[: len(widths)]))
    start, end = ends[0] * edges[-1], ends[1] * edges[-1]
    cuts = density.cut(start, end)
    assert (cuts[0], cuts[-1]) == (0.0, 1.0)
    assert np.all(np.diff(cuts) > 0)

    def integral(t):
        inside = np.clip(t, edges[:-1], edges[1:]) - edges[:-1]
        return density.heights @ inside

    shares = np.diff([integral(start + c * (end - start)) for c in cuts])
    assert shares == pytest.approx(np.full(len(shares), shares[0]), rel=1e-9)
    assert shares[0] <= 1 + 1e-9
    # No fewer would do.
    assert len(shares) - 1 < integral(end) - integral(start) + 1e-9 or len(shares) == 1


def test_a_density_beyond_its_edges_goes_on_as_it_ended():
    density = Density(np.array([0.0, 1.0]), np.array([4.0]))
    assert len(density.cut(1.0, 3.0)) - 1 == 8


def test_no_mesh_has_more_intervals_than_the_most():
    assert len(Density(np.array([0.0, 1.0]), np.array([1e9])).cut(0.0, 1.0)) - 1 == MAX_INTERVALS
    assert Density(np.array([0.0, 1.0]), np.array([0.0])).cut(0.0, 1.0).tolist() == [0.0, 1.0]


@settings(max_examples=30, deadline=None, derandomize=True)
@given(found=meshes(), seed=st.integers(0, 1000))
def test_the_density_is_what_each_error_asks_for(found, seed):
    """An interval wants (e / (safety tol))^(1/(m+1)) in its place, within how much it may change at once."""
    mesh, theta = found
    errors = 10.0 ** np.random.default_rng(seed).uniform(-14, -2, mesh.n_intervals)
    density = interval_density(mesh, theta, errors, 1e-7)
    lengths = mesh.length @ theta
    assert np.diff(density.edges) == pytest.approx(lengths)
    wanted = density.heights * lengths
    exact = (errors / (SAFETY * 1e-7)) ** (1 / (mesh.degree + 1))
    assert wanted == pytest.approx(np.clip(exact, LEAST_CHANGE, MOST_CHANGE))


def test_an_error_at_its_aim_keeps_the_mesh():
    mesh, theta = Mesh(4, 1, make_pieces([[[0, 0.2, 0.5, 1]]])), np.array([3.0])
    density = interval_density(mesh, theta, np.full(3, SAFETY * 1e-6 * (1 - 1e-9)), 1e-6)
    assert density.cut(0.0, 3.0) == pytest.approx([0, 0.2, 0.5, 1])
    # 2^(m+1) times the error: half the length.
    density = interval_density(mesh, theta, np.full(3, 32 * SAFETY * 1e-6 * (1 - 1e-9)), 1e-6)
    assert density.cut(0.0, 3.0) == pytest.approx([0, 0.1, 0.2, 0.35, 0.5, 0.75, 1])


def test_the_rule_decides_how_pieces_are_cut():
    pieces, theta = make_pieces([[[0, 1], [0, 1]], [[0, 1]]]), np.array([4.0, 2.0])

    def counts(rule, density=None):
        return [len(piece.cuts) - 1 for piece in cut_pieces(pieces, theta, rule, density)]

    assert counts(MeshRule(4, intervals=6)) == [2, 2, 2]
    assert counts(MeshRule(4, intervals=1)) == [1, 1, 1]
    assert sum(counts(MeshRule(4, tol=1e-6))) == FIRST_INTERVALS
    density = Density(np.array([0.0, 2.0, 6.0]), np.array([5.0, 1.0]))
    assert counts(MeshRule(4, tol=1e-6), density) == [10, 2, 2]
    # A number that is asked for is given, whatever a tolerance once wanted.
    assert counts(MeshRule(4, intervals=6), density) == [2, 2, 2]


@settings(max_examples=30, deadline=None, derandomize=True)
@given(meshes())
def test_a_mesh_with_one_interval_more_in_each_piece(found):
    mesh, theta = found
    finer = refine_evenly(mesh)
    assert finer.n_intervals == mesh.n_intervals + len(mesh.pieces)
    assert np.all(finer.length @ theta > 0)
    for old, new in zip(mesh.pieces, finer.pieces, strict=True):
        assert (new.segment, new.cuts[0], new.cuts[-1]) == (old.segment, 0.0, 1.0)
        # Each old interval's share of the cuts is spread as it was.
        assert np.all(np.interp(new.cuts, old.cuts, np.arange(len(old.cuts))) <= np.arange(len(new.cuts)) + 1e-12)
        assert np.max(np.diff(new.cuts)) <= np.max(np.diff(old.cuts)) + 1e-12


def test_a_mesh_has_the_intervals_that_its_errors_ask_for_or_not():
    pieces = make_pieces([[np.linspace(0, 1, 4)], [np.linspace(0, 1, 3)]])
    mesh, theta, tol = Mesh(4, 2, pieces), np.array([2.0, 3.0]), 1e-6
    just = np.full(5, 0.99 * SAFETY * tol)
    assert has_wanted_intervals(mesh, theta, interval_density(mesh, theta, just, tol))
    for factor in (1.5, 0.05):
        other = interval_density(mesh, theta, factor * just, tol)
        assert not has_wanted_intervals(mesh, theta, other)
