"""Where points of a mesh are: numbering, places found from times, interpolation, and all of it as theta moves."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.collocation import Mesh, MeshPoints
from pddecont.collocation.mesh import KNOWN_LAYOUTS
from tests.collocation.meshes import make_pieces, meshes

# Segments of three and two intervals, the first of two pieces; a delay that moves nothing.
SHAPE = [[[0, 0.25, 1], [0, 1]], [[0, 0.5, 1]]]
MESH = Mesh(3, 2, make_pieces(SHAPE, n_delays=1))
THETA = np.array([4.0, 1.0, 0.7])


def test_edges_and_lengths():
    assert MESH.start @ THETA == pytest.approx([0, 0.5, 2, 4, 4.5])
    assert MESH.length @ THETA == pytest.approx([0.5, 1.5, 2, 0.5, 0.5])
    assert MESH.piece.tolist() == [0, 0, 1, 2, 2]
    assert MESH.segment.tolist() == [0, 0, 0, 1, 1]
    assert MESH.period(THETA) == 5.0
    assert (MESH.n_intervals, MESH.n_collocation, MESH.n_equation_points) == (5, 15, 17)


def test_neighbours_share_a_base_point_inside_a_segment_alone():
    assert MESH.n_base == 17
    assert MESH.base_index.tolist() == [[0, 1, 2, 3], [3, 4, 5, 6], [6, 7, 8, 9], [10, 11, 12, 13], [13, 14, 15, 16]]
    assert MESH.first_base.tolist() == [0, 10]
    assert MESH.last_base.tolist() == [9, 16]
    assert MESH.last_interval.tolist() == [2, 4]


def test_equations_hold_at_gauss_points_and_at_the_ends():
    points = MESH.equation_points
    assert len(points) == MESH.n_equation_points
    assert points.sigma[:6] == pytest.approx(np.tile(MESH.basis.nodes, 2))
    assert points.interval[-2:].tolist() == [2, 4]
    assert MESH.equation_times[-2:] @ THETA == pytest.approx([4, 5])
    # Their weights are those of the basis.
    assert points.weights == pytest.approx(MESH.basis.lagrange(points.sigma), abs=1e-15)


@settings(max_examples=50, deadline=None, derandomize=True)
@given(found=meshes(), phases=st.lists(st.floats(-3.0, 3.0), min_size=1, max_size=6))
def test_a_place_is_in_the_interval_that_holds_its_phase(found, phases):
    mesh, theta = found
    period = mesh.period(theta)
    times = np.array(phases) * period
    points, wraps = mesh.locate(theta, times)
    at = times - wraps * period
    start, length = (mesh.start @ theta)[points.interval], (mesh.length @ theta)[points.interval]
    slack = 1e-12 * period
    assert np.all((at >= -slack) & (at <= period + slack))
    assert np.all((at >= start - slack) & (at <= start + length + slack))
    # The place says its time again.
    assert mesh.times(points) @ theta == pytest.approx(at, abs=slack)


@settings(max_examples=50, deadline=None, derandomize=True)
@given(found=meshes(), sigma=st.floats(0.0, 0.99), turns=st.integers(-3, 3))
def test_a_point_is_found_again(found, sigma, turns):
    """Every interval's own points, whole periods later or earlier; an interval holds its left edge."""
    mesh, theta = found
    inside = mesh.grid(np.array([0.005 + sigma * 0.995]))
    times = mesh.times(inside) @ theta + turns * mesh.period(theta)
    points, wraps = mesh.locate(theta, times)
    assert np.array_equal(points.interval, inside.interval)
    assert np.all(wraps == turns)
    assert points.sigma == pytest.approx(inside.sigma, abs=1e-9)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(found=meshes(), seed=st.integers(0, 1000), phases=st.lists(st.floats(0.0, 1.0), min_size=1, max_size=6))
def test_polynomials_of_the_degree_are_exact_at_any_time(found, seed, phases):
    """One polynomial over the whole period, which every interval must carry exactly."""
    mesh, theta = found
    p = np.polynomial.Polynomial(np.random.default_rng(seed).normal(size=mesh.degree + 1), [0.0, mesh.period(theta)])
    values = np.stack([p(mesh.base_times(theta)), np.ones(mesh.n_base)], axis=1)
    times = np.array(phases) * 0.999 * mesh.period(theta)
    points, _ = mesh.locate(theta, times)
    assert mesh.interpolate(values, points) == pytest.approx(
        np.stack([p(times), np.ones(len(times))], axis=1), abs=1e-11
    )
    at_nodes = p(mesh.equation_times[: mesh.n_collocation] @ theta)
    assert mesh.interpolate_at_nodes(values)[:, 0] == pytest.approx(at_nodes, abs=1e-11)
    assert mesh.interpolate(values, mesh.equation_points)[: mesh.n_collocation, 0] == pytest.approx(at_nodes, abs=1e-11)


@settings(max_examples=30, deadline=None, derandomize=True)
@given(found=meshes(), stretch=st.floats(0.2, 5.0))
def test_all_points_move_with_theta(found, stretch):
    """Coefficients are the derivatives: at another theta, times are what they say there."""
    mesh, theta = found
    other = theta * np.linspace(1.0, stretch, len(theta))
    ends = np.cumsum(other)
    assert (mesh.start + mesh.length)[mesh.last_interval] @ other == pytest.approx(ends)
    assert mesh.base_times(other)[mesh.last_base] == pytest.approx(ends)
    assert np.all(mesh.length @ other > 0)
    assert np.all(np.diff(mesh.base_times(other)) > -1e-12)


