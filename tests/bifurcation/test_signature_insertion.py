"""Segments inserted at grazings: the orbits beyond, and in which order they are entered."""

import math

import numpy as np
import pytest

from pddecont.bifurcation import BranchSettings
from pddecont.bifurcation.crossing_rates import find_crossing_rate
from pddecont.bifurcation.signature_insertion import enter_signature, find_touches, find_way_back, set_duration
from pddecont.collocation import MeshRule
from pddecont.errors import ConvergenceError
from tests.bifurcation.runs import CHAIN_GRAZING, HARD_WALLS, SOFT_WALLS, free_amplitude, signatures, wall, walls
from tests.conftest import model_from
from tests.runs import labels, parameter, run, to_yaml


def test_both_signatures_meet_in_the_grazing_orbit(fig4_7):
    """Just past the grazing K grows as the square of the small contact's duration, as shooting gives it: d = .01 and
    .05.
    """
    step = fig4_7.step("c")
    past = [i for i in step.order if step.orbit(i)["signature"].tobytes() == b"NC C NC C"]
    d = np.array([min(step.orbit(i)["unknowns"][[1, 3]]) for i in past])
    K = step.points["parameters"][past, step.meta["parameters"].index("K")]
    shooting_d = np.array([0.0, 0.01, 0.03, 0.05, 0.075, 0.085])
    shooting_K = np.array(
        [CHAIN_GRAZING, 0.174752343075, 0.174785826696, 0.174832023855, 0.1748804862573, 0.1748902696928]
    )
    expected = np.polynomial.Polynomial.fit(shooting_d, shooting_K, 5)(d)
    inside = d < 0.085
    assert np.sum(inside) > 0
    assert K[inside] == pytest.approx(expected[inside], abs=2e-8)


def test_the_free_orbit_grazes_a_hard_wall_and_the_new_family_turns_back(tmp_path):
    text = wall("wall", [0.1, 0.6], changes={"wall": 0.5}, direction="down")
    step = run(text, tmp_path / "a.h5").step("c")
    assert labels(step) == ["PD1", "GR1"]
    assert parameter(step, "wall", "GR1") == pytest.approx(free_amplitude(2.0), abs=1e-10)
    assert signatures(step) == ["flight", "(free)"]
    speeds = [step.orbit(i)["states"][-1, 1] for i in step.order if step.orbit(i)["signature"].tobytes() == b"flight"]
    assert min(speeds) > 0


def test_chattering_adds_impacts_one_by_one(tmp_path):
    """Down in the wall's place ever more low impacts are born at grazings; each orbit is admissible."""
    text = wall("wall", [-1, 0.3], direction="down", max_points=100)
    step = run(text, tmp_path / "a.h5").step("c")
    counts = [len(name.split()) for name in signatures(step)]
    assert max(counts) >= 4
    assert np.all(np.abs(np.diff(counts)) == 1)
    assert np.mean(step.points["admissible"] == 1) == 1


@pytest.mark.parametrize(
    ("model", "b", "step", "last"),
    [
        (SOFT_WALLS, 0.3, {}, "FL LF FR RF"),
        (HARD_WALLS, 0.3, {}, "left right"),
        (HARD_WALLS, 0.33, {}, "left right"),
        (HARD_WALLS, 0.33, {"initial": 0.3, "max": 0.5}, "left right"),
    ],
)
def test_two_walls_touched_at_once_or_in_one_step(tmp_path, model, b, step, last):
    """The free orbit reaches both walls: at once if they are as far, else one after the other, in small steps and in
    large ones.
    """

    branch = run(walls(model, b, step=step), tmp_path / "a.h5").step("c")
    grazings = [name for name in labels(branch) if name.startswith("GR")]
    assert len(grazings) == (1 if b == 0.3 else 2)
    touch = max(parameter(branch, "omega", name) for name in grazings)
    assert free_amplitude(touch) == pytest.approx(0.3, abs=1e-10)
    assert sorted(signatures(branch)[0].split()) == sorted(last.split())
    assert np.all(branch.points["admissible"] == 1)


