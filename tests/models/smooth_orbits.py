"""Orbits of the shipped models that read rates and integrals of the past, by Fourier collocation.

Each field is the model's equation written once more on ``t``, the states ``x`` (n_states, n_times) and ``read``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.special import roots_genlaguerre

from tests.fourier import find_fourier_orbit

GAUSS = np.polynomial.legendre.leggauss(24)
LAGUERRE = roots_genlaguerre(40, 1.0)


def line(t, x, read, R=0.3, g=0.8, b=0.2, tau=4.0):
    late, q = read(t - tau), (R - 1) / (R + 1)
    return -(1 - g) * x - b * x**3 + q * ((1 + g) * late - b * late**3) - q * read(t - tau, 1)


def logistic(t, x, read, c=0.2, tau=2.5):
    return x * (1 - read(t - tau) - c * read(t - tau, 1))


def blowflies(t, x, read, p=20.0, w=1.0, tau=3.0):
    late = read(t[:, None] - tau - 0.5 * w * GAUSS[0])
    return 0.5 * p * (late * np.exp(-late)) @ GAUSS[1] - x


def arm(t, x, read, P=1.5, D=1.5, A=0.2, tau=0.9):
    late, rate = read(t - tau), read(t - tau, 1)
    return np.array([x[1], np.sin(x[0]) - P * late[0] - D * late[1] - A * rate[1]])


def drivers(t, x, read, alpha=2.0, k=0.8, h=3.0, tau=0.8, theta=0.1):
    late = read(t[:, None] - tau - theta * LAGUERRE[0])
    gaps = [late[3], late[4], 3 * h - late[3] - late[4]]
    wished = [(np.tanh(k * (gap - h)) + math.tanh(k * h)) @ LAGUERRE[1] for gap in gaps]
    return np.array([*(alpha * (w - v) for w, v in zip(wished, x[:3], strict=True)), x[1] - x[0], x[2] - x[1]])


@dataclass(frozen=True)
class Extrema:
    """The period of an orbit, and each state's (lowest, highest)."""

    period: float
    of: list[tuple[float, float]]


def find_extrema(orbit):
    """Return the extrema of a Fourier orbit."""
    n_states = len(orbit.coefficients)
    t = np.linspace(0, orbit.period, 2001)
    found = []
    for i in range(n_states):
        pair = []
        for sign in (1.0, -1.0):

            def height(s, i=i, sign=sign):
                return sign * float(orbit(s)[i])

            near = t[int(np.argmin(sign * orbit(t)[i]))]
            best = minimize_scalar(
                height, bounds=(near - t[1], near + t[1]), method="bounded", options={"xatol": 1e-10}
            )
            pair.append(sign * best.fun)
        found.append((pair[0], pair[1]))
    return Extrema(orbit.period, found)


def find_orbit(field, guess, period, n):
    """Return the orbit of an autonomous field near a guess, by 16 harmonics and then ``n``."""
    found = find_fourier_orbit(field, guess, period, 16, free_period=True, steps=60)
    found = find_fourier_orbit(field, found, found.period, n, free_period=True)
    assert found.residual < 1e-10
    assert np.max(np.abs(found.coefficients[:, 0])) < 1e-10
    return found
