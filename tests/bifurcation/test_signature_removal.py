"""Segments removed where they vanish."""

import math

import numpy as np
import pytest

from pddecont.bifurcation import BranchSettings
from pddecont.bifurcation.grazing import define_grazing
from pddecont.bifurcation.period_doubling import guess_doubled_orbit
from pddecont.bifurcation.signature_removal import find_way_off, make_shorter_system, remove_segment
from pddecont.collocation import MeshRule
from pddecont.errors import ConvergenceError
from tests.bifurcation.runs import SOFT_WALLS, follow, signatures, walls
from tests.orbits import settle_to_orbit
from tests.runs import change, labels, monitor, parameter, run


def test_a_grazing_curve_ends_where_another_contact_vanishes(tmp_path):
    """Between two soft walls the orbit that hits the nearer touches the farther; where both are as far, both are only
    touched.
    """
    curve = follow("gr", ("c", "GR1"), {"omega": [1.7, 2.4], "b": [0.29, 0.35]})
    step = run(walls(SOFT_WALLS, 0.31, curve), tmp_path / "a.h5").step("gr")
    assert labels(step) == ["VS1"]
    assert parameter(step, "b", "VS1") == pytest.approx(0.3, abs=1e-9)
    assert 1 / math.hypot(
        1 - parameter(step, "omega", "VS1") ** 2, 0.1 * parameter(step, "omega", "VS1")
    ) == pytest.approx(0.3, abs=1e-9)


TICKS = {
    "name": "ticks",
    "states": ["x", "v"],
    "parameters": {"w": "START", "r": 0.8, "tau": 0.6},
    "modes": {"free": {"x'": "v", "v'": "0.5*(1 - x**2)*v - x + 0.1*x(t - tau)"}},
    "events": {"hit": "x - w", "tick": "x"},
    "resets": {"b": {"v": "-r*v"}, "same": {}},
    "segments": {
        "hop": {"mode": "free", "event": "hit", "direction": "rising", "reset": "b", "to": "free"},
        "tick": {"mode": "free", "event": "tick", "direction": "falling", "reset": "same", "to": "free"},
    },
    "initial": {"mode": "free", "x": 0.5, "v": 0},
    "run": {
        "mesh": {"degree": 9, "tol": 1e-10},
        "monitors": {"top": "max(x)"},
        "steps": [
            {"name": "t", "simulate": {"t_end": 200}},
            {"name": "o", "orbit": {"from": "t"}},
            {"name": "c", "continue": {"from": "o", "free": ["w"], "range": {"w": [1.7, 2.3]}}},
        ],
    },
}


def test_an_event_that_does_nothing_does_not_mislead(tmp_path):
    """An autonomous orbit leaves a wall and comes to it; it also ticks as x falls through zero. It goes the right way
    from both sides.
    """
    away = run(change(TICKS, "parameters.w", 1.83), tmp_path / "a.h5").step("c")
    towards = run(change(TICKS, "parameters.w", 2.2), tmp_path / "b.h5").step("c")
    assert sorted(labels(away)) == ["LP1", "VS1"]
    assert sorted(labels(towards)) == ["GR1", "LP1"]
    touch = parameter(away, "w", "VS1")
    assert parameter(towards, "w", "GR1") == pytest.approx(touch, abs=1e-10)
    assert monitor(towards, "top", "EP2") == pytest.approx(touch, abs=1e-9)
    assert parameter(away, "w", "LP1") == pytest.approx(parameter(towards, "w", "LP1"), abs=1e-9)
    for step in (away, towards):
        assert sorted(signatures(step)) == ["hop tick", "tick"]
        assert np.all(step.points["admissible"] == 1)
        assert {parameter(step, "w", "EP1"), parameter(step, "w", "EP2")} == {1.7, 2.3}


RULE = MeshRule(8, tol=1e-9)


def motion(orbit, times):
    """Return the states of an orbit at physical times."""
    return orbit.mesh.interpolate(orbit.values, orbit.mesh.locate(orbit.theta, (times - orbit.start) % orbit.period)[0])


@pytest.mark.parametrize(("name", "mode"), [("soft_orbit", "NC"), ("hop_orbit", "free")])
def test_what_is_left_of_one_contact_is_an_orbit_without_events(name, mode, request):
    orbit = request.getfixturevalue(name)
    shorter = remove_segment(orbit, RULE, 0)
    assert shorter.signature.names == [f"({mode})"] and not shorter.signature.has_events
    assert shorter.period == pytest.approx(orbit.period, rel=1e-12)
    assert shorter.problem.n_periods == orbit.problem.n_periods
    # It moves as before, away from what is left out.
    times = orbit.start + np.linspace(0.1, 0.9, 20) * orbit.durations[0]
    assert motion(shorter, times) == pytest.approx(motion(orbit, times), abs=2e-3)


def test_the_rest_of_the_segments_stays(soft_orbit):
    """[NC C NC C], the second contact of the orbit taken twice left out."""
    twice = guess_doubled_orbit(soft_orbit, RULE)[0]
    shorter = remove_segment(twice, RULE, 2)
    assert shorter.signature.names == ["NC", "C"]
    assert shorter.durations == pytest.approx([twice.period - twice.durations[1], twice.durations[1]], rel=1e-12)
    first = remove_segment(twice, RULE, 0)
    assert first.signature.names == ["NC", "C"]
    assert first.durations == pytest.approx(shorter.durations, rel=1e-12)


THREE = {
    "name": "three",
    "states": ["x"],
    "parameters": {"a": 1},
    "modes": {"up": {"x'": "a"}, "down": {"x'": -1}, "fast": {"x'": -2}},
    "events": {"top": "x - 1", "middle": "x - 0.5", "bottom": "x"},
    "segments": {
        "U": {"mode": "up", "event": "top", "direction": "rising", "to": "down"},
        "D": {"mode": "down", "event": "middle", "direction": "falling", "to": "fast"},
        "F": {"mode": "fast", "event": "bottom", "direction": "falling", "to": "up"},
    },
    "initial": {"mode": "up", "x": 0.2},
}


def test_a_mode_after_which_the_orbit_goes_on_elsewhere_cannot_be_left_out():
    orbit = settle_to_orbit(THREE, t_end=20, mesh={"degree": 4, "intervals": 6})
    assert orbit.period == pytest.approx(1.75, abs=1e-12)
    s = orbit.signature.names.index("U")
    with pytest.raises(ConvergenceError, match="mode 'down' vanishes, but the orbit does not go on in mode 'up'"):
        remove_segment(orbit, RULE, s)


def test_the_shorter_system_has_the_same_sizes_and_parameters(hop_orbit):
    system, orbit = BranchSettings(("wall",), ((0.1, 0.9),), RULE).make_system(hop_orbit)
    shorter, guess = make_shorter_system(system.at(orbit.x), RULE, 0)
    assert shorter.sizes is system.sizes and guess.problem.free == ("wall",)
    assert guess.free == pytest.approx(orbit.free) and guess.signature.names == ["(free)"]


def test_the_way_off_a_grazing_comes_free(far_orbit):
    """Away from a wall at the amplitude: the wall moves on, and the gap becomes negative."""
    system, orbit = BranchSettings(("wall",), ((0.1, 0.9),), RULE).make_system(far_orbit)
    at = system.at(orbit.x)
    direction = find_way_off(system, at)
    gaps = [define_grazing(orbit).evaluate(system.at(at.x + k * 1e-3 * direction)) for k in (-1, 0, 1)]
    assert gaps[0] > gaps[1] > gaps[2]
    assert direction[-1] > 0.0