RULE = MeshRule(8, tol=1e-9)


def parse(model):
    return model_from(to_yaml({key: value for key, value in model.items() if key != "run"}))


@pytest.mark.parametrize(("touched", "back"), [("FR", ["RF"]), ("FL", ["LF"])])
def test_the_way_back_is_through_the_mode_that_is_entered(touched, back):
    segments = parse(SOFT_WALLS).segments
    found = find_way_back(parse(SOFT_WALLS), segments["FR"], segments[touched])
    assert [segment.name for segment in found] == back


def test_a_hard_wall_leads_back_at_once():
    model = parse(HARD_WALLS)
    assert find_way_back(model, model.segments["left"], model.segments["right"]) == []


LOOPS = {
    "name": "loops",
    "states": ["x"],
    "modes": {name: {"x'": 1} for name in ("A", "B", "C", "D")},
    "events": {"e": "x - 1", "f": "x - 2"},
    "segments": {
        "AB": {"mode": "A", "event": "e", "direction": "rising", "to": "B"},
        "AD": {"mode": "A", "event": "f", "direction": "rising", "to": "D"},
        "BCf": {"mode": "B", "event": "f", "direction": "rising", "to": "C"},
        "BCe": {"mode": "B", "event": "e", "direction": "falling", "to": "C"},
        "CB": {"mode": "C", "event": "e", "direction": "falling", "to": "B"},
        "CA": {"mode": "C", "event": "f", "direction": "falling", "to": "A"},
    },
}


def test_the_shortest_way_back_goes_by_the_same_event_before_others():
    model = parse(LOOPS)
    found = find_way_back(model, model.segments["AB"], model.segments["AB"])
    assert [segment.name for segment in found] == ["BCe", "CA"]


def test_from_a_dead_end_no_way_leads_back():
    model = parse(LOOPS)
    assert find_way_back(model, model.segments["AB"], model.segments["AD"]) is None


def test_a_touch_is_at_the_maximum(far_orbit):
    (touch,) = find_touches(far_orbit)
    phase = np.angle(1 / (1 - 4.0 + 0.2j))
    assert (touch.s, touch.touched.name, touch.back) == (0, "flight", ())
    assert touch.time == pytest.approx((-phase / 2 - far_orbit.start) % math.pi, abs=1e-7)


def test_an_orbit_that_watches_nothing_touches_nothing(free_orbit):
    with pytest.raises(ConvergenceError, match="no event is touched here"):
        find_touches(free_orbit)


@pytest.fixture(scope="module")
def grazing(far_orbit):
    """The free orbit that touches a hard wall, which lies at its amplitude, with the wall free."""
    system, orbit = BranchSettings(("wall",), ((0, 1),), RULE).make_system(far_orbit)
    return system.at(np.append(orbit.x[:-1], free_amplitude(2.0)))


def test_a_grazing_orbit_is_one_with_an_impact_of_speed_zero(grazing):
    found = enter_signature(grazing, RULE)
    assert found.at.orbit.signature.names == ["flight"]
    assert found.at.orbit.period == pytest.approx(math.pi, abs=1e-12)
    assert np.max(np.abs(found.at.residual)) < 1e-6
    assert abs(find_crossing_rate(found.at.orbit, 0)) < 1e-3
    # It goes on to where the impact has a speed.
    ahead = found.system.at(found.x + 1e-3 * found.tangent).orbit
    assert find_crossing_rate(ahead, 0) > find_crossing_rate(found.at.orbit, 0)


def test_a_segment_gets_the_duration_that_is_asked_for(soft_orbit):
    system, orbit = BranchSettings(("K",), ((0, 0.3),), RULE).make_system(soft_orbit)
    longer = 1.001 * orbit.durations[1]
    found = set_duration(system, orbit.x, 1, longer).at.orbit
    assert found.durations[1] == longer
    assert found.period == pytest.approx(orbit.period, rel=1e-12)
    assert abs(found.free[0] - orbit.free[0]) > 1e-6
