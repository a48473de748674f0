"""Delayed values read from the orbit itself: for any delay, on the right side of edges, and with the right wraps."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.collocation import Mesh, MeshPoints, equal_cuts
from pddecont.delay import Direct
from pddecont.delay.direct import find_reads, reference_reads
from pddecont.errors import ConvergenceError
from tests.delay.meshes import LAG, NOTHING, THETA, check_theta_derivative, mesh_of
from tests.orbits import segment_pieces


@settings(max_examples=80, deadline=None, derandomize=True)
@given(delay=st.floats(0.0, 400.0), split=st.floats(0.1, 0.9))
def test_reads_are_right_for_any_delay(delay, split):
    theta = np.array([4 * split, 4 * (1 - split), delay])
    mesh = Mesh(10, 2, segment_pieces(2, 3, equal_cuts([6, 6])))
    w = 2 * np.pi / 4
    values = np.sin(w * mesh.base_times(theta))[:, None]
    operator = Direct().operator(mesh, theta, LAG, mesh.equation_points)
    times = mesh.equation_times @ theta
    assert np.max(np.abs(operator.weights.apply(values)[:, 0] - np.sin(w * (times - delay)))) < 1e-8
    slope = operator.theta_derivative(values, [2], 0)[:, 0, 0]
    assert np.max(np.abs(slope + w * np.cos(w * (times - delay)))) < 1e-6
    turns = (delay - times) / 4
    clear = np.abs(turns - np.round(turns)) > 1e-9
    wraps = find_reads(mesh, theta, LAG, mesh.equation_points).wraps
    assert np.array_equal(wraps[clear], np.ceil(turns).astype(int)[clear])


@settings(max_examples=50, deadline=None, derandomize=True)
@given(
    durations=st.tuples(st.floats(0.2, 5.0), st.floats(0.2, 5.0)),
    delay=st.floats(0.0, 60.0),
    sigma=st.lists(st.floats(0.0, 1.0), min_size=1, max_size=5),
)
def test_a_read_lies_in_its_interval_within_one_period(durations, delay, sigma):
    """The time less the delay, wrapped, lies in the period, and in the interval that is read."""
    theta = np.array([*durations, delay])
    mesh = mesh_of(3, [4, 3])
    points = mesh.grid(np.array(sigma))
    reads = find_reads(mesh, theta, LAG, points)
    at, period = reads.times @ theta, mesh.period(theta)
    slack = 2e-11 * period
    assert np.all((at >= -slack) & (at <= period + slack))
    assert at == pytest.approx(mesh.times(points) @ theta - delay + reads.wraps * period, abs=1e-12 * (1 + delay))
    start, length = (mesh.start @ theta)[reads.interval], (mesh.length @ theta)[reads.interval]
    assert np.all((at >= start - slack) & (at <= start + length + slack))
    assert np.array_equal(reads.columns, mesh.base_index[reads.interval])


def test_reads_at_an_edge_stay_on_the_side_of_their_point():
    """A delay of exactly one segment: the second segment reads the first, from start to end."""
    theta = np.array([1.0, 1.0, 1.0])
    mesh = Mesh(2, 2, segment_pieces(2, 3, equal_cuts([1, 1])))
    values = np.array([0.0, 0, 1, 10, 10, 11])[:, None]
    points = MeshPoints(np.array([1, 1]), np.array([0.0, 1.0]))
    assert Direct().operator(mesh, theta, LAG, points).weights.apply(values)[:, 0] == pytest.approx([0, 1], abs=1e-9)
    # Where a point says so itself, it is read from that side: a jump from 1 to 10 lies between.
    for inward, value in ((1.0, 10.0), (-1.0, 1.0)):
        inside = MeshPoints(np.array([1]), np.array([1.0]), inward=np.array([inward]))
        assert Direct().operator(mesh, theta, LAG, inside).weights.apply(values)[0, 0] == pytest.approx(value)


def test_derivatives_in_durations_and_delay():
    mesh = replace(mesh_of(4, [6, 3]), reference_theta=THETA)
    check_theta_derivative(Direct(), mesh, 1e-7)


def test_a_mesh_in_use_reads_the_same_intervals_a_little_beyond_their_ends():
    """Polynomials are read where they were when the mesh was made, so that values stay smooth; elsewhere anew."""
    mesh = replace(mesh_of(3, [6, 3]), reference_theta=THETA)
    before = reference_reads(mesh, LAG)
    assert reference_reads(mesh, LAG) is before
    moved = THETA + 0.6 * LAG
    held = Direct().operator(mesh, moved, LAG, mesh.equation_points).weights
    assert np.array_equal(held.interval, before.interval)
    # The longer delay reaches back before the intervals: some are read beyond their left ends.
    assert np.min(held.sigma) < 0.0
    anew = Direct().operator(mesh_of(3, [6, 3]), moved, LAG, mesh.equation_points).weights
    assert not np.array_equal(anew.interval, before.interval)
    assert np.min(anew.sigma) > -1e-9
    # A cubic is the same polynomial in every interval, however far it is read beyond one.
    smooth = (mesh.base_times(moved) ** 3)[:, None]
    inside = held.wraps == 0
    at = (mesh.equation_times @ moved - moved[2])[inside]
    assert held.apply(smooth)[inside, 0] == pytest.approx(at**3, abs=1e-9)


@pytest.mark.parametrize("track", [True, False])
def test_a_mesh_is_valid_until_reads_leave_their_pieces(track):
    """Of segments of 9 and 1.3, cut into 1.5 and 0.43, the point at 3.75 reads the end of the orbit, 3.8 before."""
    mesh = replace(mesh_of(3, [6, 3]), reference_theta=THETA)
    method, lags = Direct(track=track), LAG[None]
    assert method.mesh_is_valid(mesh_of(3, [6, 3]), THETA, lags, NOTHING), "a mesh made for no theta is valid anywhere"
    assert method.mesh_is_valid(mesh, THETA, lags, NOTHING)
    assert method.mesh_is_valid(mesh, THETA - 0.02 * LAG, lags, NOTHING)
    # A little more, and it reads the start: allowed where breaking points are not tracked, and the interval near.
    assert method.mesh_is_valid(mesh, THETA - 0.06 * LAG, lags, NOTHING) == (not track)
    assert not method.mesh_is_valid(mesh, THETA - 2.0 * LAG, lags, NOTHING)


def test_the_end_of_a_segment_may_not_pass_a_jump():
    """The end of segment 2 reads the end of segment 1 where the delay is that segment's duration."""
    theta = np.array([9.0, 1.3, 1.35])
    mesh = replace(mesh_of(3, [6, 3]), reference_theta=theta)
    assert Direct(track=False).mesh_is_valid(mesh, theta + 0.02 * LAG, LAG[None], NOTHING)
    assert not Direct(track=False).mesh_is_valid(mesh, theta - 0.1 * LAG, LAG[None], NOTHING)


def test_reads_that_mean_nothing_are_refused():
    mesh = replace(mesh_of(3, [6, 3]), reference_theta=THETA)
    with pytest.raises(ConvergenceError, match="far outside its mesh interval"):
        Direct().operator(mesh, THETA + 8.0 * LAG, LAG, mesh.equation_points)
    with pytest.raises(ConvergenceError, match="a mesh interval has vanished"):
        Direct().operator(mesh, np.array([9.0, 0.0, 3.8]), LAG, mesh.equation_points)


def test_what_reading_is():
    assert Direct().stages is None
    assert Direct().simulated_stages == (0, 0)
    assert Direct().tracks_breaking_points
    assert not Direct(track=False).tracks_breaking_points
