"""Segments and impacts that die out: touched slowly, at once with others, or not at all."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

from pddecont.bifurcation import find_kind
from pddecont.bifurcation.vanishing import CoincidenceFunction, MeetingFunction, TangencyFunction, list_meetings
from pddecont.model import vanishes_identically
from pddecont.orbit import PeriodicOrbitSystem, measure_orbit
from pddecont.reasons import NO_REASON, make_reason
from pddecont.tables import describe_endings, describe_reason
from tests.bifurcation.runs import free_amplitude, signatures, wall
from tests.conftest import ROOT, model_from
from tests.orbits import settle_to_orbit
from tests.runs import change, labels, monitor, parameter, run, to_yaml


@pytest.mark.parametrize(("free", "limits"), [("wall", [0.1, 1]), ("omega", [1.9, 3])])
def test_a_hard_impact_dies_at_speed_zero_where_the_free_orbit_grazes(tmp_path, free, limits):
    step = run(wall(free, limits), tmp_path / "a.h5").step("c")
    assert "VS1" in labels(step)
    at = parameter(step, free, "VS1")
    if free == "wall":
        assert at == pytest.approx(free_amplitude(2.0), abs=1e-10)
    else:
        assert free_amplitude(at) == pytest.approx(0.2, abs=1e-10)
    assert describe_reason(step.reason(step.row("VS1"))) == "event turns tangential"
    assert signatures(step) == ["flight", "(free)"]
    assert np.all(step.points["admissible"] == 1)
    # The multipliers of a hard impact are unbounded at speed zero, so the impacting orbit loses its stability before,
    # in the same step.
    assert labels(step).index("PD1") < labels(step).index("VS1")


def test_an_event_of_any_direction_turns_tangential_too(tmp_path):
    model = (ROOT / "models" / "wall_oscillator.yaml").read_text().replace("direction: rising", "direction: any")
    assert "direction: any" in model
    (tmp_path / "any.yaml").write_text(model)
    text = wall("wall", [0.1, 1], model=str(tmp_path / "any.yaml"), direction="up")
    step = run(text, tmp_path / "a.h5").step("c")
    assert labels(step) == ["PD1", "VS1"]
    assert parameter(step, "wall", "VS1") == pytest.approx(free_amplitude(2.0), abs=1e-10)
    assert signatures(step) == ["flight", "(free)"]


@pytest.mark.parametrize(("kick", "level"), [(-0.1, 1.0), (0.1, 0.9)])
def test_two_events_that_meet_are_named(tmp_path, kick, level):
    """The neuron's kick comes tau after its spike. A braking kick is overtaken by the next spike when x = 1 without it;
    a driving one
    makes the spike itself when x = 1 with it, and the segment between the two vanishes. Here x = drive (1 - e^-tau)."""
    text = {
        "model": "spiking_neuron",
        "set": {"kick": kick},
        "mesh": {"degree": 9, "tol": 1e-11},
        "steps": [
            {"name": "t", "simulate": {"t_end": 60}},
            {"name": "o", "orbit": {"from": "t"}},
            {
                "name": "c",
                "continue": {
                    "from": "o",
                    "free": ["tau"],
                    "range": {"tau": [0.2, 2]},
                    "direction": "up",
                    "step": {"max": 0.05},
                },
            },
        ],
    }
    step = run(text, tmp_path / "a.h5").step("c")
    assert labels(step) == ["VS1"]
    assert "meets" in describe_reason(step.reason(step.row("VS1")))
    assert parameter(step, "tau", "VS1") == pytest.approx(math.log(1.5 / (1.5 - level)), abs=1e-7)
    assert np.all(step.points["admissible"] == 1)


FAST = {
    "name": "ball_with_a_speed_limit",
    "states": ["y", "v"],
    "parameters": {"G": 0.6, "r": 0.8, "w": 5},
    "forcing": {"period": "2*pi"},
    "modes": {"flight": {"y'": "v", "v'": "G*sin(t) - 1"}},
    "events": {"landing": "y", "fast": "v + w"},
    "resets": {"bounce": {"v": "-r*v"}, "brake": {"v": "-0.9*w"}},
    "segments": {
        "hop": {"mode": "flight", "event": "landing", "direction": "falling", "reset": "bounce", "to": "flight"},
        "limit": {"mode": "flight", "event": "fast", "direction": "falling", "reset": "brake", "to": "flight"},
    },
    "initial": {"y": 0.01, "v": 2.5},
    "run": {
        "mesh": {"degree": 8, "tol": 1e-10},
        "steps": [
            {"name": "t", "simulate": {"t_end": "200*2*pi"}},
            {"name": "o", "orbit": {"from": "t"}},
            {"name": "c", "continue": {"from": "o", "free": ["w"], "range": {"w": [3, 6]}, "direction": "down"}},
            {
                "name": "vs",
                "continue": {
                    "from": {"step": "c", "point": "VS1"},
                    "free": ["w", "r"],
                    "range": {"w": [3, 6], "r": [0.5, 0.95]},
                },
            },
        ],
    },
}


def test_an_event_that_comes_in_at_a_segments_end_is_located(tmp_path):
    """The ball lands at relative speed 2 pi / (1 + r), its largest: the speed limit w is met there, nowhere before."""

    results = run(FAST, tmp_path / "a.h5")
    step = results.step("c")
    assert labels(step) == ["VS1"]
    assert describe_reason(step.reason(step.row("VS1"))) == "landing meets fast"
    assert parameter(step, "w", "VS1") == pytest.approx(2 * math.pi / 1.8, abs=1e-10)
    assert np.all(step.points["admissible"] == 1)
    curve = results.step("vs")
    assert 2 * math.pi / (1 + parameter(curve, "r")) == pytest.approx(parameter(curve, "w"), abs=1e-9)
    assert len(curve) > 10


def test_hard_impacts_of_speed_zero_in_two_parameters(tmp_path):
    """They lie where the free orbit's amplitude 1 / |1 - w^2 + 0.1 i w| is the wall's distance."""
    text = {
        "model": "wall_oscillator",
        "mesh": {"degree": 9, "tol": 1e-11},
        "steps": [
            {"name": "t", "simulate": {"t_end": 300}},
            {"name": "o", "orbit": {"from": "t"}},
            {
                "name": "c",
                "continue": {"from": "o", "free": ["wall"], "range": {"wall": [0.1, 0.5]}, "direction": "up"},
            },
            {
                "name": "vs",
                "continue": {
                    "from": {"step": "c", "point": "VS1"},
                    "free": ["wall", "omega"],
                    "range": {"wall": [0.15, 0.8], "omega": [1.5, 2.6]},
                },
            },
        ],
    }
    step = run(text, tmp_path / "a.h5").step("vs")
    wall, omega = parameter(step, "wall"), parameter(step, "omega")
    assert len(step) > 10
    assert 1 / np.hypot(1 - omega**2, 0.1 * omega) == pytest.approx(wall, abs=1e-9)


STICK_SLIP = {
    "name": "s",
    "states": ["x", "w"],
    "parameters": {"V": 0.5, "c": 0.05, "d": 0.4, "q": 3},
    "modes": {"slip": {"x'": "w - V", "w'": "-x - c*w - 1 + d*(1 - exp(-q*w))"}, "stick": {"x'": "-V", "w'": 0}},
    "events": {"stop": "w", "release": "-x - 1"},
    "resets": {"zero": {"w": 0}},
    "segments": {
        "slip": {"mode": "slip", "event": "stop", "direction": "falling", "reset": "zero", "to": "stick"},
        "stick": {"mode": "stick", "event": "release", "direction": "rising", "to": "slip"},
    },
    "initial": {"mode": "stick", "x": 0, "w": 0},
    "run": {
        "mesh": {"degree": 8, "tol": 1e-10},
        "monitors": {"sticking": "time_in(stick)"},
        "steps": [
            {"name": "t", "simulate": {"t_end": 200}},
            {"name": "o", "orbit": {"from": "t"}},
            {"name": "c", "continue": {"from": "o", "free": ["V"], "range": {"V": [0.1, 0.9]}, "step": {"max": 0.05}}},
        ],
    },
}


def test_slipping_that_begins_where_sticking_held_it_is_no_meeting(tmp_path):
    """Friction is continuous at the release, so that slip begins with speed and acceleration zero, to rounding."""

    def slip(V):
        """Return the time of slip and x at its end."""

        def field(_, y):
            return [y[1] - V, -y[0] - 0.05 * y[1] - 1 + 0.4 * (1 - np.exp(-3 * y[1]))]

        begun = solve_ivp(field, (0, 0.5), [-1.0, 0.0], method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
        stop = lambda _, y: y[1]  # noqa: E731
        stop.terminal, stop.direction = True, -1
        end = solve_ivp(field, (0.5, 20), begun, method="DOP853", rtol=1e-12, atol=1e-13, events=stop)
        return end.t[-1], end.y[0, -1]

    step = run(STICK_SLIP, tmp_path / "a.h5").step("c")
    assert labels(step) == []
    assert all("reached the end of the range" in text for text in describe_endings(step))
    assert np.all(step.points["admissible"] == 1)
    for row in step.order[::5]:
        V = parameter(step, "V")[list(step.order).index(row)]
        time, x = slip(V)
        sticking = (x + 1) / V
        assert step.points["monitors"][row, 0] == pytest.approx(sticking, abs=1e-8)
        assert step.points["period"][row] == pytest.approx(time + sticking, abs=1e-8)


def test_an_event_function_that_a_mode_holds_at_zero_meets_nothing():
    def parse(model):
        return model_from(to_yaml({key: value for key, value in model.items() if key != "run"}))

    model = parse(STICK_SLIP)
    signature = [model.segments["slip"], model.segments["stick"]]
    assert vanishes_identically(model, signature, 0, "stop", at_end=False)
    assert vanishes_identically(model, signature, 1, "stop", at_end=True)
    assert not vanishes_identically(model, signature, 0, "stop", at_end=True)
    moving = parse(change(STICK_SLIP, "modes.stick.w'", 0.1))
    assert not vanishes_identically(
        moving, [moving.segments["slip"], moving.segments["stick"]], 0, "stop", at_end=False
    )


HYSTERESIS = {
    "name": "r",
    "states": ["x", "v"],
    "parameters": {"h": 0.3, "tau": 0.4},
    "modes": {"plus": {"x'": "v", "v'": "-0.2*v - x - 1"}, "minus": {"x'": "v", "v'": "-0.2*v - x + 1"}},
    "events": {"up": "x(t - tau) - h", "down": "x(t - tau) + h"},
    "segments": {
        "pos": {"mode": "plus", "event": "down", "direction": "falling", "to": "minus"},
        "neg": {"mode": "minus", "event": "up", "direction": "rising", "to": "plus"},
    },
    "initial": {"mode": "plus", "x": 1, "v": 0},
    "run": {
        "mesh": {"degree": 6, "tol": 1e-09},
        "monitors": {
            "top": "max(x)",
            "late_top": "max(x(t - tau))",
            "square": "mean(x**2)",
            "late_square": "mean(x(t - tau)**2)",
        },
        "steps": [
            {"name": "t", "simulate": {"t_end": 200}},
            {"name": "o", "orbit": {"from": "t"}},
            {"name": "c", "continue": {"from": "o", "free": ["h"], "range": {"h": [-0.5, 1]}, "stability": True}},
            {
                "name": "tangent",
                "continue": {
                    "from": {"step": "c", "point": "VS1"},
                    "free": ["tau", "h"],
                    "range": {"tau": [0.1, 1], "h": [-1, 1]},
                    "step": {"max": 0.2},
                },
            },
        ],
    },
}


def test_a_delayed_event_turns_tangential_where_its_closed_form_says(tmp_path):
    """Only the events read the delayed state: it has kinks where the mesh needs no edges, a delay after switching."""
    flow = np.array([[0.0, 1.0], [-1.0, -0.2]])

    def late(half, tau):
        """States a time tau before the end of a half period of a symmetric orbit in which x'' + 0.2 x' + x = -1."""

        def pushed(t):
            return np.linalg.solve(flow, (expm(flow * t) - np.eye(2)) @ np.array([0.0, -1.0]))

        start = np.linalg.solve(-np.eye(2) - expm(flow * half), pushed(half))
        return expm(flow * (half - tau)) @ start + pushed(half - tau)

    def touch(tau, near):
        """Half period and h of the orbit whose x(t - tau) meets -h with speed zero."""
        half = brentq(lambda T: late(T, tau)[1], 0.97 * near, 1.03 * near, xtol=1e-15)
        return half, -late(half, tau)[0]

    results = run(HYSTERESIS, tmp_path / "a.h5")
    branch, curve = results.step("c"), results.step("tangent")
    assert "VS1" in labels(branch)
    assert not any("WARNING" in text for text in describe_endings(branch))
    for step in (branch, curve):
        assert np.all(step.points["admissible"] == 1)
        assert monitor(step, "late_top") == pytest.approx(monitor(step, "top"), abs=1e-8)
        assert monitor(step, "late_square") == pytest.approx(monitor(step, "square"), abs=1e-8)
    half, h = touch(0.4, branch.points["period"][branch.row("VS1")] / 2)
    assert parameter(branch, "h", "VS1") == pytest.approx(h, abs=1e-8)
    assert branch.points["period"][branch.row("VS1")] == pytest.approx(2 * half, abs=1e-7)
    for row in range(len(curve)):
        tau, period = curve.points["parameters"][row, 1], curve.points["period"][row]
        assert curve.points["parameters"][row, 0] == pytest.approx(touch(tau, period / 2)[1], abs=1e-7)


