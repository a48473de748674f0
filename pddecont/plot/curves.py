"""Recorded orbits as smooth curves."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.results.reader import Step

Array = NDArray[np.float64]
PER_INTERVAL = 24


def segments(step: Step, row: int, what: str = "states") -> list[tuple[Array, Array]]:
    """Return (times, values) of each segment of a recorded orbit, from its own polynomials between the base points.

    ``what`` is ``states`` or ``delayed``. Shapes: times (n,), values (n, n_states) or (n, n_delayed).
    """
    orbit = step.orbit(row)
    degree = int(orbit["mesh"][0])
    result = []
    for s in np.unique(orbit["segment"]):
        inside = orbit["segment"] == s
        result.append(_fine(orbit["time"][inside], orbit[what][inside], degree))
    return result


def _fine(times: Array, states: Array, degree: int) -> tuple[Array, Array]:
    n = (len(times) - 1) // degree
    weights = (-1.0) ** np.arange(degree + 1)
    weights[[0, -1]] *= 0.5
    base = 0.5 - 0.5 * np.cos(np.pi * np.arange(degree + 1) / degree)
    sigma = np.linspace(0.0, 1.0, PER_INTERVAL, endpoint=False)
    gap = sigma[:, None] - base
    hit = np.abs(gap) < 1e-14
    terms = weights / np.where(hit, 1.0, gap)
    basis = np.where(hit.any(axis=1, keepdims=True), hit, terms / terms.sum(axis=1, keepdims=True))
    index = degree * np.arange(n)[:, None] + np.arange(degree + 1)
    fine = np.einsum("pb,jbn->jpn", basis, states[index]).reshape(-1, states.shape[1])
    left, right = times[index[:, 0]], times[index[:, -1]]
    t = (left[:, None] + sigma * (right - left)[:, None]).ravel()
    return np.append(t, times[-1]), np.vstack([fine, states[-1]])
