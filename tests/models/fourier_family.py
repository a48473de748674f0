"""Orbits of scalar equations whose lags depend on the state, by Fourier collocation, derivatives in closed form.

The equation is x' = -decay x - sum of k_i x(t - a_i - c x), the unknowns are x at equally spaced times and one of the
gains k_i, and the period is given: it goes on where the gain turns back. Perturbations exp(l t) p(t) of an orbit are
those of Hill's method.

Reference: Boyd, Chebyshev and Fourier Spectral Methods (2001), chapter 4.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True)
class Family:
    """An orbit of period ``period`` with values (2 n + 1,), and its equation; ``gains[0]`` is the unknown one."""

    values: np.ndarray
    period: float
    gains: tuple
    lags: tuple
    decay: float
    c: float = 1.0

    @property
    def times(self):
        """The times of the values, from 0 on."""
        return self.period * np.arange(len(self.values)) / len(self.values)

    def matrix(self, t, order=0):
        """Return the matrix (n_times, 2 n + 1) from values to those, or a derivative, at times ``t``."""
        m = len(self.values)
        k = 2j * np.pi / self.period * np.arange(-(m // 2), m // 2 + 1)
        return np.real((np.exp(np.multiply.outer(t, k)) * k**order) @ np.exp(-np.outer(k, self.times)) / m)

    def read(self):
        """Return for each lag its values along the orbit, the matrix that reads the past, and the rates read there."""
        result = []
        for a in self.lags:
            lag = a + self.c * self.values
            result.append((lag, self.matrix(self.times - lag), self.matrix(self.times - lag, 1) @ self.values))
        return result

    def hill(self, exponent):
        """Return the equations of p in exp(exponent t) p(t), a perturbation of the orbit."""
        unit = np.eye(len(self.values))
        result = self.matrix(self.times, 1) + (exponent + self.decay) * unit
        for k, (lag, past, rate) in zip(self.gains, self.read(), strict=True):
            result = result + k * (np.exp(-exponent * lag)[:, None] * past - self.c * np.diag(rate))
        return result

    def solve(self):
        """Return the orbit, its phase such that the rate at t = 0 is zero, by Newton's method."""
        now = self
        for _ in range(30):
            slope, reads = now.matrix(now.times, 1), now.read()
            left = slope @ now.values + now.decay * now.values
            left = left + sum(k * past @ now.values for k, (_, past, _) in zip(now.gains, reads, strict=True))
            left = np.append(left, slope[0] @ now.values)
            if np.max(np.abs(left)) < 1e-12 * (1 + np.max(np.abs(now.values))) * len(now.values):
                return now
            rows = np.block([[now.hill(0.0), (reads[0][1] @ now.values)[:, None]], [slope[:1], np.zeros((1, 1))]])
            step = np.linalg.solve(rows, -left)
            now = replace(now, values=now.values + step[:-1], gains=(now.gains[0] + step[-1], *now.gains[1:]))
        raise RuntimeError(f"no orbit of period {self.period}")

    def at(self, period, n, before=None):
        """Return the orbit of another period near this one, with n harmonics; ``before`` is one on the way here."""
        shares, share = np.arange(2 * n + 1) / (2 * n + 1), 0.0
        values, gain = self.matrix(shares * self.period) @ self.values, self.gains[0]
        if before is not None and before.period != self.period:
            share = (period - self.period) / (self.period - before.period)
            values = values + share * (values - before.matrix(shares * before.period) @ before.values)
            gain += share * (gain - before.gains[0])
        return replace(self, values=values, period=period, gains=(gain, *self.gains[1:])).solve()

    def follow(self, *stretches):
        """Return the orbits along stretches (periods, n), each the guess of the next one with those before it."""
        found = [self]
        for periods, n in stretches:
            for period in periods:
                found.append(found[-1].at(period, n, found[-2] if len(found) > 1 else None))
        return found[1:]

    def find_extrema(self):
        """Return the highest and the lowest value."""
        result = []
        for sign in (1, -1):
            t = self.times[int(np.argmax(sign * self.values))]
            for _ in range(20):
                rate, bend = (float((self.matrix(np.array([t]), order) @ self.values)[0]) for order in (1, 2))
                t -= rate / bend
            result.append(float((self.matrix(np.array([t])) @ self.values)[0]))
        return result

    def find_exponent(self, guess):
        """Return the exponent of a perturbation near ``guess``, by Newton's method on the smallest singular value."""
        exponent = complex(guess)
        for _ in range(30):
            u, s, vh = np.linalg.svd(self.hill(exponent))
            left, right = u[:, -1].conj(), vh[-1].conj()
            slope = left @ ((self.hill(exponent + 1e-6) - self.hill(exponent - 1e-6)) / 2e-6) @ right
            step = -s[-1] / slope
            exponent += step
            if abs(step) < 1e-12:
                return exponent
        raise RuntimeError(f"no exponent near {guess}")


def begin(gains, lags, decay, period, amplitude, c=1.0, n=16):
    """Return an orbit of a period and about an amplitude near a Hopf point of the gain ``gains[0]``."""
    t = 2 * np.pi * np.arange(2 * n + 1) / (2 * n + 1)
    return Family(amplitude * np.cos(t), period, gains, lags, decay, c).solve()
