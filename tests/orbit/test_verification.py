"""Orbits simulated from their own past: what is a motion of the model, what is not, and what it does instead."""

from dataclasses import replace

import numpy as np
import pytest

from pddecont.collocation import MeshRule
from pddecont.delay import Chebyshev, Direct
from pddecont.orbit import Orbit, Referee, Verification, find_violation, solve_orbit
from pddecont.orbit import verification as module
from tests.orbit.exact import circle
from tests.orbits import settle_to_orbit

FINE = MeshRule(10, tol=1e-11)
# A neuron that fires at 1, rests for R, and is kicked tau after it has fired, where it does not rest any more.
REFRACTORY = {
    "name": "refractory",
    "states": ["x"],
    "parameters": {"I": 1.5, "tau": 0.2, "R": 0.4, "J": 0.2},
    "modes": {"go": {"x'": "I - x"}, "ref": {"x'": "-x"}},
    "events": {"spike": "x - 1", "rec": {"after": "spike", "delay": "R"}, "kick": {"after": "spike", "delay": "tau"}},
    "resets": {"fire": {"x": 0.1}, "push": {"x": "x*0.7 + J"}},
    "segments": {
        "rest": {"mode": "go", "event": "spike", "direction": "rising", "reset": "fire", "to": "ref"},
        "refr": {"mode": "ref", "event": "rec", "to": "go"},
        "hit": {"mode": "go", "event": "kick", "reset": "push", "to": "go"},
    },
    "initial": {"mode": "go", "x": 0},
}
# The delayed value of a state that jumps is carried over 0.5 for d < 0.5: that is the event.
ECHO = {
    "name": "echo",
    "states": ["x", "y"],
    "parameters": {"I": 1.5, "tau": 0.3, "d": 0.7},
    "modes": {"go": {"x'": "I - x", "y'": "-y + 1 + 0.1*x(t - tau)"}},
    "events": {"spike": "x - 1", "echo": "x(t - tau) - 0.5"},
    "resets": {"fire": {"x": "d"}, "push": {"y": "y + 1"}},
    "segments": {
        "rest": {"mode": "go", "event": "spike", "direction": "rising", "reset": "fire", "to": "go"},
        "hit": {"mode": "go", "event": "echo", "direction": "falling", "reset": "push", "to": "go"},
    },
    "initial": {"mode": "go", "x": 0.7, "y": 0},
}
# A block on which dry friction acts, without a mode for sticking.
FRICTION = {
    "name": "friction",
    "states": ["x", "v"],
    "parameters": {"om": 0.9, "f0": 1.5},
    "forcing": {"period": "2*pi/om"},
    "modes": {
        "plus": {"x'": "v", "v'": "-x - 0.1*v + f0*cos(om*t) - 1"},
        "minus": {"x'": "v", "v'": "-x - 0.1*v + f0*cos(om*t) + 1"},
    },
    "events": {"turn": "v"},
    "segments": {
        "P": {"mode": "plus", "event": "turn", "direction": "falling", "to": "minus"},
        "M": {"mode": "minus", "event": "turn", "direction": "rising", "to": "plus"},
    },
    "initial": {"mode": "plus", "x": 0, "v": 5},
}


def verify(orbit, *, strict=True):
    return Referee(orbit.numeric, orbit.problem.delay).verify(orbit, strict=strict)


def follow(orbit, name, value, n=6):
    """Return the orbit of the same signature of a forced model at another value of its frequency."""
    k = orbit.numeric.parameter_index(name)
    for step in np.linspace(orbit.parameters[k], value, n)[1:]:
        p = orbit.parameters.copy()
        stretch, p[k] = p[k] / step, step
        problem = replace(orbit.problem, parameters=p)
        x = problem.unknowns.join(orbit.values, orbit.durations * stretch, orbit.start * stretch, orbit.free)
        orbit = solve_orbit(Orbit(problem, x), FINE).at.orbit
    return orbit


def with_parameters(orbit, **values):
    """Return the unknowns of an orbit at other parameters."""
    free = orbit.with_free(tuple(values))
    x = free.x.copy()
    x[free.problem.unknowns.free] = list(values.values())
    return Orbit(free.problem, x)


@pytest.mark.parametrize("names", [(), ("s",), ("s", "s")])
@pytest.mark.parametrize("method", [Direct(), Direct(track=False), Chebyshev(12)])
def test_a_motion_of_the_model_is_confirmed(names, method):
    found = verify(circle(*names, level=0.5 if names else 1.5, method=method))
    assert found.verified == 1
    assert found.deviation < 1e-7


def test_delayed_values_of_a_delay_line_are_given_to_the_simulation():
    found = verify(settle_to_orbit("wright", delay={"method": "chain", "order": 2, "n": 8}))
    assert found.verified == 1
    assert found.deviation < 1e-7


def test_an_orbit_as_poor_as_its_mesh_is_still_one():
    """Three intervals of degree 3 leave an error of some 1e-3, which is said of it; its simulation allows for that."""
    orbit = settle_to_orbit(FRICTION, {"om": 0.9}, 400, mesh={"degree": 3, "intervals": 3})
    found = verify(orbit)
    assert found.verified == 1
    assert found.deviation > 1e-6


