"""Lags that depend on states and time: closed forms, an independent integrator, orders, several preimages, advance."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

from pddecont.delay import Chain, Direct
from pddecont.errors import ConvergenceError
from pddecont.simulate import (
    Method,
    ReturnSettings,
    Simulator,
    find_attractor,
    find_lyapunov_exponent,
    pack,
    record_trajectory,
    simulate,
    unpack,
)
from tests.conftest import numeric_from
from tests.simulate.independent_integrator import integrate
from tests.simulate.lagged_models import (
    FELDSTEIN_NEVES,
    FELDSTEIN_NEVES_START,
    circle,
    decay,
    feldstein_neves,
    measure_errors,
    shift,
    write_model,
)
from tests.simulate.motions import STIFF, TIGHT, trajectory_of

DRIVEN = "{T: 1}", "2*pi"


def largest_error(text, exact, t_end, method=TIGHT, **given):
    """Return how far the first state is from what is known."""
    trajectory, times = trajectory_of(text, t_end, method, **given), np.linspace(0.0, t_end, 41)
    return np.max(np.abs(trajectory(times)[:, 0] - [exact(t) for t in times]))


def is_cut_at(trajectory, times, within=1e-11):
    return all(np.min(np.abs(trajectory.end - t)) < within for t in times)


@pytest.mark.parametrize(
    "rate",
    [
        "-x(t - (1 + x))*exp(-1 - x)",
        "-x(t - (1 + 0.2*x(t - 1)))*exp(-1 - 0.2*x(t - 1))",
        "-x(t - 0.01*x)*exp(-0.01*x)",
        "-x(t - x/2)*exp(-x/2)",
    ],
    ids=["longer than steps", "nested", "short", "vanishes"],
)
def test_decay_is_exponential(rate):
    assert largest_error(decay(rate), lambda t: math.exp(-t), 8.0) < 3e-12
    assert largest_error(decay(rate), lambda t: math.exp(-t), 8.0, STIFF) < 3e-9


@pytest.mark.parametrize("method, error", [(TIGHT, 2e-12), (STIFF, 2e-10)])
def test_a_lag_that_vanishes_every_period(method, error):
    text = write_model(["x"], ["cos(t) - x(t - (1 - cos(t))) + sin(t - 1 + cos(t))"], ["sin(t)"], *DRIVEN)
    assert largest_error(text, math.sin, 20.0, method) < error


def test_a_lag_that_is_zero_all_along():
    text = write_model(["x"], ["-a*x(t - c*x)"], ["1"], "{a: 1, c: 0}")
    assert largest_error(text, lambda t: math.exp(-t), 5.0) < 1e-12


def test_feldstein_and_neves():
    trajectory = trajectory_of(FELDSTEIN_NEVES, 3.8, initial=FELDSTEIN_NEVES_START)
    times = np.linspace(0.0, 3.8, 60)
    assert trajectory(times)[:, 0] == pytest.approx([feldstein_neves(t) for t in times], abs=1e-11)
    # The jump at the start comes back where y is 2, the jumps of derivatives after it where y is 4.
    assert is_cut_at(trajectory, [2.0, 2.0 + 2.0 * math.log(2.0)])


@pytest.mark.parametrize(
    "method, order, error", [(Method, 8, 0.6), (lambda **given: Method(stiff=True, **given), 4, 0.7)]
)
@pytest.mark.parametrize("lag", ["pi + y/2", "y**2/4"], ids=["past", "overlap"])
def test_orders(method, order, error, lag):
    text = circle(f"-x + 0.5*(x(t - ({lag})) - {shift(f'({lag})')})")
    h, errors = measure_errors(text, method, 1 if order == 8 else 4)
    assert np.polyfit(np.log(h), np.log(errors), 1)[0] == pytest.approx(order, abs=error)


def test_the_time_at_which_a_lag_falls_below_zero():
    text = write_model(["x", "z"], ["1", "x(t - (1 - x**2/4))"], ["0", "0"])
    with pytest.raises(ConvergenceError, match=r"at t = 2 the delay 1 - x\*\*2/4 falls below zero: .* the future"):
        trajectory_of(text, 3.0)
    assert trajectory_of(text, 2.0)(2.0)[0] == pytest.approx(2.0, abs=1e-12)


def test_a_lag_below_zero_at_the_start():
    with pytest.raises(ConvergenceError, match="at t = 0 the delay x - 2 is -1, below zero"):
        trajectory_of(write_model(["x"], ["-x(t - (x - 2))"], ["3"]), 3.0, initial=[1.0])


def passing_times(amplitude):
    """Return the times at which t - 1.5 - amplitude sin 3t changes its sign, to 5."""

    def read_time(t):
        return t - 1.5 - amplitude * math.sin(3 * t)

    grid = np.linspace(0.0, 5.0, 2001)
    pairs = [(a, b) for a, b in pairwise(grid) if read_time(a) * read_time(b) < 0]
    return [brentq(read_time, a, b, xtol=1e-15) for a, b in pairs]


# The least value of t - 1.5 - A sin 3t beyond t = 2 is 0 for this A.
TANGENT = minimize_scalar(
    lambda t: (t - 1.5) / math.sin(3 * t), bounds=(2.2, 2.9), method="bounded", options={"xatol": 1e-12}
).fun


@pytest.mark.parametrize(
    "amplitude, passed", [(1.2, 3), (1.0, 1), (TANGENT * (1 + 1e-5), 3), (TANGENT * (1 - 1e-5), 1), (TANGENT, None)]
)
def test_a_jump_is_passed_back_and_forth(amplitude, passed):
    # x jumps from 0 to 1 at the start, and z counts for how long it is read after that.
    text = write_model(["x", "z"], ["0", f"x(t - (1.5 + {float(amplitude)!r}*sin(3*t)))"], ["0", "0"], *DRIVEN)
    trajectory = trajectory_of(text, 5.0, initial=[1.0, 0.0])
    times = passing_times(amplitude)
    expected = sum((-1) ** (k + 1) * t for k, t in enumerate([*times, 5.0])) if passed else 5.0 - times[0]
    # A time at which the read time is within rounding of the jump is uncertain by its root.
    assert trajectory(5.0)[1] == pytest.approx(expected, abs=1e-11 if passed else 1e-6)
    if passed:
        assert len(times) == passed
        assert is_cut_at(trajectory, times, 1e-10)


def test_a_relay_with_a_lag_that_depends_on_its_state():
    # x rises and falls at rate 1, and switches where x(t - 1 - x/2) passes zero: at 3, 17/3, 25/3.
    text = (
        "name: r\nstates: [x]\nmodes: {up: {x': 1}, down: {x': -1}}\nevents: {pass: x(t - (1 + x/2))}\nsegments:\n"
        "  rise: {mode: up, event: pass, direction: rising, to: down}\n"
        "  fall: {mode: down, event: pass, direction: falling, to: up}\ninitial: {x: -1, mode: up}\n"
    )
    assert trajectory_of(text, 8.0).events.t == pytest.approx([3.0, 17 / 3], abs=1e-12)


def past_of(*states):
    return lambda t, order: np.array(states if order == 0 else [0.0] * len(states))


def test_an_independent_integrator_finds_the_same_motion():
    def read_time(t, x, motion):
        return t - 1.0 - 0.5 * x[0]

    motion = integrate(
        lambda t, x, m: -2.0 * m.read(0, read_time(t, x, m)), {0: read_time}, past_of(0.3), [0.3], 12, 0.25
    )
    trajectory = trajectory_of(write_model(["x"], ["-2*x(t - 1 - 0.5*x)"], ["0.3"]), 12.0)
    for t in np.linspace(0.1, 11.9, 40):
        assert trajectory(t) == pytest.approx(motion(t), abs=1e-10)


IMPACT = """name: t
states: [x, v]
modes:
  m: {x': v, v': "-0.1*v - x - 0.4*READ"}