NO_RUN = {key: value for key, value in FAST.items() if key != "run"}


@pytest.fixture(scope="module")
def fast_orbit():
    """The ball with a speed limit of 5, which it does not reach: it lands at 2 pi / (1 + r)."""
    return settle_to_orbit(NO_RUN, t_end="200*2*pi", mesh={"degree": 8, "tol": 1e-9})


def evaluate(function, orbit):
    return function.evaluate(PeriodicOrbitSystem(orbit.problem, measure_orbit(orbit)).at(orbit.x))


def test_events_that_may_come_in_are_watched_at_both_ends_of_a_segment(fast_orbit):
    found = list_meetings(fast_orbit.signature)
    assert found == [MeetingFunction(0, "fast", "falling", True), MeetingFunction(0, "fast", "falling", False)]
    # v + w at its end is the limit less the speed of landing, at its start the same with the speed of leaving.
    speed = 2 * math.pi / 1.8
    assert evaluate(found[0], fast_orbit) == pytest.approx(5.0 - speed, abs=1e-8)
    assert evaluate(found[1], fast_orbit) == pytest.approx(5.0 + 0.8 * speed, abs=1e-8)
    assert found[0].update_at(None) is found[0]


def test_an_event_that_is_not_crossed_in_its_direction_does_not_come_in(fast_orbit):
    rising = MeetingFunction(0, "fast", "rising", True)
    assert math.isnan(evaluate(rising, fast_orbit))
    any_way = MeetingFunction(0, "fast", "any", True)
    assert evaluate(any_way, fast_orbit) == evaluate(MeetingFunction(0, "fast", "falling", True), fast_orbit)