def test_errors_that_intervals_pass_on_are_allowed_for_too(monkeypatch):
    """Without what each interval leaves the orbit drifts; its estimated error, some 1e-3, says that it may."""
    orbit = settle_to_orbit(FRICTION, {"om": 0.9}, 400, mesh={"degree": 3, "intervals": 3})
    monkeypatch.setattr(module.Examination, "error", 0.0)
    assert verify(orbit).reason.code == "drifts"
    found = verify(Orbit(orbit.problem, orbit.x), strict=False)
    assert found.verified == 1 and found.deviation > 1e-6
    for error in (1e-12, np.inf):
        with monkeypatch.context() as patch:
            patch.setattr(module, "estimate_error", lambda *_, error=error: error)
            assert verify(Orbit(orbit.problem, orbit.x), strict=False).verified == 0
    assert verify(orbit.with_free(("om", "f0")), strict=False).verified == 1


@pytest.mark.parametrize(
    ("said", "verified"),
    [
        # By place in a segment, then by segment: what is wrong is wrong wherever another simulation gave up.
        ([(-1, 0), (-1, 0), (-1, 0)], 0),
        ([(0, 1), (-1, 1), (-1, 1)], 0),
        ([(-1, -1), (0, 1), (-1, 1)], 0),
        ([(-1, 1), (1, -1), (1, 1)], 1),
        ([(-1, 1), (1, -1), (-1, -1)], -1),
    ],
)
def test_a_simulation_that_gave_up_hides_no_other_that_went_another_way(monkeypatch, said, verified):
    answers = iter(verdict for place in said for verdict in place)
    places = iter(said)

    def judge_all(*_, **__):
        nonlocal answers
        answers = iter(next(places))
        return real(*_, **__)

    real = module._judge_all
    monkeypatch.setattr(module, "_judge_all", judge_all)
    monkeypatch.setattr(module, "judge", lambda *_, **__: Verification(next(answers), 0.0))
    monkeypatch.setattr(module.Examination, "simulate", lambda *_: None)
    assert verify(circle("s", "s", level=0.5)).verified == verified


@pytest.mark.parametrize(("tau", "happens"), [(0.2, False), (0.39999, False), (0.40001, True), (1.0, True)])
def test_a_delayed_event_that_the_signature_does_not_list(tau, happens):
    """The kick comes while the neuron rests, and does nothing, up to tau = R; from there on it happens."""
    found = verify(with_parameters(settle_to_orbit(REFRACTORY), tau=tau))
    assert found.verified == (not happens)
    if happens:
        assert (found.reason.code, found.reason.values["event"]) == ("happens", "kick")
        assert found.reason.values["segment"] == "rest"


@pytest.mark.parametrize(("d", "happens"), [(0.7, False), (0.50001, False), (0.49999, True), (0.3, True)])
def test_a_delayed_value_that_jumps_over_a_surface(d, happens):
    """In closed form the orbit from d to 1 takes log((1.5 - d)/0.5); its delayed value jumps to d."""
    orbit = settle_to_orbit(ECHO, {"d": 0.7})
    period = np.log((1.5 - d) / 0.5)
    assert orbit.period == pytest.approx(np.log(0.8 / 0.5), abs=1e-9)
    changed = with_parameters(orbit, d=d)
    t = orbit.mesh.base_times(orbit.theta) * period / orbit.period
    exact = np.stack([1.5 - (1.5 - d) * np.exp(-t), orbit.values[:, 1]], axis=1)
    x = changed.problem.unknowns.join(exact, np.array([period]), 0.0, changed.free)
    found = verify(
        solve_orbit(Orbit(replace(changed.problem, free=(), parameters=changed.parameters), x[:-1]), FINE).at.orbit
    )
    assert (found.verified == 1) == (not happens)
    if happens:
        assert (found.reason.code, found.reason.values["event"]) == ("happens", "echo")


@pytest.mark.parametrize("om", [0.7, 1.26])
def test_a_surface_at_which_both_fields_point(om):
    """Outside [0.7226791944, 1.2357471523] the block sticks: the orbit that goes on is none of the model's."""
    orbit = settle_to_orbit(FRICTION, {"om": 0.9}, 400)
    found = verify(follow(orbit, "om", om))
    assert (found.verified, found.reason.code) == (0, "slides")
    assert verify(follow(orbit, "om", 1.0)).verified == 1


def test_crossings_decide_where_nobody_simulates():
    crossing = circle(level=0.5)
    assert find_violation(crossing, None).code == "also_crossed"
    assert not find_violation(circle("s", level=0.5), None)


def test_what_a_simulation_confirms_no_rule_refuses():
    """A delayed value that jumps down over a level and rises through it again meets its rising event once."""

    class Yes:
        def verify(self, orbit, *, strict=False):
            return Verification(1, 0.0)

    assert find_violation(circle(level=0.5), None)
    assert not find_violation(circle(level=0.5), Yes())


@pytest.mark.parametrize("way", [1, -1])
def test_a_jump_that_hardly_carries_counts_as_what_the_orbit_does(way):
    """Within 6e-10 of d = 0.5 the delayed value jumps just to the level: the orbit's error decides what happens."""
    orbit = settle_to_orbit(ECHO, {"d": 0.5 + way * 6e-10})
    assert ("hit" in orbit.signature.names) == (way < 0)
    assert verify(orbit).verified == 1
    values = orbit.values.copy()
    jumped = orbit.mesh.base_index[np.flatnonzero(values[orbit.mesh.base_index[:, 0], 0] == np.min(values[:, 0])), 0]
    values[jumped, 0] -= way * 1e-9
    beyond = Orbit(orbit.problem, orbit.problem.unknowns.join(values, orbit.durations, orbit.start, orbit.free))
    assert verify(beyond, strict=False).verified == 1
    assert not find_violation(beyond, Referee(orbit.numeric, orbit.problem.delay))
