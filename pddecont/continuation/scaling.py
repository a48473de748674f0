"""What counts as a length along a branch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ConvergenceError
from pddecont.memo import cached_property

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Scaling:
    """Typical size and weight of each unknown, shape (n_unknowns,) each: |dx|^2 = sum_i weight_i (dx_i / scale_i)^2.

    An unknown of weight 0 follows from others and makes no length of its own.
    """

    scale: Array
    weight: Array

    @cached_property
    def size(self) -> Array:
        """How far each unknown moves when a direction of length one lies along it; its scale where it has no weight."""
        return self.scale / np.sqrt(np.where(self.weight > 0.0, self.weight, 1.0))

    def dot(self, a: Array, b: Array) -> float:
        """Return the inner product of two directions."""
        return float((self.weight * (a / self.scale) * (b / self.scale)).sum())

    def length(self, a: Array) -> float:
        """Return the length of a direction."""
        return float(np.sqrt(self.dot(a, a)))

    def find_angle(self, a: Array, b: Array) -> float:
        """Return the angle between two directions, in radians; none where one of them has no length."""
        lengths = self.length(a) * self.length(b)
        return float(np.arccos(np.clip(self.dot(a, b) / lengths, -1.0, 1.0))) if lengths > 0.0 else 0.0

    def covector(self, a: Array) -> Array:
        """Return the row that takes the inner product with ``a``."""
        return self.weight * a / self.scale**2

    def normalise(self, a: Array) -> Array:
        """Return ``a`` at length one.

        Raises
        ------
        ConvergenceError
            If it has no length: of a step that rounding leaves nothing of, or a branch of one point.
        """
        length = self.length(a)
        if length == 0.0:
            raise ConvergenceError("the branch goes nowhere: a step along it is lost in rounding")
        result: Array = a / length
        return result
