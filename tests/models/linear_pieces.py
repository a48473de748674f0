"""Motions that are linear piece by piece, by matrix exponentials: independent of the package."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq


class Flow:
    """The flow of z' = A z + b: ``flow(z, t)`` is the state (n_states,) a time t after z."""

    def __init__(self, A, b):
        n = len(b)
        self.matrix = np.zeros((n + 1, n + 1))
        self.matrix[:n, :n], self.matrix[:n, n] = A, b

    def __call__(self, z, t):
        return (expm(self.matrix * t) @ np.append(z, 1.0))[:-1]

    def slope(self, z):
        """Return z'."""
        return self.matrix[:-1] @ np.append(z, 1.0)

    def time_to(self, z, function, longest, n_samples=400, after=1e-9):
        """Return the first time at which ``function(z)`` changes sign along the flow, looked for in steps."""
        times = np.linspace(after, longest, n_samples)
        step, state = expm(self.matrix * (times[1] - times[0])), np.append(self(z, after), 1.0)
        value = function(state[:-1])
        for first, last in pairwise(times):
            state = step @ state
            if function(state[:-1]) * value <= 0:
                return brentq(lambda t: function(self(z, t)), first, last, xtol=1e-15, rtol=1e-14)
        raise ValueError("the function does not change sign")