def test_an_edge_belongs_to_the_interval_after_it():
    points, wraps = MESH.locate(THETA, np.array([0.0, 0.5, 4.0, 4.5, 5.0, -5.0]))
    assert points.interval.tolist() == [0, 1, 3, 4, 0, 0]
    assert points.sigma.tolist() == [0.0] * 6
    assert wraps.tolist() == [0, 0, 0, 0, 1, -1]


def test_other_times_may_choose_the_interval():
    """A read at an edge that must stay on its side is looked for a little inside."""
    points, wraps = MESH.locate(THETA, np.array([0.5, 5.0]), choose_by=np.array([0.499, 4.999]))
    assert points.interval.tolist() == [0, 4]
    assert points.sigma == pytest.approx([1.0, 1.0])
    assert wraps.tolist() == [0, 0]


def test_a_place_may_be_sought_in_one_segment():
    points, wraps = MESH.locate(THETA, np.array([4.2, 3.0, 6.0]), segment=1)
    assert points.interval.tolist() == [3, 3, 4]
    assert points.sigma == pytest.approx([0.4, -2.0, 3.0])
    assert wraps.tolist() == [0, 0, 0]
    clipped = points.clipped()
    assert clipped.sigma.tolist() == [points.sigma[0], 0.0, 1.0]
    assert clipped.weights is None


def test_nothing_lies_in_an_interval_without_length():
    """Pieces that shrink to a point are passed over; a segment that is nothing else gives its start."""
    mesh = Mesh(2, 2, make_pieces([[[0, 0.5, 0.5, 1]], [[0, 1]]]))
    points, _ = mesh.locate(np.array([2.0, 1.0]), np.array([1.0]), segment=0)
    assert points.interval.tolist() == [2]
    points, _ = mesh.locate(np.array([2.0, 0.0]), np.array([2.0]), segment=1)
    assert (points.interval.tolist(), points.sigma.tolist()) == ([3], [0.0])


def test_the_side_that_a_jump_is_read_from():
    """Neighbouring segments do not share a base point: an end reads its own segment."""
    values = np.where(np.arange(MESH.n_base) < 10, 1.0, 2.0)[:, None]
    at_end = MeshPoints(np.array([2, 3]), np.array([1.0, 0.0]))
    assert MESH.times(at_end) @ THETA == pytest.approx([4, 4])
    assert MESH.interpolate(values, at_end)[:, 0] == pytest.approx([1.0, 2.0])


def test_what_is_found_for_a_mesh_is_found_once():
    mesh, calls = Mesh(3, 2, MESH.pieces), []

    def find():
        calls.append(1)
        return "found"

    assert [mesh.once("key", find), mesh.once("key", find)] == ["found", "found"]
    assert len(calls) == 1
    mesh.once("another", find)
    Mesh(3, 2, MESH.pieces).once("key", find)
    assert len(calls) == 3


def test_meshes_of_one_layout_know_the_same_of_it():
    """As many intervals in each segment, wherever they lie and whatever came between; no other mesh."""
    first, calls = Mesh(3, 2, make_pieces(SHAPE, n_delays=1)), []
    elsewhere = Mesh(3, 2, make_pieces([[[0, 0.1, 0.7, 1]], [[0, 1], [0, 1]]], n_delays=1))
    finer = Mesh(3, 2, make_pieces([[[0, 0.1, 0.7, 1]], [[0, 0.5, 1], [0, 1]]], n_delays=1))
    higher = Mesh(4, 2, make_pieces(SHAPE, n_delays=1))
    known = first.equation_points
    finer.take_layout(first)
    higher.take_layout(finer)
    elsewhere.take_layout(higher)
    assert elsewhere.equation_points is known
    for mesh in (first, elsewhere, elsewhere.anchor(THETA), finer, higher):
        mesh.alike("layout", lambda mesh=mesh: calls.append((mesh.degree, mesh.n_intervals)))
    assert calls == [(3, 5), (3, 6), (4, 5)]
    # Where edges lie is each mesh's own.
    assert elsewhere.start @ THETA == pytest.approx([0, 0.4, 2.8, 4, 4.5])
    assert elsewhere.equation_times @ THETA == pytest.approx(
        Mesh(3, 2, elsewhere.pieces).equation_times @ THETA, abs=1e-15
    )
    assert not elsewhere.has_base_points_of(first)


def test_few_layouts_are_kept():
    mesh = first = Mesh(2, 1, make_pieces([[np.linspace(0, 1, 2)]]))
    for n in range(2, KNOWN_LAYOUTS + 4):
        mesh, last = Mesh(2, 1, make_pieces([[np.linspace(0, 1, n + 1)]])), mesh
        mesh.take_layout(last)
    again, still = Mesh(2, 1, first.pieces), Mesh(2, 1, last.pieces)
    again.take_layout(mesh)
    still.take_layout(mesh)
    assert again.alike("n", lambda: 1) == 1 and first.alike("n", lambda: 2) == 2
    # Whatever mesh they are taken over from, again and again.
    standing = [Mesh(2, 1, make_pieces([[np.linspace(0, 1, n)]])) for n in (40, 41, 42)]
    standing[1].take_layout(standing[0])
    standing[2].take_layout(standing[0])
    for n in range(50, 150):
        mesh = Mesh(2, 1, make_pieces([[np.linspace(0, 1, n)]]))
        mesh.take_layout(standing[n % 3])
    assert len(mesh._layouts) == KNOWN_LAYOUTS
    assert still.alike("n", lambda: 3) == 3 and last.alike("n", lambda: 4) == 3
