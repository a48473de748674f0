"""Times on the orbit by the durations of each period: the sum over periods, and differences of all of them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.collocation import Mesh, MeshRule
from pddecont.orbit import make_mesh
from pddecont.stability.lagged_times import LaggedMesh, find_deepest_lag, spread_over_lags
from tests.collocation.meshes import make_pieces
from tests.known_orbits import hard_wall


@settings(max_examples=50, deadline=None, derandomize=True)
@given(n_segments=st.integers(1, 4), ended=st.integers(0, 4), wraps=st.integers(0, 3), spare=st.integers(1, 3))
def test_an_event_some_periods_ago(n_segments, ended, wraps, spare):
    """It lies after ``ended`` segments of period k - w, less all of the periods k - w .. k - 1."""
    ended = min(ended, n_segments)
    coefficients = np.where(np.arange(n_segments) < ended, 1.0, 0.0) - wraps
    found = spread_over_lags(coefficients, wraps + 1 + spare, n_segments)
    durations = np.random.default_rng(n_segments).uniform(1, 2, found.shape)
    since = np.sum(durations[wraps, :ended]) - np.sum(durations[1 : wraps + 1])
    assert np.sum(found * durations) == pytest.approx(since)
    # Where all periods are alike nothing else is left.
    assert np.sum(found, axis=0) == pytest.approx(coefficients)


def test_a_breaking_time_some_periods_ago():
    """b of period k - 2, which begins two periods before this one."""
    found = spread_over_lags(np.array([-2.0, -2.0, 0.0, 1.0]), 4, 2)
    assert found.tolist() == [[0, 0, 0, 0], [-1, -1, 0, 0], [-1, -1, 0, 1], [0, 0, 0, 0]]


def test_many_edges_are_spread_as_each_of_them():
    edges = np.array([[0.0, 1.0, 0.0], [-1.0, -1.0, 1.0], [-2.0, -1.0, 0.0]])
    assert np.array_equal(spread_over_lags(edges, 4, 2), [spread_over_lags(edge, 4, 2) for edge in edges])


def test_edges_that_stand_still_do_not_move_and_reach_back_to_no_period():
    mesh = hard_wall().mesh
    still = {tuple(piece.start.tolist()) for piece in mesh.pieces if np.any(piece.start[mesh.n_segments :])}
    assert still
    lagged = LaggedMesh(mesh, 3, still)
    for i, piece in enumerate(mesh.pieces):
        first = lagged.start[np.flatnonzero(mesh.piece == i)[0]]
        assert np.any(first) == bool(np.any(piece.start) and tuple(piece.start.tolist()) not in still)
    assert find_deepest_lag(mesh, still) == 0


def test_the_deepest_lag_is_that_of_the_breaking_points():
    assert find_deepest_lag(Mesh(3, 2, make_pieces([[[0, 1]], [[0, 1]]]))) == 0
    orbit = hard_wall()
    for tau in (0.7, 0.7 + 3 * orbit.period):
        theta = np.array([*orbit.durations, tau])
        mesh = make_mesh(orbit.problem, theta, MeshRule(3, intervals=8))
        # The jump of the state passes through three delays on polynomials of degree 3.
        assert find_deepest_lag(mesh) == 3 * tau // orbit.period


def test_the_periods_together_move_times_as_theta_does():
    mesh = hard_wall().mesh
    lagged = LaggedMesh(mesh, 2 + find_deepest_lag(mesh))
    S, points = mesh.n_segments, mesh.equation_points
    assert np.sum(lagged.start, axis=1) == pytest.approx(mesh.start[:, :S])
    assert np.sum(lagged.length, axis=1) == pytest.approx(mesh.length[:, :S])
    assert np.sum(lagged.times(points), axis=1) == pytest.approx(mesh.times(points)[:, :S])


def test_places_of_reads_move_with_the_durations_of_all_periods():
    """Against differences: each period has durations of its own, and a read reaches back over whole ones."""
    orbit = hard_wall()
    mesh, S = orbit.mesh, orbit.mesh.n_segments
    weights = orbit.equation_reads.operators[0].weights
    n_lags = 3 + find_deepest_lag(mesh)
    lagged, points, tau = LaggedMesh(mesh, n_lags), mesh.equation_points, orbit.theta[S:]

    def places(durations):
        """Return sigma for ``durations`` (n_lags + wraps, S) of periods k, k - 1, ..."""
        result = np.empty(len(points))
        delays = np.concatenate([mesh.times(points)[:, S:], mesh.start[:, S:], mesh.length[:, S:]])
        at_delay, start_delay, length_delay = np.split(delays @ tau, np.cumsum([len(points), mesh.n_intervals]))
        for i, (j, w) in enumerate(zip(weights.interval, weights.wraps, strict=True)):
            own, its = durations[:n_lags], durations[w : w + n_lags]
            time = np.sum(lagged.times(points)[i] * own) + at_delay[i] - tau[0] + np.sum(durations[1 : w + 1])
            start = np.sum(lagged.start[j] * its) + start_delay[j]
            result[i] = (time - start) / (np.sum(lagged.length[j] * its) + length_delay[j])
        return result

    every = np.tile(orbit.durations, (n_lags + 3, 1))
    assert places(every) == pytest.approx(weights.sigma, abs=1e-9)
    widths, slopes = mesh.length @ orbit.theta, np.linspace(1.0, 2.0, len(points))
    found = lagged.move_reads(slopes, lagged.times(points), weights, widths) / slopes[:, None, None]
    for lag in range(n_lags):
        step = np.zeros_like(every)
        step[lag, 0] = 1e-5
        difference = (places(every + step) - places(every - step)) / 2e-5
        assert found[:, lag, 0] == pytest.approx(difference, rel=1e-5, abs=1e-6)
