"""Expected values of machines and of what balances, calculated a second time without the package's numbers."""

import math

import numpy as np
import pytest
from scipy.optimize import fsolve

from tests.models.expected import value
from tests.models.method_of_steps import Motion, same, settled_period


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
