"""Exact motions of a driven linear oscillator, from which orbits of piecewise linear models are put together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Oscillator:
    """x'' + c x' + k x = b + a cos(w t): its exact flow."""

    c: float
    k: float
    b: float = 0.0
    a: float = 1.0
    w: float = 1.0

    def forced(self, t):
        """Return the particular solution (x, v) at time ``t``."""
        z = self.a / (self.k - self.w**2 + 1j * self.c * self.w) * np.exp(1j * self.w * t)
        return np.array([z.real + self.b / self.k, (1j * self.w * z).real])

    def flow(self, t, state, duration):
        """Return (x, v) a ``duration`` after ``state`` at time ``t``."""
        return self.forced(t + duration) + self.free(duration) @ (np.asarray(state) - self.forced(t))

    def free(self, duration):
        """Return the matrix that takes a deviation to that a ``duration`` later."""
        s = np.emath.sqrt(self.c**2 / 4 - self.k + 0j)
        decay = np.exp(-self.c * duration / 2)
        cosine, sine = np.cosh(s * duration), (np.sinh(s * duration) / s if s != 0 else duration)
        g = self.c / 2
        return (decay * np.array([[cosine + g * sine, sine], [-self.k * sine, cosine - g * sine]])).real
