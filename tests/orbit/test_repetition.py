"""What Newton's method finds is an orbit, once."""

from dataclasses import replace

import numpy as np
import pytest

from pddecont.collocation import MeshRule
from pddecont.orbit import Orbit, SegmentSpan, count_repetitions, is_at_rest, make_resting_orbit, resegment, solve_orbit
from tests import known_orbits

RULE = MeshRule(8, None, 1e-10)


def repeat(orbit, n):
    """Return an orbit taken ``n`` times, solved."""
    segments, ends, period = orbit.signature.segments, orbit.event_times, orbit.period
    spans = [
        SegmentSpan(segment, k * period + ends[s], k * period + ends[s + 1])
        for k in range(n)
        for s, segment in enumerate(segments)
    ]
    if not orbit.signature.has_events:
        spans = [SegmentSpan(segments[0], 0.0, n * period)]
    return solve_orbit(resegment(orbit, spans, RULE, n * orbit.problem.n_periods), RULE).at.orbit


@pytest.mark.parametrize("find", [known_orbits.mackey_glass, known_orbits.hard_wall, known_orbits.impact_oscillator])
def test_an_orbit_is_counted_as_often_as_it_is_taken(find):
    orbit = find()
    assert count_repetitions(orbit) == 1
    for n in (2, 3):
        assert count_repetitions(repeat(orbit, n)) == n


def test_an_orbit_whose_halves_differ_is_one():
    twice = repeat(known_orbits.hard_wall(), 2)
    values = twice.values.copy()
    values[: twice.mesh.first_base[1]] *= 1.001
    changed = Orbit(twice.problem, twice.problem.unknowns.join(values, twice.durations, twice.start, np.zeros(0)))
    assert count_repetitions(changed) == 1


def test_what_does_not_move_is_at_rest():
    orbit = known_orbits.mackey_glass()
    p, numeric = orbit.parameters, orbit.numeric
    resting = make_resting_orbit(numeric, "blood", np.ones(1), p, orbit.problem.delay, 3.0)
    assert is_at_rest(resting, orbit)
    assert not is_at_rest(orbit, orbit)
    values = 1.0 + 1e-4 * (orbit.values - 1.0)
    small = Orbit(orbit.problem, orbit.problem.unknowns.join(values, orbit.durations, 0.0, np.zeros(0)))
    assert not is_at_rest(small, orbit)


def test_a_forced_motion_is_never_at_rest():
    orbit = known_orbits.hard_wall()
    still = Orbit(
        replace(orbit.problem),
        orbit.problem.unknowns.join(np.zeros_like(orbit.values), orbit.durations, orbit.start, np.zeros(0)),
    )
    assert not is_at_rest(still, orbit)
