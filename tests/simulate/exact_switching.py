"""Exact solutions of linear modes between events: what random motions are compared with.

Between events x' = A x + b with distinct eigenvalues, and clocks r' = rate. Every linear function of them is
offset + rate t + Re sum w_j exp(lambda_j t): its values are exact, and its second derivative is bounded on an interval,
so that whether it has a zero there is decided and not sampled. Nothing here is taken from the program.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

# Places at which each arc is looked at first, and how often what is undecided between two of them is halved.
PLACES, HALVINGS = 9, 44


@dataclass(frozen=True)
class Functions:
    """Functions of time (n,), one an arc: offset + rate t + Re sum_j weights_j exp(powers_j t)."""

    offset: np.ndarray
    rate: np.ndarray
    weights: np.ndarray
    powers: np.ndarray

    def take(self, rows):
        return Functions(self.offset[rows], self.rate[rows], self.weights[rows], self.powers[rows])

    def value(self, t):
        return self.offset + self.rate * t + np.sum((self.weights * np.exp(self.powers * t[:, None])).real, axis=1)

    def slope(self, t):
        return self.rate + np.sum((self.powers * self.weights * np.exp(self.powers * t[:, None])).real, axis=1)

    def bound_curvature(self, a, b):
        """Return how large the second derivative is on [a, b] at most."""
        growth = np.maximum(np.exp(self.powers.real * a[:, None]), np.exp(self.powers.real * b[:, None]))
        return np.sum(np.abs(self.powers**2 * self.weights) * growth, axis=1)


@dataclass(frozen=True)
class LinearMode:
    """A mode x' = A x + b, r' = rate."""

    A: np.ndarray
    b: np.ndarray
    rate: float = 0.0

    def follow(self, states, row, clock=0.0, constant=0.0):
        """Return row x + clock r + constant along the arcs that begin at ``states`` (n, n_states), r last if any."""
        powers, vectors = np.linalg.eig(self.A)
        rest = -np.linalg.solve(self.A, self.b)
        n = len(rest)
        weights = ((states[:, :n] - rest) @ np.linalg.inv(vectors).T) * (row @ vectors)
        r = states[:, n] if states.shape[1] > n else 0.0
        offset = np.full(len(states), row @ rest + constant) + clock * r
        return Functions(offset, np.full(len(states), clock * self.rate), weights, np.tile(powers, (len(states), 1)))


def find_wrong_side(functions, side, lengths, margin, starts_on_zero):
    """Return of each arc whether its function is on the wrong side of zero by more than ``margin`` anywhere inside it.

    ``side`` (n,) is where it has to be. Where an arc ``starts_on_zero`` the function has just been there: what rounding
    made of its value at the start is taken away. Undecided parts, a margin from zero, count as right.
    """
    wrong = np.zeros(len(side), dtype=bool)
    shift = np.where(starts_on_zero, functions.value(np.zeros(len(side))), 0.0)
    edges = np.linspace(0.0, 1.0, PLACES)
    arc = np.repeat(np.arange(len(side)), PLACES - 1)
    a, b = (np.tile(e, len(side)) * lengths[arc] for e in (edges[:-1], edges[1:]))
    for _ in range(HALVINGS):
        part = functions.take(arc)
        low = np.minimum(*((part.value(t) - shift[arc]) * side[arc] for t in (a, b)))
        wrong[arc[low < -margin]] = True
        # Between two places a function is no lower than the lower of them less M (b - a)^2 / 8.
        open_ = (low - part.bound_curvature(a, b) * (b - a) ** 2 / 8 < -margin) & ~wrong[arc]
        if not open_.any():
            break
        a, b, arc = a[open_], b[open_], arc[open_]
        middle = 0.5 * (a + b)
        a, b, arc = np.concatenate([a, middle]), np.concatenate([middle, b]), np.concatenate([arc, arc])
    return wrong
