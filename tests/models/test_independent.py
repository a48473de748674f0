"""Expected values without closed form, calculated a second time without the package's numbers."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, fsolve

from tests.models.expected import entry
from tests.models.method_of_steps import Motion, same


def value(model, what):
    item = entry(model, what)
    return float(item["value"]), 2 * item["tol"]


def settled_period(motion, name, count=1):
    t = motion.times(name)
    assert t[-1] - t[-1 - count] == pytest.approx(t[-1 - count] - t[-1 - 2 * count], abs=1e-8)
    return t[-1] - t[-1 - count]


def belt(K, V=0.5, F_stick=1.0, F_slip=0.7, falling=0.1, tau=1.5):
    def pull(z, past):
        return z[0] - K * past(tau)[1]

    return Motion(
        {
            "stick": lambda t, z, past: [V, 0.0],
            "slip": lambda t, z, past: [z[1], F_slip - falling * (V - z[1]) - pull(z, past)],
        },
        {
            "stick": [(lambda t, z, past: pull(z, past) - F_stick, 1, same, "slip", "tear")],
            "slip": [(lambda t, z, past: z[1] - V, 1, lambda t, z, past: [z[0], V], "stick", "catch")],
        },
        (tau,),
        lambda t: [0.0, V],
        "stick",
    )


@pytest.mark.parametrize(("K", "t_end"), [(-0.5, 200), (0.5, 100)])
def test_belt(K, t_end):
    motion = belt(K).run(t_end)
    expected, tol = value("belt_stick_slip", f"period at K = {K}")
    assert settled_period(motion, "tear") == pytest.approx(expected, abs=tol)


def balance(tau, P=2.0, D=1.5, d=1.0):
    def drift(t, z, past):
        return [z[1], z[0]]

    def act(t, z, past):
        late = past(tau)
        return [z[1], z[0] - P * late[0] - D * late[1]]

    def right(t, z, past):
        return past(tau)[0] - d

    def left(t, z, past):
        return past(tau)[0] + d

    return Motion(
        {"drift": drift, "right": act, "left": act},
        {
            "drift": [(right, 1, same, "right", "on"), (left, -1, same, "left", "on_left")],
            "right": [(right, -1, same, "drift", "off")],
            "left": [(left, 1, same, "drift", "off_left")],
        },
        (tau,),
        lambda t: [0.5, 0.0],
        "drift",
    )


@pytest.mark.parametrize(("tau", "t_end"), [(0.15, 80), (0.3, 80), (0.5, 130)])
def test_balance(tau, t_end):
    motion = balance(tau).run(t_end)
    expected, tol = value("human_balance", f"period at tau = {tau}")
    assert settled_period(motion, "on") == pytest.approx(expected, abs=tol)


def turning(w, zeta=0.02, tau=4.6401058748):
    """The chip is the smallest over the last two revolutions; one mode cuts, one does not, and a kink is no event."""

    def chip(z, past):
        return min(1 + past(tau)[0], 2 + past(2 * tau)[0]) - z[0]

    return Motion(
        {
            "cut": lambda t, z, past: [z[1], w * chip(z, past) - 2 * zeta * z[1] - z[0]],
            "air": lambda t, z, past: [z[1], -2 * zeta * z[1] - z[0]],
        },
        {
            "cut": [(lambda t, z, past: chip(z, past), -1, same, "air", "leaves")],
            "air": [(lambda t, z, past: chip(z, past), 1, same, "cut", "lands")],
        },
        (tau, 2 * tau),
        lambda t: [1.36 * math.cos(1.026 * t), -1.36 * math.sin(1.026 * t)],
        "cut",
        echoes=1,
    )


def test_turning():
    """Motions settle by less than 0.95 a period; what is left after 140 periods is below 1e-6 of the period."""
    t = turning(0.06).run(900).times("leaves")
    expected, tol = value("turning", "period at w = 0.06")
    assert np.ptp(np.diff(t)[-20:]) < 1e-7
    assert t[-1] - t[-2] == pytest.approx(expected, abs=tol)


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


def test_interrupted_cutting():
    """The doubled orbit as a fixed point of two steps of the map from tooth to tooth."""
    w, zeta, tau = 1.2, 0.05, 8.0
    decay, ring = math.exp(-zeta * tau), math.sqrt(1 - zeta**2)
    c, s = math.cos(ring * tau), math.sin(ring * tau)
    A = decay * np.array([[c + zeta / ring * s, s / ring], [-s / ring, c - zeta / ring * s]])

    def tooth(z):
        arrived = A @ z
        return np.array([arrived[0], arrived[1] + w * (1 + z[0] - arrived[0]) ** 0.75])

    steady = np.linalg.solve(np.eye(2) - A, [0.0, w])
    slope = 0.75 * w
    rates, directions = np.linalg.eig(A + np.outer([0.0, slope], [1.0, 0.0] - A[0]))
    way = directions[:, np.argmin(rates)] / directions[0, np.argmin(rates)]
    z, _, ok, _ = fsolve(lambda z: tooth(tooth(z)) - z, steady + 0.43 * way, xtol=1e-12, full_output=True)
    assert ok == 1
    expected, tol = value("interrupted_cutting", "chip of the doubled orbit at w = 1.2")
    assert abs(z[0] - tooth(z)[0]) == pytest.approx(expected, abs=tol)


def spectral_radius(p):
    """Return the multiplier of a small infection: Chebyshev collocation of I' = b S(t - tau) I(t - tau) - c I, pieces
    of length tau.
    """
    mu, beta, gamma, tau, T = 0.1, 4.0, 1.0, 0.5, 2.0
    missing = p / (1 - (1 - p) * math.exp(-mu * T))  # of the susceptible just after a pulse
    n = 20
    k = np.arange(n + 1)
    x = -np.cos(math.pi * k / n)
    # Differentiation on Chebyshev points (Trefethen, Spectral Methods in MATLAB, chapter 6).
    weights = np.where((k == 0) | (k == n), 2.0, 1.0) * (-1.0) ** k
    X = x[:, None] - x[None, :] + np.eye(n + 1)
    Dm = weights[:, None] / weights[None, :] / X
    Dm -= np.diag(Dm.sum(axis=1))
    Dm *= 2 / tau
    pieces = round(T / tau)
    step = np.eye(n + 1)
    for j in range(pieces):
        t = j * tau + tau * (x + 1) / 2
        # S is read on the piece before, whose last point is just before the pulse at its end.
        late = np.mod(t - tau, T)
        late[-1] = late[-2] + (t[-1] - t[-2])
        b = beta * math.exp(-mu * tau) * (1 - missing * np.exp(-mu * late))
        left = Dm + (mu + gamma) * np.eye(n + 1)
        right = np.diag(b)
        left[0], right[0] = np.eye(n + 1)[0], np.eye(n + 1)[-1]
        step = np.linalg.solve(left, right) @ step
    return float(np.max(np.abs(np.linalg.eigvals(step))))


def test_vaccination_threshold():
    expected, tol = value("pulse_vaccination", "threshold of vaccination")
    assert brentq(lambda p: spectral_radius(p) - 1, 0.3, 0.5, xtol=1e-13) == pytest.approx(expected, abs=tol)


def test_endemic():
    """The endemic orbit at p = 0.1, mean of I over a period; states S, I, the integral of I, a clock."""
    p, (mu, beta, gamma, tau, T) = 0.1, (0.1, 4.0, 1.0, 0.5, 2.0)

    def live(t, z, past):
        late = past(tau)
        return [
            mu * (1 - z[0]) - beta * z[0] * z[1],
            beta * math.exp(-mu * tau) * late[0] * late[1] - (mu + gamma) * z[1],
            z[1],
            1.0,
        ]

    def pulse(t, z, past):
        return [(1 - p) * z[0], z[1], z[2], 0.0]

    motion = Motion(
        {"live": live},
        {"live": [(lambda t, z, past: z[3] - T, 1, pulse, "live", "pulse")]},
        (tau,),
        lambda t: [0.3, 0.05, 0.0, 0.0],
        "live",
    ).run(160)
    counts = [z[2] for _, _, z in motion.events]
    expected, tol = value("pulse_vaccination", "infected at p = 0.1")
    assert (counts[-1] - counts[-2]) / T == pytest.approx(expected, abs=tol)


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


def test_delayed_predator_prey():
    """All rates as shipped, tau = 2.2, by upward passages of the prey through its resting value."""

    def grow(t, z, past):
        return [z[0] * (1 - past(2.2)[0] - z[1]), z[1] * (-1 + 2 * z[0] - z[1])]

    motion = Motion(
        {"m": grow}, {"m": [(lambda t, z, past: z[0] - 2 / 3, 1, same, "m", "up")]}, (2.2,), lambda t: [1.0, 0.2], "m"
    ).run(400)
    expected, tol = value("delayed_predator_prey", "period at tau = 2.2")
    assert settled_period(motion, "up") == pytest.approx(expected, abs=tol)


def test_wright():
    motion = Motion(
        {"m": lambda t, z, past: [-2 * past(1.0)[0] * (1 + z[0])]},
        {"m": [(lambda t, z, past: z[0], 1, same, "m", "up")]},
        (1.0,),
        lambda t: [0.1],
        "m",
    ).run(150)
    expected, tol = value("wright", "period")
    assert settled_period(motion, "up") == pytest.approx(expected, abs=tol)
    # x' = 0 one delay after an upward zero.
    top, tol = value("wright", "maximum")
    assert motion(motion.times("up")[-2] + 1.0)[0] == pytest.approx(top, abs=tol)


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


def test_suitcase():
    gamma, A, omega, r, tau = 0.248, 0.75, 1.37, 0.913, 0.1

    def side(sign):
        return lambda t, z, past: [
            z[1],
            A * math.sin(omega * t + math.asin(gamma / A))
            + math.sin(z[0])
            - past(tau)[0]
            - sign * gamma * math.cos(z[0]),
        ]

    def fall(t, z, past):
        return abs(z[0]) - math.pi / 2

    def upright(t, z, past):
        return z[0] if t > 1e-3 else 1.0

    def hit(t, z, past):
        return [z[0], r * z[1]]

    motion = Motion(
        {"right": side(1), "left": side(-1), "fallen": lambda t, z, past: [0.0, 0.0]},
        {
            "right": [(upright, -1, hit, "left", "hit"), (fall, 1, same, "fallen", "fall")],
            "left": [(upright, 1, hit, "right", "hit"), (fall, 1, same, "fallen", "fall")],
        },
        (tau,),
        lambda t: [0.0, 0.0],
        "right",
    ).run(12)
    found = [t for _, t, _ in motion.events]
    for i, what in enumerate(("first hit", "second hit", "fall")):
        expected, tol = value("suitcase", what)
        assert found[i] == pytest.approx(expected, abs=tol)


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
