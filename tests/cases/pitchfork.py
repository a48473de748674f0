"""The pitchfork of ``pitchfork_neutral.yaml`` by Fourier collocation: where symmetric orbits have asymmetric ones near.

Symmetric orbits, x(t + T/2) = -x(t), have odd harmonics alone. The equation linearised about one does not mix even
harmonics with odd ones: the pitchfork is where its even part is singular.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq

from tests.fourier import find_fourier_orbit

CHI, MU, TAU, N = 0.05, -1.0, 0.1, 32
# Amplitudes and phases of the first harmonics nearby, to begin from.
SHAPE = ((0.75, 0.0), (1.26, 1.57), (0.14, 3.58), (0.24, 5.15))


def _field(k):
    def field(t, x, read):
        stretch = x[0] - x[2]
        link = -2 * CHI * (x[1] - x[3]) - stretch - MU * stretch**3
        return np.array([x[1], link - x[0] + k * read(t - TAU, 1)[1], x[3], -link])

    return field


def _even_determinant(k, orbit):
    """Return the determinant of the linearised equation on even harmonics, in units of its diagonal."""
    even = np.arange(-N, N + 1, 2)
    m, w = 4 * N + 1, 2 * math.pi / orbit.period
    t = orbit.period * np.arange(m) / m
    x = orbit(t)
    stiffness = 1 + 3 * MU * (x[0] - x[2]) ** 2
    harmonics = np.fft.fft(stiffness) / m
    mixing = harmonics[(even[:, None] - even[None, :]) % m]
    one, rate = np.eye(len(even)), np.diag(1j * w * even)
    late = np.diag(k * 1j * w * even * np.exp(-1j * w * even * TAU))
    zero, damping = 0 * one, 2 * CHI * one
    matrix = np.block(
        [
            [rate, -one, zero, zero],
            [mixing + one, rate + damping - late, -mixing, -damping],
            [zero, zero, rate, -one],
            [-mixing, -damping, mixing, rate + damping],
        ]
    )
    # Series of real functions: the determinant is real but for rounding.
    sign, size = np.linalg.slogdet(matrix)
    return float(sign.real * np.exp(size - 4 * np.sum(np.log1p(np.abs(np.diag(rate))))))


def find_pitchfork():
    """Return k at the pitchfork."""
    guess = lambda t: np.array([a * np.cos(2 * math.pi * t / 3.72 + s) for a, s in SHAPE])  # noqa: E731
    start = find_fourier_orbit(_field(0.481), guess, 3.72, 8, free_period=True, steps=60)

    def orbit_at(k):
        return find_fourier_orbit(_field(k), start, start.period, N // 2, free_period=True)

    return brentq(lambda k: _even_determinant(k, orbit_at(k)), 0.4815, 0.4825, xtol=1e-12)
