"""What a trajectory repeats at its end, and what is said of those that repeat nothing."""

import numpy as np
import pytest

from pddecont.delay import Chain, Direct
from pddecont.errors import SignatureError
from pddecont.simulate import Method, detect_period, simulate
from tests.conftest import numeric_from, shipped
from tests.problems import WRIGHT
from tests.runs import run
from tests.simulate.motions import with_parameters

REST = "the motion comes to rest: the trajectory settles to an equilibrium"


FREE = "1 - c*v - k*x"
# Without the constant force: to rest at zero.
TO_ZERO = "-c*v - k*x"
WALL = {
    "events": {"hit": "x + 0.1"},
    "resets": {"b": {"v": "-0.8*v"}},
    "segments": {"s": {"mode": "m", "event": "hit", "direction": "falling", "reset": "b", "to": "m"}},
}


def damped(force, c=0.2, wall=None, t_end=400):
    """Return a run from a simulation of a damped oscillator to an orbit."""
    return {
        "name": "m",
        "states": ["x", "v"],
        "parameters": {"c": c, "k": 1},
        "modes": {"m": {"x'": "v", "v'": force}},
        "initial": {"x": 2},
        **(wall or {}),
        "run": {"steps": [{"name": "t", "simulate": {"t_end": t_end}}, {"name": "o", "orbit": {"from": "t"}}]},
    }


@pytest.mark.parametrize(
    ("model", "message"),
    [
        (damped(FREE), REST),  # at x = 1
        (damped(TO_ZERO), REST),  # at zero, in ever smaller oscillations of one shape
        (damped(TO_ZERO, c=1, t_end=200), REST),  # at zero, to the errors of its steps
        (damped(TO_ZERO, c=3), REST),  # at zero, without an oscillation
        (damped(TO_ZERO, wall=WALL), REST),  # after the last impact
        (damped(TO_ZERO, wall=WALL, t_end=5), "too few events to see a period in them; raise 't_end'"),
        (damped(TO_ZERO, c=0.02, t_end=60), "has not settled to a periodic motion"),
    ],
)
def test_a_motion_that_comes_to_rest_is_told_from_one_that_is_on_its_way(tmp_path, model, message):
    with pytest.raises(SignatureError, match=message):
        run(model, tmp_path / "a.h5")


def test_an_oscillation_far_smaller_than_its_transient_is_no_rest(tmp_path):
    """A Hopf normal form whose cycle has radius 1e-4 and period 2 pi, begun at 1."""
    model = {
        "name": "m",
        "states": ["x", "y"],
        "parameters": {"r": 1e-4},
        "modes": {"m": {"x'": "(r**2 - x**2 - y**2)*x*1e6 - y", "y'": "(r**2 - x**2 - y**2)*y*1e6 + x"}},
        "initial": {"x": "200*r"},
        "run": damped(FREE, t_end=600)["run"],
    }
    results = run(model, tmp_path / "a.h5")
    assert results.step("o").points["period"][0] == pytest.approx(6.283185307, abs=1e-6)


def test_what_is_not_periodic_is_refused_with_advice():
    numeric = numeric_from(
        "name: m\nstates: [x]\nparameters: {w: 1}\nforcing: {period: 2*pi/w}\nmodes: {m: {x': sin(w*t) + 0.1}}\n"
    )
    trajectory = simulate(numeric, numeric.parameter_values, Chain(2, 15), 80.0)
    with pytest.raises(SignatureError, match="raise 't_end'"):
        detect_period(numeric, numeric.parameter_values, trajectory)


def test_the_cycle_of_a_subharmonic():
    """x'' + x/4 = 0 has period 4 pi under a forcing of period 2 pi that drives a decoupled state."""
    numeric = numeric_from(
        "name: m\nstates: [x, v, z]\nparameters: {w: 1}\nforcing: {period: 2*pi/w}\n"
        "modes: {m: {x': v, v': -x/4, z': sin(w*t)}}\ninitial: {x: 1}\n"
    )
    trajectory = simulate(numeric, numeric.parameter_values, Chain(2, 15), 100.0)
    assert detect_period(numeric, numeric.parameter_values, trajectory).n_periods == 2


