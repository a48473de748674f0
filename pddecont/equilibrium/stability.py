"""The characteristic roots that tell the stability of an equilibrium."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from pddecont.continuation import Counts
from pddecont.equilibrium.constant_motion import ConstantMotion
from pddecont.equilibrium.roots import N_ROOTS, Roots, find_roots

Array = NDArray[np.float64]


def find_own_roots(motion: ConstantMotion, states: Array, parameters: Array, n_roots: int = N_ROOTS) -> Roots:
    """Return the leading characteristic roots of an equilibrium in its mode.

    A mode that slides along a surface has the root zero for it, which says nothing: each is left out once.
    """
    n_zero = len(motion.surfaces)
    roots = find_roots(motion.linearise(states, parameters), n_roots + n_zero)
    if not n_zero:
        return roots
    kept = np.sort(np.argsort(np.abs(roots.values))[n_zero:])
    return replace(roots, values=roots.values[kept], residuals=roots.residuals[kept], vectors=roots.vectors[kept])


class RootCounts(tuple[int, int]):
    """How many roots to the right of the imaginary axis are real, and how many pairs are not; ``pairs`` are all pairs.

    The pairs (n_pairs,) are given by their upper roots.
    """

    pairs: NDArray[np.complex128]


def count_unstable(roots: Roots) -> RootCounts:
    """Return how many roots to the right of the imaginary axis are real, and how many pairs are not."""
    right = roots.values[roots.values.real > 0.0]
    counts = RootCounts((int(np.sum(right.imag == 0.0)), int(np.sum(right.imag > 0.0))))
    counts.pairs = roots.values[roots.values.imag > 0.0]
    return counts


def hides_crossings(before: Counts, after: Counts) -> bool:
    """Return whether pairs seem to have crossed the axis in both directions: more than their numbers show.

    Each pair is taken for that of the other point to which all together are nearest.
    """
    if not isinstance(before, RootCounts) or not isinstance(after, RootCounts):
        return False
    rows, columns = linear_sum_assignment(np.abs(before.pairs[:, None] - after.pairs))
    crossed = (before.pairs[rows].real > 0.0) != (after.pairs[columns].real > 0.0)
    return int(np.sum(crossed)) > abs(after[1] - before[1])
