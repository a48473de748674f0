"""What an orbit does against what its signature says, on a circle whose crossings and extrema are known."""

from dataclasses import replace

import numpy as np
import pytest

from pddecont.collocation import Mesh, MeshRule, make_basis
from pddecont.orbit import (
    Orbit,
    Profile,
    find_approaches,
    find_closest_approach,
    find_event_profile,
    find_event_profiles,
    find_violations,
    is_met_from_below,
    make_mesh,
)
from pddecont.orbit.admissibility import _find_near_crossings
from tests.orbit.exact import TURN, circle


@pytest.mark.parametrize(
    ("direction", "crossed"), [("rising", ["rising"]), ("falling", ["falling"]), ("any", ["rising", "falling"])]
)
def test_crossings_that_the_signature_does_not_have(direction, crossed):
    """Through no segment at all, a level inside the circle is crossed upwards and downwards."""
    found = find_violations(circle(level=0.5, direction=direction))
    assert [reason.code for reason in found] == ["also_crossed"] * len(crossed)
    assert [reason.values["crossed"] for reason in found] == crossed
    assert found[0].values["event"] == "e"
    assert found[0].values["segment"] == "(m)"
    assert found[0].values["listed"] == direction


@pytest.mark.parametrize("level", [1.5, -1.5, 1.001])
def test_a_level_beyond_the_circle_is_never_crossed(level):
    assert find_violations(circle(level=level, direction="any")) == []


def test_the_way_back_through_a_surface_is_no_event():
    """A rising event once a turn: falling through its surface in between is not what it watches for."""
    assert find_violations(circle("s", level=0.5)) == []
    assert find_violations(circle("s", "s", level=0.5)) == []


def test_an_event_crossed_twice_where_it_is_listed_once():
    """Two turns taken for one segment: the rise in the middle of it is another event."""
    twice = circle("s", "s", level=0.5)
    bare = replace(twice.problem, signature=circle("s", level=0.5).signature, mesh=Mesh(10, 1, ()), n_periods=2)
    mesh = make_mesh(bare, np.array([2 * TURN, 1.0]), MeshRule(10, intervals=16))
    problem = replace(bare, mesh=mesh)
    t = twice.start + mesh.base_times(np.array([2 * TURN, 1.0]))
    x = problem.unknowns.join(np.stack([np.cos(t), np.sin(t)], axis=1), [2 * TURN], twice.start, [])
    (reason,) = find_violations(Orbit(problem, x))
    assert (reason.code, reason.values["number"], reason.values["crossed"]) == ("also_crossed", 1, "rising")


def test_an_event_crossed_backwards():
    """The segment begins and ends where the circle falls through the level, but is said to end where it rises."""
    orbit = circle("s", level=0.5)
    t = np.pi - orbit.start + orbit.mesh.base_times(orbit.theta)
    values = np.stack([np.cos(t), np.sin(t)], axis=1)
    falling = Orbit(orbit.problem, orbit.problem.unknowns.join(values, orbit.durations, np.pi - orbit.start, []))
    assert [(r.code, r.values["crossed"]) for r in find_violations(falling)] == [
        ("crossed_backwards", "falling"),
        ("also_crossed", "rising"),
    ]


def test_a_segment_of_no_duration():
    orbit = circle("s", "s", level=0.5, rule=MeshRule(6, intervals=8))
    durations = [2 * TURN, 1e-14]
    vanishing = Orbit(orbit.problem, orbit.problem.unknowns.join(orbit.values, durations, orbit.start, []))
    reasons = [r for r in find_violations(vanishing) if r.code == "no_duration"]
    assert [(r.values["number"], r.values["segment"], r.values["duration"]) for r in reasons] == [(2, "s", 1e-14)]


@pytest.mark.parametrize(
    ("level", "direction", "gap", "time"),
    [
        (1.5, "rising", -0.5, TURN / 4),
        (-1.5, "falling", -0.5, 3 * TURN / 4),
        (1.25, "any", -0.25, TURN / 4),
        (-1.25, "any", -0.25, 3 * TURN / 4),
    ],
)
def test_the_closest_approach_is_the_extremum_before_the_surface(level, direction, gap, time):
    orbit = circle(level=level, direction=direction)
    (found,) = find_approaches(orbit)
    assert found.gap == pytest.approx(gap, abs=1e-10)
    assert found.extremum.time == pytest.approx(time, abs=1e-6)
    assert found.event == "e"
    assert find_closest_approach(orbit) is found
    assert find_closest_approach(orbit, "e") is found
    assert find_closest_approach(orbit, "another") is None
    # An extremum that is already followed does not count.
    assert find_closest_approach(orbit, leave_out=("e", 0, found.extremum.time)) is None
    assert find_closest_approach(orbit, leave_out=("e", 0, found.extremum.time + 0.1)) is found


@pytest.mark.parametrize("direction", ["rising", "falling"])
def test_on_the_far_side_of_a_surface_the_other_extremum_comes_near(direction):
    """All of the circle above a rising event: from there it is met by a dip below, at a minimum."""
    level = -1.5 if direction == "rising" else 1.5
    (found,) = find_approaches(circle(level=level, direction=direction))
    assert found.gap == pytest.approx(-0.5, abs=1e-10)
    assert found.extremum.is_max == (direction == "falling")


def test_extrema_that_no_event_can_come_from():
    """From the surface upwards, over the top and down: the maximum is beyond the surface, and the dip is below it."""
    assert find_approaches(circle("s", level=0.5)) == []
    assert find_closest_approach(circle("s", level=0.5)) is None


def test_after_the_way_back_maxima_come_near():
    """From above down through a rising event's surface; two maxima below it later, which might become events."""
    n, base = 12, make_basis(9).base
    t = (np.arange(n)[:, None] + base) / n
    values = np.cos(6 * np.pi * t) - 1.2 + 0.8 * (1 - 2 * t) ** 2
    profile = Profile(9, values, np.zeros(n, dtype=int), np.arange(n) / n, np.full(n, 1 / n))
    found = list(_find_near_crossings(profile, 0, "rising", profile.extrema))
    assert [e.is_max for _, e in found] == [True, True]
    assert [gap for gap, _ in found] == pytest.approx([-0.106, -0.106], abs=0.01)
    # Upside down it is a falling event's.
    upside_down = replace(profile, values=-values)
    again = list(_find_near_crossings(upside_down, 0, "falling", upside_down.extrema))
    assert [gap for gap, _ in again] == pytest.approx([gap for gap, _ in found])


def test_event_functions_along_the_orbit():
    orbit = circle("s", "s", level=0.5)
    profile = find_event_profile(orbit, "e")
    assert find_event_profiles(orbit) == {"e": profile}
    assert profile.ends(0) == pytest.approx((0, 0), abs=1e-12)
    assert profile.duration(1) == pytest.approx(TURN)
    assert profile.start_slope(0) == pytest.approx(np.cos(orbit.start), abs=1e-7)
    assert sorted(e.value for e in profile.extrema) == pytest.approx([-1.5, -1.5, 0.5, 0.5], abs=1e-9)


def test_the_side_that_an_event_is_met_from():
    below, above = circle(level=1.5), circle(level=-1.5)
    for direction, sides in (("rising", (True, True)), ("falling", (False, False)), ("any", (True, False))):
        found = tuple(is_met_from_below(find_event_profile(o, "e"), 0, direction) for o in (below, above))
        assert found == sides
