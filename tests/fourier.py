"""Periodic orbits by Fourier collocation: trigonometric polynomials that obey an equation at equally spaced times.

For smooth orbits the error falls faster than any power of the number of harmonics, and nothing of it is shared with
piecewise polynomials: the past is read from the Fourier series itself.

Reference: Boyd, Chebyshev and Fourier Spectral Methods (2001), chapter 4.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class FourierOrbit:
    """A periodic orbit with coefficients (n_states, 2 N + 1) of exp(i k w t), k = -N .. N; ``residual`` is the largest
    left of its equations."""

    coefficients: np.ndarray
    period: float
    residual: float

    def __call__(self, t, derivative=0):
        """Return the states, or a derivative, at times of any shape: (n_states, *shape)."""
        return _evaluate(self.coefficients, self.period, t, derivative)


def _evaluate(coefficients, period, t, derivative):
    """Return Re of sum over k >= 0, by k = width a + b: few powers of exp(i w t) make all. The series is real."""
    n, rate, t = (coefficients.shape[1] - 1) // 2, 2j * np.pi / period, np.asarray(t)
    k, width = np.arange(n + 1), int(np.ceil(np.sqrt(n + 1)))
    positive = np.where(k > 0, 2.0, 1.0) * (rate * k) ** derivative * coefficients[:, n:]
    blocks = np.zeros((len(coefficients), width * width), dtype=complex)
    blocks[:, : n + 1] = positive
    fine = np.exp(np.multiply.outer(rate * t.ravel(), np.arange(width)))
    coarse = np.exp(np.multiply.outer(rate * width * t.ravel(), np.arange(width)))
    parts = fine @ blocks.reshape(-1, width).T
    sums = np.einsum("ta,tsa->st", coarse, parts.reshape(len(fine), len(blocks), width))
    return np.real(sums).reshape(len(blocks), *t.shape)


def find_fourier_orbit(field, guess, period, n, *, free_period=False, steps=30):
    """Return the orbit of x' = field(t, x, read) near ``guess``(t), (n_states, n_times), by Newton's method.

    ``read(s, derivative=0)`` returns the states at times ``s`` (n_times, ...), or their derivative. With
    ``free_period`` the equation does not depend on time, and the first state's rate at t = 0 is zero.
    """
    m = 2 * n + 1
    shares = np.arange(m) / m
    values = guess(period * shares)
    n_states = len(values)
    transform = np.exp(-2j * np.pi * np.outer(np.arange(-n, n + 1), shares)) / m

    def residual(u):
        x, turn = u[: n_states * m].reshape(n_states, m), u[-1] if free_period else period
        c = x @ transform.T
        t = turn * shares
        rate = _evaluate(c, turn, t, 1)
        left = rate - field(t, x, lambda s, derivative=0: _evaluate(c, turn, s, derivative))
        return np.append(left.ravel(), rate[0, 0]) if free_period else left.ravel()

    u = np.append(values.ravel(), period) if free_period else values.ravel()
    jacobian, last, is_new = np.empty((len(u), len(u))), np.inf, False
    for _ in range(steps):
        r = residual(u)
        size = np.max(np.abs(r))
        # What is left is rounding where it stays.
        if size < 1e-13 or (is_new and size < 1e-9 and size > 0.5 * last):
            break
        # Derivatives serve as long as each step leaves a tenth.
        is_new = not size < 0.1 * last or np.isinf(last)
        for j in range(len(u) if is_new else 0):
            step = 1e-7 * max(1.0, abs(u[j]))
            moved = u.copy()
            moved[j] += step
            jacobian[:, j] = (residual(moved) - r) / step
        u, last = u - np.linalg.solve(jacobian, r), size
    turn = float(u[-1]) if free_period else period
    x = u[: n_states * m].reshape(n_states, m)
    return FourierOrbit(x @ transform.T, turn, float(np.max(np.abs(residual(u)))))
