"""Expected values of oscillators, calculated a second time without the package's numbers."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

from tests.models.expected import value
from tests.models.method_of_steps import Motion, same, settled_period


def coupled(a, tau=1.2, omega=0.8, zeta=0.2, e1=0.8, e2=0.25, beta=5.0, k=0.3):
    def flow(first, second):
        def f(t, z, past):
            late = past(tau)
            force1 = a * omega**2 * math.sin(omega * t) - 2 * zeta * z[1] - z[0] + k * (late[2] - z[0])
            force2 = -2 * zeta * z[3] - z[2] + k * (late[0] - z[2])
            return [z[1], force1 - first * beta * (z[0] - e1), z[3], force2 - second * beta * (z[2] - e2)]

        return f

    modes = {(i, j): flow(i, j) for i in (0, 1) for j in (0, 1)}
    exits = {
        (i, j): [
            (lambda t, z, past: z[0] - e1, -1 if i else 1, same, (1 - i, j), "first"),
            (lambda t, z, past: z[2] - e2, -1 if j else 1, same, (i, 1 - j), "second"),
        ]
        for i, j in modes
    }
    return Motion(modes, exits, (tau,), lambda t: [0.0, 0.0, 0.0, 0.0], (0, 0))


def test_two_stages():
    """At the second grazing the first mass just reaches its stop: its highest place there, and how long the second stop
    is touched.
    """
    a, tol = value("two_stage_oscillator", "second grazing")
    period = 2 * math.pi / 0.8
    motion = coupled(a - 1e-6).run(40 * period)
    motion_end = motion.at
    below = motion.highest(0, motion_end - period, motion_end)
    # The highest place grows with a at the rate that two values show; tol is in a.
    lower = coupled(a - 1e-4).run(40 * period)
    slope = (below - lower.highest(0, motion_end - period, motion_end)) / (1e-4 - 1e-6)
    assert a - 1e-6 + (0.8 - below) / slope == pytest.approx(a, abs=1e-8 + tol)
    contact, tol = value("two_stage_oscillator", "contact at the second grazing")
    t = motion.times("second")
    last = [b - c for c, b in zip(t[-4:-1], t[-3:], strict=True)]
    assert min(last) == pytest.approx(contact, abs=1e-5)


@pytest.mark.parametrize(
    ("what", "mu", "tau", "t_end"),
    [
        ("period at tau = 1", 1.0, 1.0, 130),
        ("period at tau = 3", 1.0, 3.0, 130),
        ("period at tau = 6, weak damping", 0.1, 6.0, 250),
    ],
)
def test_van_der_pol(what, mu, tau, t_end):
    """k = 0.5, by upward zeros."""

    def swing(t, z, past):
        return [z[1], mu * (1 - z[0] ** 2) * z[1] - z[0] + 0.5 * past(tau)[0]]

    motion = Motion(
        {"m": swing}, {"m": [(lambda t, z, past: z[0], 1, same, "m", "up")]}, (tau,), lambda t: [1.0, 0.0], "m"
    ).run(t_end)
    expected, tol = value("van_der_pol", what)
    assert settled_period(motion, "up") == pytest.approx(expected, abs=tol)


def test_van_der_pol_without_delay():
    """mu = 0.1, k = 0.5 and no delay: the spring is half as stiff."""

    def swing(t, z):
        return [z[1], 0.1 * (1 - z[0] ** 2) * z[1] - 0.5 * z[0]]

    def up(t, z):
        return z[0]

    up.direction = 1
    t = solve_ivp(swing, (0, 400), [2.0, 0.0], method="DOP853", rtol=1e-12, atol=1e-13, events=up).t_events[0]
    expected, tol = value("van_der_pol", "period without delay, weak damping")
    assert t[-1] - t[-2] == pytest.approx(expected, abs=tol)


def test_duffing_folds():
    """Newton's method on a period's map and det(M - 1) = 0, the monodromy matrix from the variational equation."""

    def period_map(x, v, omega):
        def flow(t, z):
            M = z[2:].reshape(2, 2)
            J = np.array([[0.0, 1.0], [-1 - 3 * z[0] ** 2, -0.2]])
            return [z[1], math.cos(omega * t) - 0.2 * z[1] - z[0] - z[0] ** 3, *(J @ M).ravel()]

        z = solve_ivp(flow, (0, 2 * math.pi / omega), [x, v, 1, 0, 0, 1], method="DOP853", rtol=1e-12, atol=1e-13).y[
            :, -1
        ]
        return z[:2], z[2:].reshape(2, 2)

    def miss(u):
        z, M = period_map(*u)
        return [*(z - u[:2]), np.linalg.det(M - np.eye(2))]

    for what, guess in (("upper fold", (0.3, 4.9, 2.21)), ("lower fold", (-0.64, 0.1, 1.635))):
        expected, tol = value("duffing", what)
        found, _, ok, _ = fsolve(miss, guess, xtol=1e-13, full_output=True)
        assert ok == 1
        assert found[2] == pytest.approx(expected, abs=max(tol, 1e-9))


def test_full_oscillator():
    """Half the width of x over a period, with friction, wall, delayed force and filtered delayed feedback."""
    omega, a, zeta, F, e, beta, k_c, tau_c, K, tau_d, T_f = 0.8, 0.9, 0.02, 0.02, 0.8, 10.0, 0.05, 1.5, 0.1, 3.8, 0.5

    def flow(sign, hit):
        def f(t, z, past):
            delayed = K * (past(tau_d)[2] - z[2]) + k_c * (past(tau_c)[0] - z[0])
            force = (
                a * omega**2 * math.sin(omega * t)
                - z[0]
                - 2 * zeta * z[1]
                + delayed
                - sign * F
                - hit * beta * (z[0] - e)
            )
            return [z[1], force, (z[1] - z[2]) / T_f]

        return f

    def wall(t, z, past):
        return z[0] - e

    modes = [(sign, hit) for sign in (1, -1) for hit in (0, 1)]
    exits = {
        (s, h): [(lambda t, z, past: z[1], -s, same, (-s, h), "turn"), (wall, -1 if h else 1, same, (s, 1 - h), "wall")]
        for s, h in modes
    }
    speed = a * omega**3 / (1 - omega**2)
    motion = Motion(
        {mode: flow(*mode) for mode in modes}, exits, (tau_c, tau_d), lambda t: [0.0, speed, 0.0], (1, 0), echoes=2
    )
    motion.run(50 * 2 * math.pi / omega)
    turns = [z[0] for name, _, z in motion.events if name == "turn"]
    expected, tol = value("full_oscillator", "half the width of the motion")
    assert abs(turns[-1] - turns[-2]) / 2 == pytest.approx(expected, abs=tol)


def test_chain():
    """Fifty masses, walls 0.8 apart: the first mass where the third hits."""
    n, omega, zeta, c, r, e, gap, K, tau = 50, 1.1, 0.1, 0.2, 0.6, 0.8, 0.8, 0.1, 1.5
    stiffness = np.eye(n) * (1 + 2 * c) - c * (np.eye(n, k=1) + np.eye(n, k=-1))

    def free(t, z, past):
        x, v = z[0::2], z[1::2]
        slope = np.empty(2 * n)
        slope[0::2] = v
        slope[1::2] = math.cos(omega * t) - stiffness @ x - 2 * zeta * v + K * (past(tau)[1::2] - v)
        return slope

    def bounce(i):
        def reset(t, z, past):
            z = z.copy()
            z[2 * i + 1] *= -r
            return z

        return reset

    hits = [(lambda t, z, past, i=i: z[2 * i] - e - i * gap, 1, bounce(i), "free", f"hit{i + 1}") for i in range(4)]
    motion = Motion({"free": free}, {"free": hits}, (tau,), lambda t: np.zeros(2 * n), "free", echoes=2).run(
        45 * 2 * math.pi / omega
    )
    for mass, what in ((1, "first mass"), (4, "fourth mass")):
        expected, tol = value("oscillator_chain_50", f"{what} where the third hits")
        assert [z[2 * mass - 2] for name, _, z in motion.events if name == "hit3"][-1] == pytest.approx(
            expected, abs=tol
        )
