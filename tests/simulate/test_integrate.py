"""Trajectories against closed forms."""

import math

import numpy as np
import pytest

from pddecont.delay.chain import Chain
from pddecont.delay.direct import Direct
from pddecont.errors import ConvergenceError, SignatureError
from pddecont.simulate.integrate import simulate
from pddecont.simulate.recognise import recognise
from pddecont.simulate.simulator import Method
from tests.conftest import numeric_from, shipped
from tests.problems import WALL

TIGHT = Method(1e-12, 1e-13)
ANY = Chain(2, 15)


def test_wall_oscillator_settles_to_its_orbit():
    numeric = shipped("wall_oscillator")
    trajectory = simulate(numeric, numeric.parameter_values, ANY, 100 * math.pi, TIGHT)
    events = trajectory.events
    assert events.t[-1] % math.pi == pytest.approx(WALL["t_hit"], abs=1e-9)
    assert events.after[-1, 1] == pytest.approx(WALL["v_out"], abs=1e-9)
    assert events.before[-1, 1] * -0.8 == pytest.approx(events.after[-1, 1], abs=1e-15)


def test_a_falling_ball_bounces_at_the_closed_form_times():
    """h = 1, g = 9.81, r = 0.8: impact k at sqrt(2/g) (1 + 2 (r + ... + r^(k-1))); they accumulate at 4.0637127689."""
    numeric = numeric_from("name: ball\nstates: [y, v]\nparameters: {g: 9.81, r: 0.8}\nmodes: {m: {x': v}}\n"
                           .replace("x': v", "y': v, v': -g")
                           + "events: {hit: y}\nresets: {b: {v: -r*v}}\n"
                           "segments: {s: {mode: m, event: hit, direction: falling, reset: b, to: m}}\ninitial: {y: 1}\n")  # fmt: skip
    trajectory = simulate(numeric, numeric.parameter_values, ANY, 4.0, TIGHT)
    first = math.sqrt(2 / 9.81)
    expected = [first * (1 + 2 * sum(0.8**j for j in range(1, k))) for k in range(1, 16)]
    assert trajectory.events.t[:15] == pytest.approx(expected, abs=1e-10)
    with pytest.raises(ConvergenceError, match=r"accumulate at t = 4\.0637127688"):
        simulate(numeric, numeric.parameter_values, ANY, 5.0, TIGHT)


def test_events_of_every_direction_are_seen():
    text = ("name: m\nstates: [x]\nparameters: {w: 1}\nforcing: {period: 2*pi/w}\nmodes: {m: {x': cos(w*t)}}\nevents: {e: x - 0.5}\n"
            "segments: {s: {mode: m, event: e, direction: DIRECTION, to: m}}\n")  # fmt: skip
    rising, falling = math.asin(0.5), math.pi - math.asin(0.5)
    for direction, times in (("rising", [rising]), ("falling", [falling]), ("any", [rising, falling])):
        numeric = numeric_from(text.replace("DIRECTION", direction))
        trajectory = simulate(numeric, numeric.parameter_values, ANY, 6.0, TIGHT)
        assert trajectory.events.t == pytest.approx(times, abs=1e-11)


def test_a_delayed_event_comes_after_its_delay():
    numeric = numeric_from("name: m\nstates: [x, y]\nparameters: {tau: 2.5}\nmodes: {m: {x': 1, y': 0}}\n"
                           "events: {tick: x - 1, kick: {after: tick, delay: tau}}\nresets: {zero: {x: 0}, add: {y: y + 1}}\n"
                           "segments:\n  tick: {mode: m, event: tick, direction: rising, reset: zero, to: m}\n"
                           "  kick: {mode: m, event: kick, reset: add, to: m}\n")  # fmt: skip
    trajectory = simulate(numeric, numeric.parameter_values, ANY, 6.2)
    kicks = trajectory.events.t[np.array(trajectory.events.segment) == "kick"]
    assert kicks == pytest.approx([3.5, 4.5, 5.5], abs=1e-12)
    assert trajectory(6.2)[1] == 3.0


def test_the_explicit_chain_follows_its_closed_form():
    """x' = -x(t - tau) with history exp(r t): the chain's exact solution is exp(r t) where r E(r tau/n)^n = -1."""
    from scipy.optimize import brentq

    order, n, tau = 2, 6, 0.3

    def growth(r):
        return sum((r * tau / n) ** k / math.factorial(k) for k in range(order + 1))

    r = brentq(lambda r: r * growth(r) ** n + 1, -2.0, -0.5)
    # Chain states start from the history's values and derivatives, so the history is scaled stage by stage only to first order;
    # a constant history has no such difference.
    numeric = numeric_from("name: m\nstates: [x]\nparameters: {tau: 0.3, c: 0}\nmodes: {m: {x': -x(t - tau)}}\ninitial: {x: 1}\n"
                           .replace(", c: 0", ""))  # fmt: skip
    late = simulate(numeric, numeric.parameter_values, Chain(order, n), 14.0, Method(1e-12, 1e-20))
    assert late(14.0)[0] / late(13.0)[0] == pytest.approx(math.exp(r), rel=1e-9)


