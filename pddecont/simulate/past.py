"""A motion known as a piecewise polynomial, such as a periodic orbit, up to some time."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pddecont.native.integrator import N_COEFFICIENTS

Array = NDArray[np.float64]
Integers = NDArray[np.int64]


def make_extension_basis(s: Array) -> Array:
    """Return what the coefficients of a continuous extension are multiplied with at ``s`` (n,).

    The result has shape (n, 1 + N_COEFFICIENTS): its first column belongs to the value at the step's beginning. The
    polynomials have degree 0 to N_COEFFICIENTS.

    Reference: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), section II.6.
    """
    columns, product = [np.ones_like(s)], np.ones_like(s)
    for i in range(N_COEFFICIENTS):
        product = product * (s if i % 2 == 0 else 1.0 - s)
        columns.append(product)
    return np.stack(columns, axis=-1)


@dataclass(frozen=True, eq=False)
class Past:
    """A motion up to some time as steps with continuous extensions.

    Attributes
    ----------
    time, length, end
        Where a step begins, how long it is, and up to where it belongs to the motion (n_steps,).
    arc
        The arc that it belongs to (n_steps,): values and slopes jump where one follows another.
    value, coefficients
        Its continuous extension (n_steps, n_states), (n_steps, N_COEFFICIENTS, n_states).
    """

    time: Array
    length: Array
    end: Array
    arc: Integers
    value: Array
    coefficients: Array

    def until(self, t: float) -> Past:
        """Return the past up to ``t``, the step that holds it cut there."""
        n = max(1, int(np.searchsorted(self.time, t, side="left")))
        return Past(
            self.time[:n],
            self.length[:n],
            np.minimum(self.end[:n], t),
            self.arc[:n],
            self.value[:n],
            self.coefficients[:n],
        )

    def between(self, begin: float, end: float) -> Past:
        """Return the steps that hold times from ``begin`` to ``end``, whole."""
        rows = (self.end > begin) & (self.time < end)
        return Past(
            self.time[rows],
            self.length[rows],
            self.end[rows],
            self.arc[rows],
            self.value[rows],
            self.coefficients[rows],
        )

    def shift(self, by: float) -> Past:
        """Return the same motion so much later."""
        return replace(self, time=self.time + by, end=self.end + by)
