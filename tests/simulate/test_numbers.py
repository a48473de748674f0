"""Trajectories of known systems against closed forms or independent calculations, and the integrator's order."""

import itertools
import math

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp

from pddecont.delay.direct import Direct
from pddecont.model.expression import TIME
from pddecont.simulate.integrate import simulate
from pddecont.simulate.simulator import Method
from tests.conftest import numeric_from, shipped
from tests.problems import MACKEY_GLASS_PD, WALL, WRIGHT, on_off, relay

TIGHT = Method(1e-12, 1e-13)
STIFF = Method(1e-10, 1e-11, stiff=True)
# Tolerances so large that every step is as long as it may be: half the forcing period.
FIXED = 1e8


def run(numeric, t_end, method=TIGHT, **given):
    p = numeric.parameter_values.copy()
    for name in given.keys() & set(numeric.model.parameters):
        p[list(numeric.model.parameters).index(name)] = given.pop(name)
    return simulate(numeric, p, Direct(), t_end, method, **given)


@pytest.mark.parametrize("method", [TIGHT, STIFF])
def test_the_suitcase_hits_the_ground_twice_and_falls(method):
    events = run(shipped("suitcase"), 12.0, method).events
    assert events.segment == ("right", "left", "falls_right")
    assert events.t == pytest.approx([4.516757065, 9.751053145, 11.670393497], abs=1e-9)
    assert events.after[:2, 1] == pytest.approx(0.913 * events.before[:2, 1], abs=1e-15)
    assert events.before[2, 0] == pytest.approx(math.pi / 2, abs=1e-12)


def test_a_bolus_is_seen_a_delay_later():
    trajectory = run(shipped("bolus"), 24.0, initial=[10.0, 0.0, 0.0])
    assert trajectory.events.t[0] == pytest.approx(12.0, abs=1e-13)
    assert trajectory(24.0)[1] == pytest.approx(24.5304093870, abs=1e-10)


BALL = ("name: ball\nstates: [y, v]\nparameters: {g: 9.81, r: 0.8, floor: 0}\nmodes: {fly: {y': v, v': -g}, lie: {y': 0, v': 0}}\n"
        "events: {hit: y - floor}\nresets: {bounce: {v: -r*v}}\n"
        "segments: {hop: {mode: fly, event: hit, direction: falling, reset: bounce, to: fly}}\ninitial: {y: 1}\n")  # fmt: skip


def test_impacts_of_a_ball_accumulate_and_it_comes_to_lie():
    """Impact k at sqrt(2/g) (1 + 2 (r + ... + r^(k-1))) with speed r^(k-1) sqrt(2 g); the limit is sqrt(2/g) (1 + r)/(1 - r)."""
    trajectory = run(numeric_from(BALL), 10.0, Method(1e-12, 1e-13, stick={"hit": "lie"}))
    k = np.arange(len(trajectory.events))
    first = math.sqrt(2 / 9.81)
    assert len(k) > 50
    assert trajectory.events.t == pytest.approx(first * (1 + 2 * (0.8 - 0.8 ** (k + 1)) / 0.2), abs=1e-11)
    assert -trajectory.events.before[:40, 1] == pytest.approx(math.sqrt(2 * 9.81) * 0.8 ** k[:40], rel=1e-11)
    rest = trajectory.time[trajectory.mode.index("lie")]
    assert rest == pytest.approx(first * 9, abs=1e-11)
    assert rest == pytest.approx(4.0637127689, abs=1e-9)
    assert (trajectory.t_end, trajectory.mode[-1]) == (10.0, "lie")
    assert trajectory(10.0) == pytest.approx([0, 0], abs=1e-8)


def test_den_hartog_amplitude_with_dry_friction():
    events = run(shipped("den_hartog"), 1500.0).events
    assert np.abs(events.before[-2:, 0]) == pytest.approx([2.6261048757] * 2, abs=1e-10)


def test_the_wall_oscillator_hits_at_its_phase_and_speed():
    events = run(shipped("wall_oscillator"), 100 * math.pi).events
    assert events.t[-1] % math.pi == pytest.approx(WALL["t_hit"], abs=1e-10)
    assert events.after[-1, 1] == pytest.approx(WALL["v_out"], abs=1e-10)