events: {hit: x - 0.2}
resets: {turn: {v: -0.8*v}}
segments: {s: {mode: m, event: hit, direction: rising, reset: turn, to: m}}
initial: {x: -1}
"""


@pytest.mark.parametrize(
    "read, state, read_time",
    [
        ("x(t - 1 - 0.5*x)", 0, lambda t, x, motion: t - 1.0 - 0.5 * x[0]),
        ("v(t - 1.2 - 0.4*v)", 1, lambda t, x, motion: t - 1.2 - 0.4 * x[1]),
    ],
    ids=["lag goes on", "lag jumps"],
)
def test_impacts_read_later_by_a_lag_that_depends_on_states(read, state, read_time):
    def f(t, x, m):
        return np.array([x[1], -0.1 * x[1] - x[0] - 0.4 * m.read(0, read_time(t, x, m))[state]])

    motion = integrate(
        f,
        {0: read_time},
        past_of(-1.0, 0.0),
        [-1.0, 0.0],
        15,
        0.05,
        lambda t, x, m: x[0] - 0.2,
        lambda t, x, m: [x[0], -0.8 * x[1]],
    )
    trajectory = trajectory_of(IMPACT.replace("READ", read), 15.0)
    assert len(motion.events) == 5
    assert trajectory.events.t == pytest.approx(motion.events, abs=5e-10)
    assert trajectory(14.9) == pytest.approx(motion(14.9), abs=1e-9)


def test_a_constant_delay_written_as_one_that_varies():
    texts = [write_model(["x"], [f"-1.7*x(t - {lag})*(1 + x)"], ["0.5"], "{c: 0}") for lag in ("1", "(1 + c*x)")]
    one, other = (trajectory_of(text, 20.0) for text in [texts[0].replace("{c: 0}", "{k: 0}"), texts[1]])
    times = np.linspace(0.0, 20.0, 101)
    assert one(times) == pytest.approx(other(times), abs=1e-12)


def test_chains_are_refused():
    numeric = numeric_from(decay("-x(t - (1 + x))*exp(-1 - x)"))
    with pytest.raises(ConvergenceError, match="the delay x \\+ 1 varies along a motion: only the direct method"):
        simulate(numeric, numeric.parameter_values, Chain(2, 15), 1.0)


def test_a_motion_goes_on_from_its_row_as_from_itself():
    numeric = numeric_from(IMPACT.replace("READ", "x(t - 1 - 0.5*x)"))
    simulator = Simulator(numeric, Direct())
    values = simulator.values(numeric.parameter_values)
    state, _ = simulator.advance(values, simulator.start(values), 7.3)
    again = unpack(simulator.system, values, pack(state))
    one, other = (record_trajectory(simulator, numeric.parameter_values, s, 15.0) for s in (state, again))
    assert np.array_equal(one.value, other.value)
    assert np.array_equal(one.end, other.end)


def test_parameters_change_along_a_motion():
    # The lag doubles at t = 2; the motion is exp(-t) before and after.
    text = write_model(["x"], ["-x(t - k*(1 + x))*exp(-k*(1 + x))"], ["exp(-t)"], "{k: 0.4}")
    trajectory = trajectory_of(text, 6.0, schedule=[(2.0, np.array([0.8]))])
    assert trajectory(6.0)[0] == pytest.approx(math.exp(-6.0), abs=1e-12)


def test_the_largest_exponent_of_a_lag_that_varies():
    text = write_model(["x"], ["-x(t - LAG) + sin(2*pi*t)"], ["0"], "{p: 1, c: 0}", "p")
    found = []
    for lag in ("1", "(1 + c*x)"):
        numeric = numeric_from(text.replace("LAG", lag).replace(", c: 0", "" if lag == "1" else ", c: 0"))
        simulator = Simulator(numeric, Direct(), Method())
        values = simulator.values(numeric.parameter_values)
        attractor = find_attractor(simulator, values, simulator.start(values), ReturnSettings(1.0, 0.0, 400.0, 4, 50))
        found.append(find_lyapunov_exponent(simulator, values, attractor, 100.0).value)
    assert found[0] == pytest.approx(found[1], abs=1e-7)
