"""Impacts that accumulate, in orbits: a ball on a shaken table, and an oscillator pressed on a stop."""

import math

import numpy as np
import pytest
import yaml
from scipy.integrate import solve_ivp

from pddecont.bifurcation.chatter import find_last_part
from pddecont.model import expand_model
from tests.bifurcation.bouncing import find_last_rest, list_impacts
from tests.conftest import model_from
from tests.runs import change, labels, monitor, multipliers, parameter, run

SETTLE = [{"name": "t", "simulate": {"t_end": "20*2*pi"}}, {"name": "o", "orbit": {"from": "t", "stability": True}}]
BOTH_WAYS = {"name": "c", "continue": {"from": "o", "free": ["G"], "range": {"G": [0.9, 3]}, "stability": True}}
TABLE = {
    "name": "table",
    "states": ["y", "v"],
    "parameters": {"G": 1.3, "r": 0.5},
    "forcing": {"period": "2*pi"},
    "modes": {"flight": {"y'": "v", "v'": "G*sin(t) - 1"}, "lie": {"y'": 0, "v'": 0}},
    "events": {"landing": "y", "lift": "G*sin(t) - 1"},
    "resets": {"bounce": {"v": "-r*v"}},
    "segments": {
        "hop": {"mode": "flight", "event": "landing", "direction": "falling", "reset": "bounce", "to": "flight"},
        "lift": {"mode": "lie", "event": "lift", "direction": "rising", "to": "flight"},
    },
    "initial": {"y": 0.01, "v": 0.1},
    "run": {"monitors": {"rest": "time_in(lie)"}, "steps": [*SETTLE, BOTH_WAYS]},
}
RESTING = change(TABLE, "segments.hop.rest", "lie")
STICKING = change(TABLE, "run.steps.0.simulate.stick", {"landing": "lie"})
EQUATIONS = {
    **{key: TABLE[key] for key in ("name", "states", "parameters", "forcing", "initial")},
    "equations": {"y'": "v", "v'": "G*sin(t) - 1"},
    "jumps": {"stop": {"at": "y", "direction": "falling", "reset": {"v": "-r*v"}, "rest": True}},
    "run": {"monitors": {"rest": "time_in(stop_rest)"}, "steps": [*SETTLE, BOTH_WAYS]},
}


def only_orbit(model):
    return change(model, "run.steps", model["run"]["steps"][:2])


def event_times(step, row=0):
    """Return the times of an orbit's events from the end of its rest, and its segments' names in that order."""
    orbit = step.orbit(row)
    names = orbit["signature"].tobytes().decode().split()
    released = next(k for k, name in enumerate(names) if names[k - 1].count(">")) + 1
    durations = np.roll(orbit["unknowns"][: len(names)], -released)
    return np.cumsum(durations), names[released:] + names[:released]


@pytest.fixture(scope="module")
def resting(tmp_path_factory):
    return run(RESTING, tmp_path_factory.mktemp("rest") / "a.h5")


def test_impacts_happen_when_closed_form_flights_end(resting):
    times, names = event_times(resting.step("o"))
    exact, end = list_impacts("1.3", "0.5")
    impacts = np.array([t for t, _ in exact]) - math.asin(1 / 1.3)
    n = names.index("hop>lie") + 1
    assert n > 20
    assert times[:n] == pytest.approx(impacts[:n], abs=1e-10)
    assert names[:n] == ["hop"] * (n - 1) + ["hop>lie"]
    # Impacts that are not followed last as long as a geometric series says.
    assert monitor(resting.step("o"), "rest")[0] == pytest.approx(math.asin(1 / 1.3) + 2 * math.pi - end, abs=1e-10)
    assert impacts[n - 1] < impacts[-1] - 1e-9


def test_what_comes_to_rest_forgets_where_it_began(resting):
    step = resting.step("c")
    rows = [row for row in range(len(step)) if b"hop" in step.orbit(row)["signature"].tobytes()]
    assert len(rows) > 20
    for row in rows:
        # A nilpotent matrix of two rows: its eigenvalues are the root of rounding.
        assert np.max(np.abs(multipliers(step, row)), initial=0.0) < 1e-6


def test_a_branch_ends_where_impacts_accumulate_just_at_the_release(resting):
    step = resting.step("c")
    assert labels(step) == ["VS1", "VS2"]
    assert parameter(step, "G", "VS2") == pytest.approx(find_last_rest("0.5", "1.55", "1.7"), abs=1e-11)
    assert monitor(step, "rest", "VS2") == pytest.approx(0, abs=1e-8)
    assert step.reason(step.row("VS2")).code == "released"
    # Towards G = 1 all flights vanish together; below, the ball lies on the table.
    assert parameter(step, "G", "VS1") == pytest.approx(1, abs=1e-11)
    assert parameter(step, "G").min() == 0.9
    assert np.all(step.points["verified"] == 1)


def test_times_at_rest_along_the_branch_are_those_of_the_ball(resting):
    step = resting.step("c")
    for G, rest in list(zip(parameter(step, "G"), monitor(step, "rest"), strict=True))[::4]:
        release = math.asin(1 / G) if G > 1 else 0.0
        expected = release + 2 * math.pi - list_impacts(repr(float(G)), "0.5")[1] if G > 1.001 else None
        if expected is not None and G < 1.59:
            assert rest == pytest.approx(expected, abs=1e-9)


def test_what_a_step_says_of_rest_is_what_a_model_says(resting, tmp_path):
    there = run(STICKING, tmp_path / "a.h5").step("c")
    here = resting.step("c")
    assert parameter(there, "G") == pytest.approx(parameter(here, "G"), abs=1e-12)
    assert there.orbit(3)["signature"].tobytes() == here.orbit(3)["signature"].tobytes()


