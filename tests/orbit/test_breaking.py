"""Breaking points and the delay map, for any durations and delays."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.delay.direct import Direct, locate
from pddecont.orbit.breaking import Echoes, echoes, edges
from pddecont.orbit.mesh import Mesh, Places, equal_cuts, segment_pieces
from tests.conftest import numeric_from, shipped

DURATION = st.floats(0.05, 5.0)
DELAY = st.floats(0.001, 40.0)


def mesh_from(found, n_segments, n_cuts=1):
    from pddecont.orbit.mesh import Piece

    pieces = [Piece(s, np.array(a.coefficients, float), np.array(b.coefficients, float), np.linspace(0, 1, n_cuts + 1))
              for s, points in enumerate(found) for a, b in pairwise(points)]  # fmt: skip
    return Mesh(4, n_segments, tuple(pieces))


@settings(max_examples=60, deadline=None)
@given(durations=st.lists(DURATION, min_size=1, max_size=4), delays=st.lists(DELAY, min_size=1, max_size=2), degree=st.integers(1, 4),
       hard=st.booleans())  # fmt: skip
def test_the_image_of_a_piece_lies_inside_one_piece(durations, delays, degree, hard):
    """For all pieces, up to jumps that the degree does not see."""
    n = len(durations)
    theta = np.array([*durations, *delays])
    found = edges(Echoes((0 if hard else 1,) * n, tuple(range(len(delays)))), theta, n, degree)
    mesh = mesh_from(found, n)
    starts = mesh.start @ theta
    assert np.all(mesh.length @ theta > 0)
    assert np.sum(mesh.length @ theta) == pytest.approx(sum(durations))
    level = {tuple(e.coefficients): e.level for points in found for e in points}
    period = sum(durations)
    for k, tau in enumerate(delays):
        # An edge strictly inside an image must be one whose echo jumps too high to matter.
        for j in range(mesh.n_intervals):
            a = (starts[j] - tau) % period
            b = a + (mesh.length @ theta)[j]
            for points in found:
                for edge in points:
                    at = float(np.array(edge.coefficients) @ theta)
                    for shifted in (at, at + period):
                        if a + 1e-8 < shifted < b - 1e-8:
                            own = level[tuple(edge.coefficients)]
                            own = (0 if hard else 1) if own == -1 else own
                            assert own + 1 > degree, (k, at, own)


def test_levels_come_from_the_model():
    soft = shipped("impact_oscillator")
    assert echoes(soft, (soft.model.segments["NC"], soft.model.segments["C"])) == Echoes((1, 1), (0,))
    hard = numeric_from("name: m\nstates: [x]\nparameters: {a: 1, b: 2}\nmodes: {m: {x': 1 + 0*x(t - a) + x(t - b)}}\n"
                        "events: {e: x - x(t - a)}\nresets: {r: {x: -x}}\n"
                        "segments: {s: {mode: m, event: e, reset: r, to: m}}\n")  # fmt: skip
    pattern = echoes(hard, (hard.model.segments["s"],))
    assert pattern.jumps == (0,)
    assert [str(hard.model.delays[k]) for k in pattern.delays] == ["b"]  # the event function reads a, no vector field does


def test_a_degree_needs_one_level_more_after_a_state_jump():
    theta = np.array([10.0, 0.7])
    for degree in (2, 5):
        soft = edges(Echoes((1,), (0,)), theta, 1, degree)[0]
        hard = edges(Echoes((0,), (0,)), theta, 1, degree)[0]
        assert len(soft) - 2 == degree - 1
        assert len(hard) - 2 == degree


def test_points_that_coincide_are_one():
    found = edges(Echoes((1, 1), (0,)), np.array([1.0, 2.0, 3.0]), 2, 5)  # the delay is the period
    assert [len(points) for points in found] == [2, 2]
    found = edges(Echoes((1, 1), (0,)), np.array([1.0, 2.0, 1.0]), 2, 5)
    assert [len(points) for points in found] == [2, 3]


@settings(max_examples=80, deadline=None)
@given(delay=st.floats(0.0, 400.0), split=st.floats(0.1, 0.9))
def test_direct_reads_are_right_for_any_delay(delay, split):
    theta = np.array([4 * split, 4 * (1 - split), delay])
    mesh = Mesh(10, 2, segment_pieces(2, 3, equal_cuts([6, 6])))
    w = 2 * np.pi / 4
    values = np.sin(w * mesh.base_times(theta))[:, None]
    operator = Direct().operator(mesh, theta, 2, mesh.sites)
    exact = np.sin(w * (mesh.site_times @ theta - delay))
    assert np.max(np.abs(operator.weights.apply(values)[:, 0] - exact)) < 1e-8
    slope = operator.theta_derivative(values, [2])[:, 0, 0]
    assert np.max(np.abs(slope + w * np.cos(w * (mesh.site_times @ theta - delay)))) < 1e-6
    turns = (delay - mesh.site_times @ theta) / 4
    clear = np.abs(turns - np.round(turns)) > 1e-9
    assert np.array_equal(locate(mesh, theta, 2, mesh.sites).wraps[clear], np.ceil(turns).astype(int)[clear])


def test_reads_at_an_edge_stay_on_the_side_of_their_place():
    """A delay of exactly one segment: the end of segment 2 reads the end of segment 1, its start the start of segment 1."""
    theta = np.array([1.0, 1.0, 1.0])
    mesh = Mesh(2, 2, segment_pieces(2, 3, equal_cuts([1, 1])))
    values = np.array([0.0, 0, 1, 10, 10, 11])[:, None]
    operator = Direct().operator(mesh, theta, 2, Places(np.array([1, 1]), np.array([0.0, 1.0])))
    assert operator.weights.apply(values)[:, 0] == pytest.approx([0.0, 1.0], abs=1e-9)
