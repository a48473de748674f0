"""Rates of the past (neutral equations) and integrals over it: closed forms, an independent integrator, orders."""

import math

import numpy as np
import pytest

from pddecont.delay import Direct
from pddecont.errors import ConvergenceError
from pddecont.native.integrator import N_BREAKING
from pddecont.simulate import Method, Simulator
from tests.conftest import numeric_from
from tests.simulate.independent_integrator import integrate
from tests.simulate.lagged_models import circle, decay, measure_errors, shift, write_model
from tests.simulate.motions import STIFF, TIGHT, trajectory_of


def largest_error(text, exact, t_end, method=TIGHT, **given):
    """Return how far the first state is from what is known."""
    trajectory, times = trajectory_of(text, t_end, method, **given), np.linspace(0.0, t_end, 41)
    return np.max(np.abs(trajectory(times)[:, 0] - [exact(t) for t in times]))


@pytest.mark.parametrize("lag", ["1", "(1 + x/2)", "(x/2)"], ids=["constant", "varies", "vanishes"])
def test_decay_with_a_rate(lag):
    text = decay(f"-x + 0.4*(x'(t - {lag}) + exp({lag})*x)")
    assert largest_error(text, lambda t: math.exp(-t), 8.0) < 2e-11
    assert largest_error(text, lambda t: math.exp(-t), 8.0, STIFF) < 1e-8


def test_jumps_of_a_rate_never_end():
    # x' = x'(t - 1)/2 with x' = 1 before: 2^-k after k delays.
    trajectory = trajectory_of(write_model(["x"], ["0.5*x'(t - 1)"], ["t"]), 10.0)
    whole = np.arange(11)
    assert trajectory(whole.astype(float))[:, 0] == pytest.approx(1.0 - 0.5**whole, abs=1e-14)
    assert all(np.min(np.abs(trajectory.end - k)) < 1e-13 for k in whole[1:])


def test_jumps_of_a_rate_end_where_they_are_small():
    # Of 0.01^k nothing is left beyond the sixth delay at these tolerances: steps are as long as the delay lets them be.
    trajectory = trajectory_of(write_model(["x"], ["0.01*x'(t - 1) - x"], ["t"]), 400.0, Method(1e-6, 1e-8))
    numeric = numeric_from(write_model(["x"], ["0.01*x'(t - 1) - x"], ["t"]))
    simulator = Simulator(numeric, Direct(), Method(1e-6, 1e-8))
    values = simulator.values(numeric.parameter_values)
    state, _ = simulator.advance(values, simulator.start(values), 50.0)
    assert state.count[N_BREAKING] == 0
    assert abs(trajectory(400.0)[0]) < 1e-6


@pytest.mark.parametrize(
    "lag, read_time", [("1", lambda t, x, m: t - 1.0), ("0.7 - 0.2*x", lambda t, x, m: t - 0.7 - 0.2 * x[0])]
)
def test_kinks_that_rates_pass_on(lag, read_time):
    motion = integrate(
        lambda t, x, m: -x + 0.5 * m.read(0, read_time(t, x, m), 1) + np.cos(t),
        {0: read_time},
        lambda t, order: np.array([1.0 if order == 0 else 0.0]),
        [1.0],
        5,
        0.2,
    )
    text = write_model(["x"], [f"-x + 0.5*x'(t - {lag}) + cos(t)"], ["1"], "{T: 1}", "2*pi")
    trajectory = trajectory_of(text, 5.0)
    for t in np.linspace(0.1, 4.9, 30):
        assert trajectory(t) == pytest.approx(motion(t), abs=5e-10)


@pytest.mark.parametrize("lag", ["pi", "(pi + y/2)", "(y**2/4)"], ids=["constant", "past", "overlap"])
def test_order_with_rates(lag):
    text = circle(f"-x + 0.5*(y'(t - {lag}) - {shift(lag, rate=True)})")
    h, errors = measure_errors(text, Method, 1)
    order = np.polyfit(np.log(h), np.log(errors), 1)[0]
    # The slope of an extension of order 7 has an error of h^7; where that is small errors fall faster.
    assert order > 6.5 if "**2" in lag else order == pytest.approx(7, abs=0.7)