@pytest.mark.parametrize(("a", "period", "amplitude"), [(0.0, 4.0, 1.0), (0.5, *relay(0.5, 1.0)), (0.5, 6.1847010803, 1.2974425414)])
def test_relay_period_and_amplitude(a, period, amplitude):
    events = run(shipped("relay"), 60.0, a=a).events
    assert events.t[-1] - events.t[-3] == pytest.approx(period, abs=1e-10)
    assert np.abs(events.before[-2:, 0]) == pytest.approx([amplitude] * 2, abs=1e-10)


def test_on_off_period_and_extrema():
    events = run(shipped("on_off_control"), 60.0).events
    period, high, low = on_off(1.5, 0.0, 1.0, 0.8)
    assert events.t[-1] - events.t[-3] == pytest.approx(period, abs=1e-11)
    assert period == pytest.approx(2.5857855177, abs=1e-10)
    assert sorted(events.before[-2:, 0]) == pytest.approx([low, high], abs=1e-12)


WRIGHT_MARKED = ("name: wright\nstates: [x]\nparameters: {tau: 1}\nmodes: {m: {x': -2*x(t - tau)*(1 + x)}}\nevents: {zero: x, "
                 "top: x(t - tau)}\n"
                 "segments:\n  zero: {mode: m, event: zero, direction: rising, to: m}\n"
                 "  top: {mode: m, event: top, direction: rising, to: m}\ninitial: {x: 0.5}\n")  # fmt: skip


@pytest.mark.parametrize("method", [TIGHT, STIFF])
def test_wright_period_and_maximum(method):
    events = run(numeric_from(WRIGHT_MARKED), 200.0, method).events
    which = np.array(events.segment)
    assert np.diff(events.t[which == "zero"])[-1] == pytest.approx(WRIGHT["period"], abs=1e-9)
    # x' = 0 where x(t - 1) = 0.
    assert events.before[which == "top", 0][-1] == pytest.approx(WRIGHT["highest"], abs=1e-9)


