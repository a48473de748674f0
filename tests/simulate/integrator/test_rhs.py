"""The right-hand side: the field with its delayed values, the chain of the paper, and their tangent."""

import math

import numpy as np
import pytest

from pddecont.delay import Chain, Direct
from pddecont.simulate import Method, simulate
from tests.conftest import numeric_from
from tests.simulate.motions import TIGHT

CHAINED = "name: m\nstates: [x, v]\nparameters: {tau: 0.7}\nmodes: {m: {x': v, v': -sin(x) - v*x(t - tau)}}\n"


def evaluate(run, y, t=0.3):
    dy = np.zeros(len(y))
    run.core.y[:] = y
    run.evaluate(run.core, 0, t, run.core.y, dy)
    return dy


@pytest.fixture
def chained(interpreted):
    run = interpreted.start(CHAINED, [0.0, 0.0], delay=Chain(3, 4), tangent=True)
    run.evaluate = interpreted.rhs.evaluate_rhs
    return run


def test_a_chain_is_the_papers_equations(chained):
    """sum_k u_i^(k) delta^k / k! = u_{i-1} (2.4), u_0 the state; w_k = u^(k) delta^k are the variables."""
    rng, delta = np.random.default_rng(0), 0.7 / 4
    y = rng.normal(size=len(chained.core.y))
    dy = evaluate(chained, y)
    n_full = chained.system.n_full
    assert n_full == 2 + 4 * 3
    w, dw = y[2:n_full].reshape(4, 3), dy[2:n_full].reshape(4, 3)
    assert dy[:2] == pytest.approx([y[1], -math.sin(y[0]) - y[1] * w[-1, 0]])
    for stage in range(4):
        before = w[stage - 1, 0] if stage else y[0]
        assert dw[stage, :2] * delta == pytest.approx(w[stage, 1:])
        highest = dw[stage, 2] * delta
        assert w[stage, 0] + w[stage, 1] + w[stage, 2] / 2 + highest / 6 == pytest.approx(before)


def test_the_tangent_is_the_derivative_of_the_rest(chained):
    rng, h = np.random.default_rng(1), 1e-6
    y = rng.normal(size=len(chained.core.y))
    n = chained.system.n_full
    tangent = evaluate(chained, y)[n:]
    ends = [evaluate(chained, y + s * h * np.concatenate([y[n:], np.zeros(n)]))[:n] for s in (1, -1)]
    assert tangent == pytest.approx((ends[0] - ends[1]) / (2 * h), abs=1e-8)


def test_a_delay_of_zero_reads_the_present(interpreted):
    run = interpreted.start(CHAINED, [0.0, 0.0], p=np.array([0.0]), delay=Direct())
    run.evaluate = interpreted.rhs.evaluate_rhs
    assert evaluate(run, np.array([0.4, 0.5])) == pytest.approx([0.5, -math.sin(0.4) - 0.2])


def test_the_explicit_chain_follows_its_closed_form():
    """x' = -x(t - tau) with history exp(r t): the chain's exact solution is exp(r t) where r E(r tau/n)^n = -1."""
    from scipy.optimize import brentq

    order, n, tau = 2, 6, 0.3

    def growth(r):
        return sum((r * tau / n) ** k / math.factorial(k) for k in range(order + 1))

    r = brentq(lambda r: r * growth(r) ** n + 1, -2.0, -0.5)
    # Chain states start from the history's values and derivatives, so the history is scaled stage by stage only to
    # first order; a constant history has no such difference.
    numeric = numeric_from(
        "name: m\nstates: [x]\nparameters: {tau: 0.3, c: 0}\nmodes: {m: {x': -x(t - tau)}}\ninitial: {x: 1}\n".replace(
            ", c: 0", ""
        )
    )
    late = simulate(numeric, numeric.parameter_values, Chain(order, n), 14.0, Method(1e-12, 1e-20))
    assert late(14.0)[0] / late(13.0)[0] == pytest.approx(math.exp(r), rel=1e-9)


def test_a_long_chain_goes_to_the_delay_equation():
    numeric = numeric_from(
        "name: m\nstates: [x]\nparameters: {tau: 1}\nmodes: {m: {x': -x(t - tau)}}\ninitial: {x: 1}\n"
    )
    exact = simulate(numeric, numeric.parameter_values, Direct(), 8.0, TIGHT)(8.0)[0]
    errors = [
        abs(simulate(numeric, numeric.parameter_values, Chain(2, n), 8.0, TIGHT)(8.0)[0] - exact) for n in (10, 20, 40)
    ]
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx(2.0, abs=0.3)