def test_a_rate_at_no_delay_is_refused():
    numeric = numeric_from(write_model(["x"], ["-x + 0.5*x'(t - k)"], ["1"], "{k: 0}"))
    with pytest.raises(ConvergenceError, match="is read at a delay of zero"):
        Simulator(numeric, Direct()).values(numeric.parameter_values)


# Integrals.
KERNEL = math.e**2 * (math.cos(2) + math.sin(2)) / 2 - math.e**0.5 * (math.cos(0.5) + math.sin(0.5)) / 2
NARROW = 0.02 * math.sqrt(math.pi) * math.exp(1.0 + 0.01**2)
FAST = (math.e**2 * (math.cos(400) + 200 * math.sin(400)) - 1) / (1 + 200**2)


@pytest.mark.parametrize("method, error", [(TIGHT, 2e-12), (STIFF, 1e-9)])
@pytest.mark.parametrize(
    "rate",
    [
        "-integral(x(t - s), s, 0, 1)/(exp(1) - 1)",
        "-integral(x(t - s), s, 0, 1 + x)/(exp(1 + x) - 1)",
        "-integral(x(t - s), s, x/2, 1 + x)/(exp(1 + x) - exp(x/2))",
        f"-x - integral(exp(-s)*cos(s)*x(t - s)**2, s, 0.5, 2) + {KERNEL!r}*x**2",
        f"-x - integral(cos(200*s)*x(t - s), s, 0, 2) + {FAST!r}*x",
    ],
    ids=["uniform", "limit varies", "both vary", "kernel", "fast kernel"],
)
def test_decay_with_an_integral(rate, method, error):
    assert largest_error(decay(rate), lambda t: math.exp(-t), 5.0, method) < error


@pytest.mark.parametrize("longest", [0.5, 0.2, 0.02])
def test_steps_short_beside_an_integral_resolve_its_kernel(longest):
    """Parts of the past are integrated with as few points as two rules agree with: a narrow kernel hides from none."""
    rate = f"-x - integral(exp(-((s - 1)/0.02)**2)*x(t - s), s, 0, 2) + {NARROW!r}*x"
    method = Method(1e-12, 1e-13, max_step=longest)
    assert largest_error(decay(rate), lambda t: math.exp(-t), 5.0, method) < 2e-12
    rate = f"-x - integral(cos(200*s)*x(t - s), s, 0, 2) + {FAST!r}*x"
    assert largest_error(decay(rate), lambda t: math.exp(-t), 5.0, method) < 2e-12


def test_an_integral_over_a_jump():
    # x' = -int_0^1 x(t - s) ds from x = 1 after 0: cos t up to 1; then x'' = x(t - 1) - x.
    trajectory = trajectory_of(write_model(["x"], ["-integral(x(t - s), s, 0, 1)"], ["0"]), 2.0, initial=[1.0])
    assert trajectory(1.0)[0] == pytest.approx(math.cos(1.0), abs=1e-12)
    # With u = t - 1, cos u drives the oscillator at its own frequency.
    assert trajectory(2.0)[0] == pytest.approx(math.cos(2.0) + math.sin(1.0) / 2.0, abs=1e-11)


def test_what_tries_of_a_step_that_reads_itself_read_ends_no_motion():
    """The first tries of a long step after short ones continue an extension that is far off, and so are its lags."""
    text = (
        "name: m\nstates: [x]\nmodes: {m: {x': \"-2*tanh(x(t - 1 - 0.3*x)) + 0.3*x'(t - 0.5)"
        ' - 0.5*integral(exp(-s)*x(t - s), s, 0, 1 + 0.1*x)"}}\ninitial: {x: 0.5}\n'
    )
    coarse, fine = (trajectory_of(text, 9.4, Method(rtol, 1e-11)) for rtol in (1e-9, 4e-10))
    assert coarse(9.4)[0] == pytest.approx(fine(9.4)[0], abs=1e-7)
