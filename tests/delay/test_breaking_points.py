"""Breaking points for any durations and delays: between them every delayed piece is smooth."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.collocation import Mesh, Piece
from pddecont.delay import DiscontinuitySources, find_breaking_points, find_discontinuity_sources, jump_returns_at_event
from tests.conftest import numeric_from, shipped

DURATION = st.floats(0.05, 5.0)
DELAY = st.floats(0.001, 40.0)


def mesh_from(found, n_segments, n_cuts=1):
    pieces = [
        Piece(s, np.array(a.coefficients, float), np.array(b.coefficients, float), np.linspace(0, 1, n_cuts + 1))
        for s, points in enumerate(found)
        for a, b in pairwise(points)
    ]
    return Mesh(4, n_segments, tuple(pieces))


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    durations=st.lists(DURATION, min_size=1, max_size=4),
    delays=st.lists(DELAY, min_size=1, max_size=2),
    degree=st.integers(1, 4),
    hard=st.booleans(),
)
def test_the_image_of_a_piece_lies_inside_one_piece(durations, delays, degree, hard):
    """For all pieces, up to jumps that the degree does not see."""
    n, jump = len(durations), 0 if hard else 1
    theta = np.array([*durations, *delays])
    sources = DiscontinuitySources((jump,) * n, tuple(range(len(delays))))
    found = find_breaking_points(sources, theta, n, degree).by_segment
    mesh = mesh_from(found, n)
    starts, lengths = mesh.start @ theta, mesh.length @ theta
    assert np.all(lengths > 0)
    assert np.sum(lengths) == pytest.approx(sum(durations))
    period = sum(durations)
    every = [point for points in found for point in points]
    at = np.array([np.array(point.coefficients) @ theta for point in every])
    level = np.array([jump if point.level == -1 else point.level for point in every])
    for tau in delays:
        # A point strictly inside an image must be one that comes back too high to matter.
        begin = (starts - tau) % period
        for shifted in (at, at + period):
            inside = (shifted > begin[:, None] + 1e-8) & (shifted < (begin + lengths)[:, None] - 1e-8)
            assert np.all(level[np.any(inside, axis=0)] + 1 > degree)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    durations=st.lists(DURATION, min_size=1, max_size=4),
    delays=st.lists(DELAY, min_size=1, max_size=2),
    degree=st.integers(1, 5),
)
def test_points_come_in_order_and_each_lies_in_its_segment(durations, delays, degree):
    n = len(durations)
    theta = np.array([*durations, *delays])
    found = find_breaking_points(DiscontinuitySources((1,) * n, tuple(range(len(delays)))), theta, n, degree).by_segment
    ends = np.concatenate([[0.0], np.cumsum(durations)])
    assert len(found) == n
    for s, points in enumerate(found):
        at = np.array([np.array(point.coefficients) @ theta for point in points])
        assert np.all(np.diff(at) > 0)
        assert at[[0, -1]] == pytest.approx(ends[s : s + 2])
        assert [point.level for point in points[:: len(points) - 1]] == [-1, -1]
        # Everything between came through at least one delay, and jumps in a derivative that the degree sees.
        for point in points[1:-1]:
            turns = sum(point.coefficients[n:])
            assert 1 < point.level == 1 + turns <= degree


def test_levels_come_from_the_model():
    soft = shipped("impact_oscillator").model
    segments = (soft.segments["NC"], soft.segments["C"])
    assert find_discontinuity_sources(soft, segments) == DiscontinuitySources((1, 1), (0,))
    hard = numeric_from(
        "name: m\nstates: [x]\nparameters: {a: 1, b: 2}\nmodes: {m: {x': 1 + 0*x(t - a) + x(t - b)}}\n"
        "events: {e: x - x(t - a)}\nresets: {r: {x: -x}}\n"
        "segments: {s: {mode: m, event: e, reset: r, to: m}}\n"
    ).model
    sources = find_discontinuity_sources(hard, (hard.segments["s"],))
    assert sources.jumps == (0,)
    # The event function reads a, no vector field does.
    assert [str(hard.delays[k]) for k in sources.delays] == ["b"]


@pytest.mark.parametrize(
    ("read", "gains"), [("x'(t - a)", {}), ("v(t - a)", {}), ("v'(t - a)", {0: 0}), ("y'(t - a)", {0: 0})]
)
def test_a_rate_that_is_a_state_all_along_is_read_as_its_value(read, gains):
    """x' = v in both modes; y' = v in one of them alone."""
    model = numeric_from(
        "name: m\nstates: [x, v, y]\nparameters: {a: 1}\n"
        f"modes: {{m: {{x': v, v': -x - {read}/5, y': v}}, n: {{x': v, v': -x - {read}/5, y': -y}}}}\n"
        "events: {e: x}\nsegments: {s: {mode: m, event: e, to: n}, u: {mode: n, event: e, to: m}}\n"
    ).model
    sources = find_discontinuity_sources(model, (model.segments["s"], model.segments["u"]))
    assert sources.delays == (0,) and sources.gains == gains


def test_an_implicit_delay_of_a_state_that_is_an_integral_smooths_jumps():
    """The delay's own rate reads a'(t - tau), which is w(t - tau)."""
    model = shipped("drill_string").model
    sources = find_discontinuity_sources(model, [s for s in model.segments.values() if s.event][:2])
    assert sources.varying == (0,) and not sources.gains


def test_a_degree_needs_one_level_more_after_a_state_jump():
    theta = np.array([10.0, 0.7])
    for degree in (2, 5):
        soft = find_breaking_points(DiscontinuitySources((1,), (0,)), theta, 1, degree).by_segment[0]
        hard = find_breaking_points(DiscontinuitySources((0,), (0,)), theta, 1, degree).by_segment[0]
        assert len(soft) - 2 == degree - 1
        assert len(hard) - 2 == degree


def test_points_that_coincide_are_one():
    sources = DiscontinuitySources((1, 1), (0,))
    points = find_breaking_points(sources, np.array([1.0, 2.0, 3.0]), 2, 5)  # the delay is the period
    found = points.by_segment
    assert not points.distinct
    assert [len(points) for points in found] == [2, 2]
    found = find_breaking_points(sources, np.array([1.0, 2.0, 1.0]), 2, 5).by_segment
    assert [len(points) for points in found] == [2, 3]


@pytest.mark.parametrize(
    ("tau", "returns"),
    [(3.0, True), (2.0, True), (1.0, True), (4.0, True), (3.0 + 1e-11, True), (3.0 + 1e-6, False), (0.0, False)],
)
def test_a_jump_that_returns_at_an_event(tau, returns):
    """Events at 1 and 3 of a period of 3: a jump at either comes back at an event after 1, 2, 3, ... and no other."""
    theta = np.array([1.0, 2.0, tau])
    assert jump_returns_at_event(DiscontinuitySources((0, 0), (0,)), theta, 2) == returns
    # What only bends comes back as a bend.
    assert not jump_returns_at_event(DiscontinuitySources((1, 1), (0,)), theta, 2)
    # A delay that no vector field reads brings nothing back.
    assert not jump_returns_at_event(DiscontinuitySources((0, 0), ()), theta, 2)


def test_only_the_jump_of_the_state_counts():
    """The jump at 1 comes back at 3 after a delay of 2; what only bends at 3 would return at 1 after a delay of 1."""
    sources = DiscontinuitySources((0, 1), (0,))
    assert jump_returns_at_event(sources, np.array([1.0, 2.0, 2.0]), 2)
    assert not jump_returns_at_event(sources, np.array([1.0, 2.0, 1.0]), 2)


def test_points_that_lie_apart_are_called_distinct():
    sources = DiscontinuitySources((1, 1), (0,))
    assert find_breaking_points(sources, np.array([1.0, 2.0, 0.3]), 2, 5).distinct
    # The second sum of delays after one event falls on the first after the other.
    assert not find_breaking_points(sources, np.array([1.0, 2.0, 1.0]), 2, 5).distinct