def cycle_of(name, t_end, **given):
    numeric = shipped(name)
    p = with_parameters(numeric, **given)
    return detect_period(numeric, p, simulate(numeric, p, Direct(), t_end))


def test_the_cycle_of_a_smooth_autonomous_model_is_between_passages():
    cycle = cycle_of("wright", 300.0, alpha=2.0)
    assert cycle.signature == ()
    assert cycle.times[1] - cycle.times[0] == pytest.approx(WRIGHT["period"], rel=1e-6)
    assert cycle.evaluate(0, cycle.times) == pytest.approx(cycle.evaluate(0, cycle.times[::-1]), abs=1e-4)


def test_the_cycle_of_an_autonomous_model_is_between_events():
    cycle = cycle_of("relay", 60.0, a=0.5)
    assert len(cycle.signature) == 2
    assert len(cycle.times) == 3
    assert cycle.n_periods == 1
    # It begins with the segment that lasts longest.
    lengths = np.diff(cycle.times)
    assert lengths[0] == pytest.approx(np.max(lengths))


def test_the_cycle_of_a_forced_model_takes_whole_periods():
    cycle = cycle_of("impact_oscillator", 200 * 2 * np.pi / 0.8, K=0.12)
    assert cycle.n_periods == 2
    assert cycle.times[-1] - cycle.times[0] == pytest.approx(2 * 2 * np.pi / 0.8)
    starts = [cycle.evaluate(i, cycle.times[i : i + 1])[0] for i in range(len(cycle.signature))]
    ends = [cycle.evaluate(i, cycle.times[i + 1 : i + 2])[0] for i in range(len(cycle.signature))]
    # The model's reset does nothing, so that the cycle is continuous.
    assert np.array(starts[1:]) == pytest.approx(np.array(ends[:-1]), abs=1e-9)
    assert ends[-1] == pytest.approx(starts[0], abs=1e-3)


def test_impacts_that_accumulate_end_with_one_that_leads_to_rest():
    """However many were followed in the period before: kicked off at each multiple of 2 pi, the ball rests by 4."""
    text = (
        "name: b\nstates: [y, v]\nparameters: {w: 1}\nforcing: {period: 2*pi/w}\n"
        "modes: {fly: {y': v, v': -1}, lie: {y': 0, v': 0}}\nevents: {hit: y, up: sin(w*t)}\n"
        "resets: {b: {v: -0.5*v}, kick: {v: 1}}\nsegments:\n"
        "  hop: {mode: fly, event: hit, direction: falling, reset: b, to: fly}\n"
        "  go: {mode: lie, event: up, direction: rising, reset: kick, to: fly}\ninitial: {y: 1}\n"
    )
    numeric = numeric_from(text)
    for t_end in np.linspace(60.0, 66.0, 7):
        trajectory = simulate(numeric, numeric.parameter_values, Direct(), t_end, Method(stick={"hit": "lie"}))
        names = detect_period(numeric, numeric.parameter_values, trajectory).signature
        n = len(names)
        turned = names[names.index("go") + 1 :] + names[: names.index("go") + 1]
        assert turned == ("hop",) * (n - 2) + ("hop>lie", "go")
        assert n > 20


def test_a_trajectory_of_less_than_two_periods_is_too_short():
    with pytest.raises(SignatureError, match="shorter than two forcing periods"):
        cycle_of("duffing", 8.0)


# A held input that is the same at every sample, to rounding: the disturbance has the period of the sampling.
SAMPLED = {
    "name": "hold",
    "states": ["x", "v", "u"],
    "parameters": {"P": 3, "D": 2.5, "T": 0.2, "tau": 0.05},
    "forcing": {"period": "T"},
    "modes": {"m": {"x'": "v", "v'": "x + u + 0.1*cos(2*pi*t/T)", "u'": 0}},
    "events": {"sample": "sin(2*pi*t/T)"},
    "resets": {"hold": {"u": "-P*x(t - tau) - D*v(t - tau)"}},
    "segments": {"held": {"mode": "m", "event": "sample", "direction": "rising", "reset": "hold", "to": "m"}},
    "initial": {"x": 0.1},
    "run": {"steps": [{"name": "t", "simulate": {"t_end": "400*T"}}, {"name": "o", "orbit": {"from": "t"}}]},
}