def test_rates_and_durations_as_defining_functions(fast_orbit):
    assert evaluate(TangencyFunction(0), fast_orbit) == pytest.approx(2 * math.pi / 1.8, abs=1e-8)
    assert evaluate(CoincidenceFunction(0, 1.5), fast_orbit) == pytest.approx(2 * math.pi - 1.5, abs=1e-12)


def test_along_a_branch_touching_and_meeting_are_tested(fast_orbit):
    at = PeriodicOrbitSystem(fast_orbit.problem, measure_orbit(fast_orbit)).at(fast_orbit.x)
    tests = find_kind("VS").branch_tests(at, None)
    reasons = [describe_reason(test.reason) for test in tests]
    assert reasons == ["event turns tangential", "landing meets fast", "landing meets fast"]
    assert tests[0].value(SimpleNamespace(at=at)) == pytest.approx(2 * math.pi / 1.8, abs=1e-8)


def test_what_vanishes_is_told_from_the_orbit(fast_orbit, far_orbit):
    """An orbit where no segment, no rate and no difference is small can only be a grazing."""
    far = PeriodicOrbitSystem(far_orbit.problem, measure_orbit(far_orbit)).at(far_orbit.x)
    assert find_kind("VS").define(far, None, NO_REASON).event == "hit"
    assert find_kind("VS").good_side(None) == 1.0


