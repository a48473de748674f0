"""Radau IIA has order 5 and damps what is stiff."""

import math

import numpy as np
import pytest

from pddecont.delay import Chain
from pddecont.simulate import Method
from tests.simulate.motions import trajectory_of
from tests.simulate.orders import FIXED, bouncer_errors, measure_order, oscillator_error


def test_the_coefficients_are_consistent(interpreted):
    m = interpreted.radau
    for k in range(1, 4):  # collocation at C: sum_j A_ij C_j^(k-1) = C_i^k / k
        assert m.A @ m.C ** (k - 1) == pytest.approx(m.C**k / k)
    # The last stage is the end of the step, of order 5.
    for k in range(5):
        assert m.A[2] @ m.C**k == pytest.approx(1 / (k + 1))
    # REAL is the real eigenvalue of the inverse of A, ERROR annihilates polynomials up to degree 2.
    values = np.linalg.eigvals(np.linalg.inv(m.A))
    assert np.min(np.abs(values - m.REAL)) < 1e-12


def test_derivatives_of_fields_and_chains_are_those_of_differences(interpreted):
    text = "name: m\nstates: [x, v]\nparameters: {tau: 0.7}\nmodes: {m: {x': v, v': -sin(x) - v*x(t - tau)}}\n"
    run = interpreted.start(text, [0.0, 0.0], delay=Chain(3, 2), method=Method(stiff=True))
    c, rng, h = run.core, np.random.default_rng(0), 1e-6
    n = run.system.n_full
    y = rng.normal(size=n)
    c.y[:] = y
    interpreted.radau._evaluate_jacobian(c, 0, 0.0)
    jacobian = c.full_jacobian.reshape(n, n).copy()
    for j in range(n):
        ends = []
        for sign in (1, -1):
            c.y[:], dy = y, np.zeros(n)
            c.y[j] += sign * h
            interpreted.rhs.evaluate_rhs(c, 0, 0.0, c.y, dy)
            ends.append(dy)
        assert jacobian[:, j] == pytest.approx((ends[0] - ends[1]) / (2 * h), abs=1e-7)


@pytest.mark.parametrize("rate", [1e2, 1e5, 1e8])
def test_what_decays_fast_is_damped_in_few_steps(rate):
    """x' = -k (x - cos w t): (k^2 cos w t + k w sin w t)/(k^2 + w^2) after its layer; k h may be 1e9.

    The error estimate of stiff components is damped as they are: the error is larger than the tolerance.
    """
    text = (
        "name: m\nstates: [x]\nparameters: {k: 1, p: 40}\nforcing: {period: p}\n"
        "modes: {m: {x': -k*(x - cos(2*pi*t/p))}}\n"
    )
    trajectory = trajectory_of(text, 40.0, Method(1e-6, 1e-8, stiff=True), k=rate)
    w = 2 * math.pi / 40
    exact = (rate**2 * math.cos(w * 40) + rate * w * math.sin(w * 40)) / (rate**2 + w**2)
    assert trajectory(40.0)[0] == pytest.approx(exact, abs=5e-4)
    assert trajectory.n_steps < 100


def test_the_extension_is_the_collocation_polynomial(interpreted):
    """It passes through the stages."""
    run = interpreted.start("name: m\nstates: [x]\nmodes: {m: {x': -x*x}}\n", [1.0], method=Method(stiff=True))
    c, y = run.core, np.zeros(1)
    interpreted.rhs.evaluate_rhs(c, 0, 0.0, c.y, c.stages)
    assert interpreted.radau.try_stiff_step(c, 0.0, 1e-3) < 1.0
    interpreted.radau.extend_stiff_step(c)
    for i in range(3):
        interpreted.history.interpolate_state(c, interpreted.radau.C[i], y, 1)
        assert y[0] == pytest.approx(1.0 + c.stages[1 + i], rel=1e-14)
        assert y[0] == pytest.approx(1 / (1 + 1e-3 * interpreted.radau.C[i]), rel=1e-9)


def test_order_without_events():
    h = [0.2, 0.1, 0.05, 0.025]
    assert 4.8 < measure_order(h, [oscillator_error(Method(FIXED, FIXED, stiff=True), step) for step in h]) < 5.4


def test_order_with_events_and_a_delay():
    """Steps divide the time between bounces, so that the oscillation's own error of order 6 in phase moves them."""
    h = [math.pi / 2 / n for n in (4, 8, 16, 32)]
    errors = [bouncer_errors(Method(FIXED, FIXED, stiff=True), step) for step in h]
    assert 4.7 < measure_order(h, [y for y, _ in errors]) < 6.2
    assert 4.7 < measure_order(h, [t for _, t in errors]) < 6.2
