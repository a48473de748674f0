"""Trajectories of known systems against closed forms and independent calculations."""

import math

import numpy as np
import pytest
import sympy

from pddecont.delay import Chain, Direct
from pddecont.model.expression import TIME
from pddecont.simulate import Simulator, record_trajectory, simulate
from tests.conftest import numeric_from, shipped
from tests.problems import MACKEY_GLASS_PD, WALL, WRIGHT, on_off, relay
from tests.runs import run
from tests.simulate.motions import STIFF, TIGHT, trajectory_of


@pytest.mark.parametrize("method", [TIGHT, STIFF])
def test_the_suitcase_hits_the_ground_twice_and_falls(method):
    events = trajectory_of(shipped("suitcase"), 12.0, method).events
    assert events.segment == ("right", "left", "falls_right")
    assert events.t == pytest.approx([4.516757065, 9.751053145, 11.670393497], abs=1e-9)
    assert events.after[:2, 1] == pytest.approx(0.913 * events.before[:2, 1], abs=1e-15)
    assert events.before[2, 0] == pytest.approx(math.pi / 2, abs=1e-12)


def test_den_hartog_amplitude_with_dry_friction():
    events = trajectory_of(shipped("den_hartog"), 1500.0).events
    assert np.abs(events.before[-2:, 0]) == pytest.approx([2.6261048757] * 2, abs=1e-10)


def test_the_wall_oscillator_hits_at_its_phase_and_speed():
    events = trajectory_of(shipped("wall_oscillator"), 100 * math.pi).events
    assert events.t[-1] % math.pi == pytest.approx(WALL["t_hit"], abs=1e-10)
    assert events.after[-1, 1] == pytest.approx(WALL["v_out"], abs=1e-10)


def test_wall_oscillator_settles_to_its_orbit():
    numeric = shipped("wall_oscillator")
    trajectory = simulate(numeric, numeric.parameter_values, Chain(2, 15), 100 * math.pi, TIGHT)
    events = trajectory.events
    assert events.t[-1] % math.pi == pytest.approx(WALL["t_hit"], abs=1e-9)
    assert events.after[-1, 1] == pytest.approx(WALL["v_out"], abs=1e-9)
    assert events.before[-1, 1] * -0.8 == pytest.approx(events.after[-1, 1], abs=1e-15)


@pytest.mark.parametrize(
    ("a", "period", "amplitude"), [(0.0, 4.0, 1.0), (0.5, *relay(0.5, 1.0)), (0.5, 6.1847010803, 1.2974425414)]
)
def test_relay_period_and_amplitude(a, period, amplitude):
    events = trajectory_of(shipped("relay"), 60.0, a=a).events
    assert events.t[-1] - events.t[-3] == pytest.approx(period, abs=1e-10)
    assert np.abs(events.before[-2:, 0]) == pytest.approx([amplitude] * 2, abs=1e-10)


def test_on_off_period_and_extrema():
    events = trajectory_of(shipped("on_off_control"), 60.0).events
    period, high, low = on_off(1.5, 0.0, 1.0, 0.8)
    assert events.t[-1] - events.t[-3] == pytest.approx(period, abs=1e-11)
    assert period == pytest.approx(2.5857855177, abs=1e-10)
    assert sorted(events.before[-2:, 0]) == pytest.approx([low, high], abs=1e-12)


WRIGHT_MARKED = (
    "name: wright\nstates: [x]\nparameters: {tau: 1}\nmodes: {m: {x': -2*x(t - tau)*(1 + x)}}\nevents: {zero: x, "
    "top: x(t - tau)}\n"
    "segments:\n  zero: {mode: m, event: zero, direction: rising, to: m}\n"
    "  top: {mode: m, event: top, direction: rising, to: m}\ninitial: {x: 0.5}\n"
)


@pytest.mark.parametrize("method", [TIGHT, STIFF])
def test_wright_period_and_maximum(method):
    events = trajectory_of(numeric_from(WRIGHT_MARKED), 200.0, method).events
    which = np.array(events.segment)
    assert np.diff(events.t[which == "zero"])[-1] == pytest.approx(WRIGHT["period"], abs=1e-9)
    # x' = 0 where x(t - 1) = 0.
    assert events.before[which == "top", 0][-1] == pytest.approx(WRIGHT["highest"], abs=1e-9)


