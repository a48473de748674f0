"""Parts of intervals between the edges' echoes: together they are the whole, and what is read in one is smooth."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.collocation import MeshRule
from pddecont.delay import Chain
from pddecont.orbit.smooth_subintervals import find_smooth_subintervals
from tests.orbit.exact import circle


@settings(max_examples=30, deadline=None, derandomize=True)
@given(tau=st.floats(0.0, 20.0), intervals=st.integers(3, 12))
def test_parts_are_the_whole_and_reads_stay_in_one_interval(tau, intervals):
    orbit = circle("s", level=0.5, tau=tau, rule=MeshRule(3, intervals=intervals))
    mesh, n = orbit.mesh, orbit.mesh.n_intervals
    parts = find_smooth_subintervals(orbit, np.arange(n), delays=True)
    assert np.bincount(parts.interval, weights=parts.share, minlength=n) == pytest.approx(np.ones(n))
    assert np.all(parts.share > 0)
    first = np.append(True, np.diff(parts.interval) > 0)
    assert np.all(parts.low[first] == 0.0)
    assert np.all(parts.low[1:][~first[1:]] == parts.high[:-1][~first[1:]])
    # From within, both ends of a part read the same interval, the same turns back.
    reads = orbit.read(parts.grid(mesh, np.array([0.01, 0.5, 0.99])))
    weights = reads.operators[0].weights
    thick = parts.share * reads.h[parts.interval] > 1e-6
    assert np.all(np.ptp(weights.interval.reshape(-1, 3), axis=1)[thick] == 0)
    assert np.all(np.ptp(weights.wraps.reshape(-1, 3), axis=1)[thick] == 0)


def test_without_delays_intervals_are_whole():
    orbit = circle("s", level=0.5)
    chosen = np.array([1, 3])
    for parts in (
        find_smooth_subintervals(orbit, chosen, delays=False),
        find_smooth_subintervals(circle("s", level=0.5, method=Chain(2, 4)), chosen, delays=True),
    ):
        assert parts.interval.tolist() == [1, 3]
        assert parts.share.tolist() == [1.0, 1.0]
    grid = parts.grid(orbit.mesh, np.array([0.0, 1.0]))
    assert grid.sigma.tolist() == [0.0, 1.0, 0.0, 1.0]
    assert grid.inward is None


def test_ends_of_parts_are_read_from_within():
    orbit = circle("s", level=0.5, rule=MeshRule(3, intervals=6))
    parts = find_smooth_subintervals(orbit, np.arange(orbit.mesh.n_intervals), delays=True)
    assert len(parts.interval) > orbit.mesh.n_intervals
    grid = parts.grid(orbit.mesh, np.array([0.0, 0.5, 1.0]))
    assert grid.inward.reshape(-1, 3).tolist() == [[1.0, 0.0, -1.0]] * len(parts.interval)
    some = find_smooth_subintervals(orbit, np.array([2]), delays=True)
    assert set(some.interval.tolist()) == {2}
