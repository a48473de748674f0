"""Expected values of populations, calculated a second time without the package's numbers."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.models.expected import value
from tests.models.method_of_steps import Motion, same, settled_period


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