def test_mackey_glass_period_where_it_doubles():
    """At the period doubling orbits settle like 1/sqrt(t). Half the sum of two turns takes out what changes sign from one to the next.

    What is left is the square of it: two rounds, each from a history that is the Fourier series of the round before.
    """
    numeric = numeric_from("name: blood\nstates: [x]\nparameters: {tau: 1}\n"
                           "modes: {m: {x': 2*x(t - tau)/(1 + x(t - tau)**10) - x}}\nevents: {one: x - 1}\nsegments: {s: {mode: m, "
                           "event: one, direction: rising, to: m}}\ninitial: {x: 0.9}\n")  # fmt: skip
    history, n = None, 128
    for _ in range(3):
        trajectory = run(numeric, 150.0, tau=MACKEY_GLASS_PD["tau"], history=history)
        t = trajectory.events.t
        period = (t[-1] - t[-3]) / 2
        times = t[-3] + period * np.arange(n) / n
        c = np.fft.rfft(trajectory(times)[:, 0] + trajectory(times + period)[:, 0]) / (2 * n)
        w = 2 * math.pi / period
        a, b = 2 * c.real, -2 * c.imag
        waves = [float(a[k]) * sympy.cos(k * w * TIME) + float(b[k]) * sympy.sin(k * w * TIME) for k in range(1, n // 2 - 4)]
        history = (sympy.Add(float(c[0].real), *waves),)
    assert period == pytest.approx(MACKEY_GLASS_PD["period"], abs=1e-9)


# Order. With tolerances that allow everything, steps are as long as a forcing period p allows: p/2.
OSCILLATOR = "name: o\nstates: [x, v]\nparameters: {p: 1}\nforcing: {period: p}\nmodes: {m: {x': v, v': -x}}\ninitial: {x: 1}\n"
# x = |sin t| bounces at every multiple of pi; y hears of it pi/2 later. Breaking points are the multiples of pi/2.
BOUNCER = ("name: b\nstates: [x, v, y]\nparameters: {p: 1}\nforcing: {period: p}\nmodes: {m: {x': v, v': -x, y': x(t - pi/2) - y}}\n"
           "events: {hit: x}\nresets: {turn: {v: -v}}\n"
           "segments: {s: {mode: m, event: hit, direction: falling, reset: turn, to: m}}\ninitial: {v: 1}\n")  # fmt: skip


def oscillator_error(method, h=1.0):
    trajectory = run(numeric_from(OSCILLATOR), 12.0, method, p=2 * h)
    return float(np.linalg.norm(trajectory(12.0) - [math.cos(12), -math.sin(12)]))


def bouncer_errors(method, h=10.0):
    """Return the errors of y(4.5 pi) and of the times of bounces; y = int_0^(4 pi) exp(u - 4 pi) abs(sin u) du."""
    trajectory = run(numeric_from(BOUNCER), 4.5 * math.pi, method, p=2 * h)
    y = sum(math.exp(k * math.pi) for k in range(4)) * (math.exp(math.pi) + 1) / 2 * math.exp(-4 * math.pi)
    assert len(trajectory.events) == 4
    return abs(trajectory(4.5 * math.pi)[2] - y), float(np.max(np.abs(trajectory.events.t - math.pi * np.arange(1, 5))))


def order(h, errors):
    assert min(errors) > 1e-13, "rounding hides the order"
    return np.polyfit(np.log(h), np.log(errors), 1)[0]


@pytest.mark.parametrize(
    ("stiff", "h", "low", "high"), [(False, [0.75, 0.6, 0.5, 0.4, 0.3], 7.7, 10.0), (True, [0.2, 0.1, 0.05, 0.025], 4.8, 5.4)]
)
def test_order_without_events(stiff, h, low, high):
    assert low < order(h, [oscillator_error(Method(FIXED, FIXED, stiff), step) for step in h]) < high


# Steps divide the time between bounces, so that the oscillation's own error of order 6 in phase is what moves Radau's bounces.
@pytest.mark.parametrize(("stiff", "parts", "low", "high"), [(False, [4, 5, 6, 7, 8], 7.3, 8.7), (True, [4, 8, 16, 32], 4.7, 6.2)])
def test_order_with_events_and_a_delay(stiff, parts, low, high):
    h = [math.pi / 2 / n for n in parts]
    errors = [bouncer_errors(Method(FIXED, FIXED, stiff), step) for step in h]
    assert low < order(h, [y for y, _ in errors]) < high
    assert low < order(h, [t for _, t in errors]) < high


@pytest.mark.parametrize("stiff", [False, True])
def test_the_error_falls_with_the_tolerance_over_six_decades(stiff):
    made = np.array([oscillator_error(Method(rtol, rtol, stiff)) for rtol in 10.0 ** -np.arange(6, 13)])
    assert np.all(made[1:] < made[:-1] / 2)
    assert made[-1] < 1e-4 * made[0]


@pytest.mark.parametrize("stiff", [False, True])
@pytest.mark.parametrize("errors", [oscillator_error, lambda method: max(bouncer_errors(method))], ids=["smooth", "hybrid"])
def test_errors_fall_with_the_tolerance(errors, stiff):
    allowed = 10.0 ** -np.arange(4, 11)
    made = np.array([errors(Method(rtol, rtol, stiff)) for rtol in allowed])
    assert np.all(made < 5 * allowed)
    # The delay alone keeps the hybrid problem's steps short, so that loose tolerances change little there.
    assert made[-1] < 0.01 * made.max()


@pytest.mark.parametrize("rtol", [1e-5, 1e-7, 1e-9])
def test_what_delays_read_is_as_good_as_the_ends_of_steps(rtol):
    """Mackey-Glass's cycle, n = 6.5, tau = 2: each step's extension against the exact solution from its start, with the past as it is.

    Without control of the extension's defect the largest error is 15 to 283 rtol.
    """
    numeric = shipped("mackey_glass")
    p = numeric.parameter_values.copy()
    p[numeric.parameter_index("n")], p[numeric.parameter_index("tau")] = 6.5, 2.0
    trajectory = simulate(numeric, p, Direct(), 40.0, Method(rtol, 0.01 * rtol))

    def field(t, x):
        delayed = trajectory(t - 2.0)[0]
        return [2.0 * delayed / (1.0 + delayed**6.5) - x[0]]

    worst = 0.0
    for i in np.flatnonzero((trajectory.time > 25.0) & (trajectory.end < 39.0)):
        start, end = trajectory.time[i], trajectory.end[i]
        # The past is smooth between its own steps.
        edges = [start, *(t + 2.0 for t in trajectory.time if start < t + 2.0 < end), end]
        x = trajectory.value[i]
        for a, b in itertools.pairwise(edges):
            exact = solve_ivp(field, (a, b), x, method="DOP853", rtol=1e-13, atol=1e-15, dense_output=True, max_step=(b - a) / 2)
            inside = np.linspace(a, b, 6)[1:]
            worst = max(worst, np.max(np.abs(exact.sol(inside)[0] - trajectory.in_arc(int(trajectory.arc[i]), inside)[:, 0])))
            x = exact.y[:, -1]
    assert 0.0 < worst < 4.0 * rtol