def test_an_event_called_meets_changes_nothing(tmp_path):
    """Reasons are data, not words: a name that is a word of a message has no meaning."""

    def renamed(name):
        short = [*FAST["run"]["steps"][:3], change(FAST["run"]["steps"][3], "continue.max_points", 5)]
        segment = {**FAST["segments"]["limit"], "event": name}
        model = {**FAST, "events": {"landing": "y", name: "v + w"}}
        model = change(change(model, "segments.limit", segment), "run.steps", short)
        model = change(model, "run.mesh", {"degree": 6, "intervals": 6})
        return run(model, tmp_path / f"{name}.h5")

    one, other = renamed("fast"), renamed("meets")
    for step in ("c", "vs"):
        a, b = one.step(step), other.step(step)
        assert a.labels == b.labels
        for key, values in a.points.items():
            assert np.array_equal(values, b.points[key], equal_nan=values.dtype.kind == "f"), key
        for key in ("states", "unknowns", "tangent", "signature"):
            assert np.array_equal(a.orbits[key], b.orbits[key]), key
    found = other.step("c")
    assert labels(found) == ["VS1"] and len(other.step("vs")) > 5
    assert found.reason(found.row("VS1")) == make_reason("meeting", event="landing", other="meets")
    assert describe_reason(found.reason(found.row("VS1"))) == "landing meets meets"
    assert describe_endings(found)[0].replace("meets meets", "meets fast") == describe_endings(one.step("c"))[0]
