"""From one mesh to another and back."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.collocation import Mesh, Piece, raise_degree, resample, transfer
from pddecont.collocation.interpolation import _read_folded
from tests.collocation.meshes import make_pieces, meshes


@settings(max_examples=40, deadline=None, derandomize=True)
@given(found=meshes(), n_cuts=st.integers(1, 5), more=st.integers(0, 2), seed=st.integers(0, 1000))
def test_polynomials_are_carried_over_exactly(found, n_cuts, more, seed):
    """Polynomials of the mesh's degree in each segment's own time, onto other intervals of at least that degree."""
    mesh, theta = found
    shape = [[np.linspace(0, 1, n_cuts + 1)]] * mesh.n_segments
    other = Mesh(mesh.degree + more, mesh.n_segments, make_pieces(shape))
    coefficients = np.random.default_rng(seed).normal(size=(mesh.n_segments, mesh.degree + 1))

    def values(on):
        result, times, ends = np.empty((on.n_base, 1)), on.base_times(theta), np.concatenate([[0], np.cumsum(theta)])
        for s in range(on.n_segments):
            rows = np.arange(on.first_base[s], on.last_base[s] + 1)
            fraction = (times[rows] - ends[s]) / theta[s]
            result[rows, 0] = np.polynomial.Polynomial(coefficients[s])(fraction)
        return result

    assert transfer(mesh, theta, values(mesh), other, theta) == pytest.approx(values(other), abs=1e-10)
    # A mesh that lasts another time carries the same values at the same fractions.
    assert transfer(mesh, theta, values(mesh), other, 2.5 * theta) == pytest.approx(values(other), abs=1e-10)
    # Back, if nothing was lost on the way.
    there = transfer(mesh, theta, values(mesh), other, theta)
    assert transfer(other, theta, there, mesh, theta) == pytest.approx(values(mesh), abs=1e-10)


def test_a_jump_between_segments_stays_one():
    mesh = Mesh(3, 2, make_pieces([[[0, 1]], [[0, 0.5, 1]]]))
    other = Mesh(2, 2, make_pieces([[[0, 0.3, 1]], [[0, 1]]]))
    theta = np.array([1.0, 2.0])
    values = np.where(np.arange(mesh.n_base) < 4, 1.0, 5.0)[:, None]
    found = transfer(mesh, theta, values, other, np.array([0.1, 7.0]))
    assert found[:5, 0] == pytest.approx(np.ones(5))
    assert found[5:, 0] == pytest.approx(np.full(3, 5.0))


@settings(max_examples=30, deadline=None, derandomize=True)
@given(found=meshes(), seed=st.integers(0, 1000))
def test_a_degree_more_is_the_same_function(found, seed):
    mesh, theta = found
    finer = raise_degree(mesh, theta)
    assert finer.degree == mesh.degree + 1
    assert finer.pieces is mesh.pieces
    assert np.array_equal(finer.reference_theta, theta)
    values = np.random.default_rng(seed).normal(size=(mesh.n_base, 2))
    raised = resample(mesh, values, finer)
    sigma = np.array([0.0, 0.3, 0.8, 1.0])
    same = pytest.approx(mesh.interpolate(values, mesh.grid(sigma)), abs=1e-12)
    assert finer.interpolate(raised, finer.grid(sigma)) == same
    assert resample(finer, raised, mesh) == pytest.approx(values, abs=1e-12)


def test_the_error_of_a_coarser_mesh_falls_with_its_order():
    """Interpolation of degree m leaves h^(m+1)."""
    theta, errors = np.array([1.0]), []
    for n in (16, 32):
        mesh = Mesh(3, 1, make_pieces([[np.linspace(0, 1, n + 1)]]))
        fine = Mesh(9, 1, make_pieces([[np.linspace(0, 1, 101)]]))
        values = np.sin(2 * np.pi * fine.base_times(theta))[:, None]
        there = transfer(fine, theta, values, mesh, theta)
        errors.append(np.max(np.abs(transfer(mesh, theta, there, fine, theta) - values)))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4, abs=0.03)


def test_a_mesh_of_another_degree_keeps_its_base_points_apart():
    mesh = Mesh(3, 2, make_pieces([[[0, 1]], [[0, 0.5, 1]]]))
    other = replace(mesh, degree=5)
    values = np.where(np.arange(mesh.n_base) < 4, 1.0, 5.0)[:, None]
    assert resample(mesh, values, other)[:, 0] == pytest.approx([1.0] * 6 + [5.0] * 11)


def test_where_breaking_points_pass_one_another_their_jumps_change_places():
    """A curve with a kink at a = tau_1 and one at b = tau_2, a mesh made for a < b, and b a little before a.

    Every piece goes on as its own polynomial; between b and a the curve is what has the kink at b already.
    """
    edges = np.array([[0, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 0]], dtype=float)
    pieces = tuple(Piece(0, a, b, np.array([0.0, 1.0])) for a, b in pairwise(edges))
    mesh, swapped = Mesh(3, 1, pieces), np.array([2.0, 1.0, 0.9])
    one, other = swapped[1:]

    def curve(t, before):
        """Return 1 + t - t^2 with kinks at the places that lie ``before`` t."""
        return (
            1 + t - t**2 + (0.7 * (t - one) if one in before else 0.0) - (0.4 * (t - other) if other in before else 0)
        )

    values = np.empty((mesh.n_base, 1))
    times = mesh.base_times(swapped)
    for interval, before in enumerate([[], [one], [one, other]]):
        rows = mesh.base_index[interval]
        values[rows, 0] = curve(times[rows], before)
    fine = Mesh(3, 1, (Piece(0, edges[0], edges[3], np.linspace(0, 1, 41)),))
    t = fine.base_times(swapped)
    expected = [curve(time, [place for place in (one, other) if place < time]) for time in t]
    assert transfer(mesh, swapped, values, fine, swapped)[:, 0] == pytest.approx(expected, abs=1e-12)


def test_an_interval_between_edges_that_are_the_same_to_rounding_is_read_inside():
    """Its own length, of other sums of the same numbers, is zero; its edges are a unit of the last place apart."""
    edges = np.array([[0, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 0]], dtype=float)
    mesh = Mesh(3, 1, tuple(Piece(0, a, b, np.array([0.0, 1.0])) for a, b in pairwise(edges)))
    theta = np.array([2.0, 1.0, np.nextafter(1.0, 2.0)])
    lengths = mesh.length.copy()
    lengths[1] = 0.0
    vars(mesh)["length"] = lengths
    values = 1.0 + mesh.base_times(theta)[:, None]
    times = np.array([0.0, 0.5, 1.0, theta[2], 1.5])
    assert _read_folded(mesh, theta, values, 0, times)[:, 0] == pytest.approx(1.0 + times, abs=1e-14)
