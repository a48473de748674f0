"""The same motion in other segments: through all of them again, it is what it was."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.collocation import MeshRule
from pddecont.orbit import SegmentSpan, make_eventless, resegment
from pddecont.orbit.residual import compute_residual
from tests.known_orbits import hard_wall, impact_oscillator, mackey_glass
from tests.orbit.exact import TURN, circle

RULE = MeshRule(10, intervals=16)


def turn(orbit, begin, n=1):
    """Return spans of an orbit's segments from segment ``begin`` on, through ``n`` turns."""
    S, ends = len(orbit.signature), orbit.event_times
    spans = []
    for k in range(begin, begin + n * S):
        laps, s = divmod(k, S)
        spans.append(
            SegmentSpan(orbit.signature.segments[s], ends[s] + laps * orbit.period, ends[s + 1] + laps * orbit.period)
        )
    return spans


@settings(max_examples=20, deadline=None, derandomize=True)
@given(cut=st.floats(0.05, 0.95), tau=st.sampled_from([0.0, 1.0, 8.0]))
def test_cut_in_two_and_put_together_again(cut, tau):
    """One turn as two segments that end anywhere, and those two as one again."""
    orbit = circle("s", level=0.5, tau=tau, rule=MeshRule(12, intervals=20))
    (segment,) = orbit.signature.segments
    middle = cut * orbit.period
    spans = [SegmentSpan(segment, 0.0, middle), SegmentSpan(segment, middle, orbit.period)]
    two = resegment(orbit, spans, MeshRule(12, intervals=24), 1)
    assert two.durations == pytest.approx([middle, orbit.period - middle])
    t = two.start + two.mesh.base_times(two.theta)
    assert two.values == pytest.approx(np.stack([np.cos(t), np.sin(t)], axis=1), abs=1e-7)
    one = resegment(two, [SegmentSpan(segment, 0.0, two.period)], MeshRule(12, intervals=20), 1)
    assert one.signature.names == ["s"]
    assert one.values == pytest.approx(orbit.values, abs=1e-7)
    assert one.start == orbit.start


@pytest.mark.parametrize("n", [1, 2, 3])
def test_turn_after_turn(n):
    """An orbit through n of its periods solves the equations of that signature too."""
    orbit = impact_oscillator()
    many = resegment(orbit, turn(orbit, 0, n), MeshRule(10, tol=1e-9), n * orbit.problem.n_periods)
    assert many.signature.names == ["NC", "C"] * n
    assert many.durations == pytest.approx(np.tile(orbit.durations, n))
    assert np.max(np.abs(compute_residual(many))) < 1e-6


def test_begun_at_another_segment():
    orbit = impact_oscillator()
    turned = resegment(orbit, turn(orbit, 1), MeshRule(10, tol=1e-9), orbit.problem.n_periods)
    assert turned.signature.names == ["C", "NC"]
    assert turned.start == pytest.approx(orbit.start + orbit.durations[0])
    assert np.max(np.abs(compute_residual(turned))) < 1e-6
    # From the side inside each segment, though a read at its end might come from the next.
    first, last = turned.mesh.first_base, turned.mesh.last_base
    assert turned.values[first[0]] == pytest.approx(orbit.values[orbit.mesh.first_base[1]], abs=1e-6)
    assert turned.values[last[0]] == pytest.approx(orbit.values[orbit.mesh.last_base[1]], abs=1e-6)


def test_a_jump_lies_between_segments_and_in_none():
    """The wall turns the velocity round: each segment ends before the jump, and the next begins after it."""
    orbit = hard_wall()
    twice = resegment(orbit, turn(orbit, 0, 2), MeshRule(10, tol=1e-9), 2 * orbit.problem.n_periods)
    before, after = orbit.values[-1], orbit.values[0]
    assert after[1] == pytest.approx(-0.8 * before[1])
    assert twice.values[twice.mesh.last_base] == pytest.approx(np.stack([before, before]), abs=1e-6)
    assert twice.values[twice.mesh.first_base] == pytest.approx(np.stack([after, after]), abs=1e-6)


def test_without_events_it_is_its_own_reference():
    orbit = mackey_glass()
    double = resegment(orbit, [SegmentSpan(orbit.signature.segments[0], 0.0, 2 * orbit.period)], RULE, 1)
    assert np.array_equal(double.problem.reference, double.values)
    assert double.period == pytest.approx(2 * orbit.period)


def test_events_left_out():
    """The circle through its event, as a motion that meets none."""
    orbit = circle("s", level=0.5)
    free = resegment(orbit, [SegmentSpan(make_eventless(orbit.numeric.model, "m"), 0.0, TURN)], RULE, 1)
    assert free.signature.names == ["(m)"]
    assert free.problem.phase == orbit.start
    assert np.max(np.abs(compute_residual(free))) < 1e-7