@pytest.mark.parametrize("change", [{}, {"T": 0.1}, {"D": 2.0}])
def test_a_state_that_rounding_alone_moves_has_settled(tmp_path, change):
    model = {**SAMPLED, "parameters": {**SAMPLED["parameters"], **change}}
    results = run(model, tmp_path / "a.h5")
    assert results.step("o").points["period"][0] == pytest.approx(change.get("T", 0.2), rel=1e-12)


def test_a_clock_that_no_event_resets_is_named(tmp_path):
    """Mode ``idle`` ends where x passes 2, which it never does: its clock s grows."""
    model = {
        "name": "clock",
        "states": ["x", "s"],
        "parameters": {"T": 1},
        "modes": {"idle": {"x'": "1 - x", "s'": 1}, "feed": {"x'": "-x", "s'": 1}},
        "events": {"compare": "x - 2", "tick": "s - T"},
        "resets": {"restart": {"s": 0}},
        "segments": {
            "closed": {"mode": "idle", "event": "compare", "direction": "rising", "to": "feed"},
            "open": {"mode": "feed", "event": "tick", "direction": "rising", "reset": "restart", "to": "idle"},
        },
        "initial": {"mode": "idle"},
        "run": {"steps": [{"name": "t", "simulate": {"t_end": 200}}, {"name": "o", "orbit": {"from": "t"}}]},
    }
    with pytest.raises(SignatureError, match=r"state 's' goes on from .* 'idle' too, has a segment that resets it"):
        run(model, tmp_path / "a.h5")


def test_a_motion_that_dies_away_slowly_decays_to_rest(tmp_path):
    """x'' + 0.06 x' + x = 0: in the 40 time units of a stretch the swings shrink by exp(-1.2) = 0.30."""
    with pytest.raises(SignatureError, match=r"decays to rest: .* by a factor of 0\.3 in each time 40"):
        run(damped(TO_ZERO, c=0.06), tmp_path / "a.h5")


def test_four_recorded_periods_are_enough_wherever_the_events_lie():
    """A dry friction oscillator that sticks for most of its period; at omega = 0.5 x goes up to 1.280000."""
    text = (
        "name: f\nstates: [x, v]\nparameters: {omega: 0.5, F: 0.4, K: 0.1, tau: 0.6}\n"
        "definitions: {pull: cos(omega*t) - x + K*(x(t - tau) - x)}\nforcing: {period: 2*pi/omega}\n"
        "modes: {right: {x': v, v': pull - F}, left: {x': v, v': pull + F}, stuck: {x': 0, v': 0}}\n"
        "events: {stop: v, push_right: pull - F, push_left: pull + F}\nresets: {still: {v: 0}}\nsegments:\n"
        "  right: {mode: right, event: stop, direction: falling, reset: still, to: stuck}\n"
        "  left: {mode: left, event: stop, direction: rising, reset: still, to: stuck}\n"
        "  to_right: {mode: stuck, event: push_right, direction: rising, to: right}\n"
        "  to_left: {mode: stuck, event: push_left, direction: falling, to: left}\ninitial: {mode: stuck}\n"
    )
    numeric = numeric_from(text)
    period = 4 * np.pi
    trajectory = simulate(numeric, numeric.parameter_values, Direct(), 60 * period, keep_from=56 * period)
    cycle = detect_period(numeric, numeric.parameter_values, trajectory)
    assert set(cycle.signature) == {"left", "to_right", "right", "to_left"}
    assert cycle.n_periods == 1
    assert np.max(trajectory.sample()[1][:, 0]) == pytest.approx(1.28, abs=5e-7)