def test_overflow_names_the_mode_and_the_time():
    numeric = numeric_from("name: m\nstates: [x]\nmodes: {up: {x': x**2}}\ninitial: {x: 1}\n")
    with pytest.raises(ConvergenceError, match=r"mode 'up'|step size"):
        simulate(numeric, numeric.parameter_values, ANY, 2.0)
    numeric = numeric_from("name: m\nstates: [x]\nmodes: {down: {x': sqrt(x) - 5}}\ninitial: {x: 1}\n")
    with pytest.raises(ConvergenceError, match="mode 'down'"):
        simulate(numeric, numeric.parameter_values, ANY, 2.0)


def test_what_is_not_periodic_is_refused_with_advice():
    numeric = numeric_from("name: m\nstates: [x]\nparameters: {w: 1}\nforcing: {period: 2*pi/w}\nmodes: {m: {x': sin(w*t) + 0.1}}\n")
    trajectory = simulate(numeric, numeric.parameter_values, ANY, 80.0)
    with pytest.raises(SignatureError, match="raise 't_end'"):
        recognise(numeric, numeric.parameter_values, trajectory)


def test_the_cycle_of_a_subharmonic():
    """x'' + x/4 = 0 has period 4 pi under a forcing of period 2 pi that drives a decoupled state."""
    numeric = numeric_from("name: m\nstates: [x, v, z]\nparameters: {w: 1}\nforcing: {period: 2*pi/w}\n"
                           "modes: {m: {x': v, v': -x/4, z': sin(w*t)}}\ninitial: {x: 1}\n")  # fmt: skip
    trajectory = simulate(numeric, numeric.parameter_values, ANY, 100.0)
    assert recognise(numeric, numeric.parameter_values, trajectory).n_periods == 2


def test_initial_states_and_mode_can_be_given():
    numeric = numeric_from("name: m\nstates: [x]\nparameters: {a: 2}\nmodes: {up: {x': a}, down: {x': -a}}\nevents: {e: x - 50}\n"
                           "segments: {s: {mode: up, event: e, direction: rising, to: down}, r: {mode: down, event: e, direction: "
                           "falling, to: up}}\n")  # fmt: skip
    trajectory = simulate(numeric, numeric.parameter_values, ANY, 1.0, initial=[3.0], mode="down")
    assert trajectory(1.0)[0] == pytest.approx(1.0)
    assert set(trajectory.mode) == {"down"}


def test_a_recorded_trajectory_never_passes_its_events():
    numeric = shipped("wall_oscillator")
    trajectory = simulate(numeric, numeric.parameter_values, ANY, 20 * math.pi)
    times, states, _ = trajectory.sampled()
    assert np.all(np.diff(times) >= 0)
    assert np.max(states[:, 0]) <= 0.2 + 1e-9


def test_steps_that_begin_at_a_breaking_point_read_the_side_they_come_from():
    """Bolus: u1' = -1.5 u1, u2' = 1.5 u1(t - 10) - u2/30, u1 += 20 at t = 12, u(0) = (10, 0), no history: closed form by convolution."""
    numeric = numeric_from("name: bolus\nstates: [u1, u2, clock]\nparameters: {tau: 10}\n"
                           "modes: {m: {u1': -1.5*u1, u2': 1.5*u1(t - tau) - u2/30, clock': 1}}\nevents: {dose: clock - 12}\n"
                           "resets: {add: {u1: u1 + 20}}\n"
                           "segments: {s: {mode: m, event: dose, direction: rising, reset: add, to: m}}\n")  # fmt: skip
    trajectory = simulate(numeric, numeric.parameter_values, Direct(), 24.0, TIGHT, initial=[10.0, 0.0, 0.0])
    a, b = 1.5, 1 / 30

    def part(dose, at):
        return dose * a / (a - b) * (math.exp(-b * (24 - at - 10)) - math.exp(-a * (24 - at - 10)))

    assert trajectory(24.0)[1] == pytest.approx(part(10, 0) + part(20, 12), abs=1e-10)
    assert trajectory(24.0)[1] == pytest.approx(24.5304093870, abs=1e-9)
    # No step is wasted at the breaking points at t = 10 and 22.
    assert trajectory.n_steps < 250