def test_equations_give_the_numbers_of_the_model_by_hand(resting, tmp_path):
    derived = run(EQUATIONS, tmp_path / "a.h5")
    here, there = (event_times(results.step("o"))[0] for results in (derived, resting))
    assert here == pytest.approx(there, abs=1e-12)
    expanded = {**expand_model(model_from(EQUATIONS)), "run": EQUATIONS["run"]}
    step, hand = derived.step("c"), run(yaml.safe_load(yaml.safe_dump(expanded)), tmp_path / "b.h5").step("c")
    assert parameter(step, "G") == pytest.approx(parameter(hand, "G"), abs=1e-12)
    assert monitor(step, "rest") == pytest.approx(monitor(hand, "rest"), abs=1e-12)
    assert step.labels == hand.labels


def test_a_ball_at_rest_begins_to_leave_where_it_weighs_nothing(tmp_path):
    """From rest: G sin t touches 1 at G = 1, beyond it hops; an orbit that ceases to hop at once is none."""
    model = change(change(EQUATIONS, "parameters.G", 0.8), "run.steps.2.continue.range.G", [0.5, 1.3])
    step = run(model, tmp_path / "a.h5").step("c")
    assert labels(step) == ["GR1"]
    assert parameter(step, "G", "GR1") == pytest.approx(1, abs=1e-12)
    last = step.order[-1]
    names = step.orbit(int(last))["signature"].tobytes().decode().split()
    assert parameter(step, "G")[-1] == 1.3
    assert names.count("stop") > 15
    assert monitor(step, "rest")[-1] == pytest.approx(
        math.asin(1 / 1.3) + 2 * math.pi - list_impacts("1.3", "0.5")[1], abs=1e-9
    )


@pytest.mark.parametrize("r", [0.1, 0.5, 0.9])
def test_the_last_part_repeats_itself(r):
    """With u'' = -s until s = 0: flights that begin at the part x of the time left go on to do so."""
    x = find_last_part(r)
    # Speed w s^2 with s = 1 left; the flight ends where w x - x^2/2 + x^3/6 = 0.
    w = x / 2 - x**2 / 6
    came = -(w - x + x**2 / 2)
    assert r * came / (1 - x) ** 2 == pytest.approx(w, rel=1e-12)


PRESSED = {
    "name": "pressed",
    "states": ["x", "v"],
    "parameters": {"om": 0.5, "F": 1.0, "c": 0.1, "d": -0.3, "r": 0.6},
    "forcing": {"period": "2*pi/om"},
    "equations": {"x'": "v", "v'": "F*cos(om*t) - c*v - x"},
    "jumps": {"stop": {"at": "x - d", "direction": "rising", "reset": {"v": "-r*v"}, "rest": True}},
    "initial": {"x": -0.5},
    "run": {
        "monitors": {"depth": "min(x)"},
        "steps": [{"name": "t", "simulate": {"t_end": "20*2*pi/om"}}, {"name": "o", "orbit": {"from": "t"}}],
    },
}


def bounce_off(om, F, c, d, r):
    """Return times after the release at which an oscillator, let go at a stop that it is pressed on, comes back."""
    release = math.acos(d / F) / om
    fall = lambda t, z: [z[1], F * math.cos(om * t) - c * z[1] - z[0]]  # noqa: E731
    stop = lambda t, z: z[0] - d  # noqa: E731
    stop.terminal, stop.direction = True, 1
    t, z, found = release, [d, 0.0], []
    while True:
        # Let go with a push of its own force, it leaves the surface within rounding.
        path = solve_ivp(fall, (t, t + 40), z, method="DOP853", rtol=1e-13, atol=1e-15, events=stop, first_step=1e-3)
        t, z = path.t_events[0][0], path.y_events[0][0]
        found.append(t - release)
        if z[1] < 1e-2:
            return np.array(found)
        z = [d, -r * z[1]]


def test_an_oscillator_pressed_on_a_stop_bounces_as_its_integration_says(tmp_path):
    times, names = event_times(run(PRESSED, tmp_path / "a.h5").step("o"))
    expected = bounce_off(0.5, 1.0, 0.1, -0.3, 0.6)
    assert len(expected) > 5
    assert times[: len(expected)] == pytest.approx(expected, abs=1e-9)
    assert names[-1] == "stop_off"


def test_what_is_pressed_on_a_stop_leaves_where_the_force_changes_sign(tmp_path):
    """F cos(om t) - d has the sign of its pressure: it touches zero at F = |d|."""
    steps = [{"name": "c", "continue": {"from": "o", "free": ["F"], "range": {"F": [0.1, 0.6]}}}]
    model = change(change(PRESSED, "parameters.F", 0.2), "run.steps", [*PRESSED["run"]["steps"], *steps])
    step = run(model, tmp_path / "a.h5").step("c")
    assert labels(step) == ["GR1"]
    assert parameter(step, "F", "GR1") == pytest.approx(0.3, abs=1e-12)
    assert parameter(step, "F")[-1] == 0.6


def test_an_impact_without_rebound_rests_at_once(tmp_path):
    model = only_orbit(change(EQUATIONS, "parameters.r", 0))
    times, names = event_times(run(model, tmp_path / "a.h5").step("o"))
    first = list_impacts("1.3", "0.5")[0][0][0]
    assert names == ["stop>stop_rest", "stop_off"]
    assert times[0] == pytest.approx(first - math.asin(1 / 1.3), abs=1e-11)