def test_mackey_glass_period_where_it_doubles():
    """At the period doubling orbits settle like 1/sqrt(t). Half the sum of two turns takes out what changes sign from
    one to the next.

    What is left is the square of it: two rounds, each from a history that is the Fourier series of the round before.
    """
    numeric = numeric_from(
        "name: blood\nstates: [x]\nparameters: {tau: 1}\n"
        "modes: {m: {x': 2*x(t - tau)/(1 + x(t - tau)**10) - x}}\nevents: {one: x - 1}\nsegments: {s: {mode: m, "
        "event: one, direction: rising, to: m}}\ninitial: {x: 0.9}\n"
    )
    history, n = None, 128
    for _ in range(3):
        trajectory = trajectory_of(numeric, 150.0, tau=MACKEY_GLASS_PD["tau"], history=history)
        t = trajectory.events.t
        period = (t[-1] - t[-3]) / 2
        times = t[-3] + period * np.arange(n) / n
        c = np.fft.rfft(trajectory(times)[:, 0] + trajectory(times + period)[:, 0]) / (2 * n)
        w = 2 * math.pi / period
        a, b = 2 * c.real, -2 * c.imag
        waves = [
            float(a[k]) * sympy.cos(k * w * TIME) + float(b[k]) * sympy.sin(k * w * TIME) for k in range(1, n // 2 - 4)
        ]
        history = (sympy.Add(float(c[0].real), *waves),)
    assert period == pytest.approx(MACKEY_GLASS_PD["period"], abs=1e-9)


def test_initial_states_and_mode_can_be_given():
    numeric = numeric_from(
        "name: m\nstates: [x]\nparameters: {a: 2}\nmodes: {up: {x': a}, down: {x': -a}}\nevents: {e: x - 50}\n"
        "segments: {s: {mode: up, event: e, direction: rising, to: down}, r: {mode: down, event: e, direction: "
        "falling, to: up}}\n"
    )
    trajectory = simulate(numeric, numeric.parameter_values, Chain(2, 15), 1.0, initial=[3.0], mode="down")
    assert trajectory(1.0)[0] == pytest.approx(1.0)
    assert set(trajectory.mode) == {"down"}


def test_signals_read_the_history_that_the_step_gives(tmp_path):
    text = {
        "name": "m",
        "states": ["x"],
        "parameters": {"tau": 1},
        "modes": {"m": {"x'": "-x(t - tau)"}},
        "initial": {"x": 0.1},
        "run": {
            "steps": [
                {
                    "name": "c",
                    "simulate": {
                        "t_end": 0.5,
                        "initial": {"x": 0.7, "history": "constant"},
                        "record": {"signals": {"d": "x(t - tau)"}},
                    },
                },
                {
                    "name": "h",
                    "simulate": {
                        "t_end": 0.5,
                        "initial": {"history": {"x": "2*t"}},
                        "record": {"signals": {"d": "x(t - tau)"}},
                    },
                },
            ]
        },
    }
    results = run(text, tmp_path / "s.h5")
    constant, given = (results.steps[name].orbit(0) for name in "ch")
    assert constant["signals"][:, 0] == pytest.approx(np.full(len(constant["time"]), 0.7))
    assert given["signals"][:, 0] == pytest.approx(2 * (given["time"] - 1), abs=1e-14)


def test_what_comes_before_a_time_is_forgotten():
    numeric = shipped("impact_oscillator")
    p = numeric.parameter_values
    whole = simulate(numeric, p, Direct(), 100.0)
    late = simulate(numeric, p, Direct(), 100.0, keep_from=60.0)
    assert late.time[0] <= 60.0 <= late.end[0]
    assert np.array_equal(late.value, whole.value[whole.end >= 60.0])
    assert np.array_equal(late.events.t, whole.events.t[whole.events.t >= 60.0])
    assert late.n_steps == whole.n_steps


def test_a_trajectory_may_be_made_in_parts():
    """The second part goes on from the state of the first; its steps are others: the first ends with one of its own."""
    numeric = shipped("mackey_glass")
    simulator = Simulator(numeric, Direct(), TIGHT)
    p = numeric.parameter_values
    values = simulator.values(p)
    state = simulator.start(values)
    record_trajectory(simulator, p, state, 17.3)
    second = record_trajectory(simulator, p, state, 40.0)
    whole = simulate(numeric, p, Direct(), 40.0, TIGHT)
    assert second.t0 == pytest.approx(17.3, abs=1e-13)
    t = np.linspace(17.3, 40.0, 50)
    assert second(t) == pytest.approx(whole(t), abs=1e-10)


def test_times_reached_are_told_on_the_way():
    times = []
    trajectory_of(
        "name: m\nstates: [x, v]\nparameters: {p: 0.01}\nforcing: {period: p}\nmodes: {m: {x': v, v': -x}}\n",
        300.0,
        on_progress=times.append,
    )
    assert times[-1] == 300.0
    assert len(times) > 2
    assert times == sorted(times)
