"""How many characteristic roots lie to the right of the imaginary axis, and whether others crossed it and came back.

Two points of a branch with as many unstable roots may have a pair between them that crosses the axis twice, or one that
crosses to the right and another one to the left. Where each pair goes is told by its speed along the branch,

    d lambda / d s = -p (d Delta / d s) q / (p Delta'(lambda) q)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import linear_sum_assignment

from pddecont.continuation import Counts, CurvePoint
from pddecont.equilibrium.characteristic import DENSE, CharacteristicMatrix
from pddecont.equilibrium.roots import ON_AXIS, Roots

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
# Length of the steps over which Delta is differentiated along the branch, as a part of the tangent.
DIFFERENCE = 1e-6


@dataclass(frozen=True, eq=False)
class Motion:
    """Pairs of roots (n_pairs,), given by the upper ones, and their speeds along the ``tangent`` (n_unknowns,) at x."""

    pairs: Complex
    speeds: Complex
    x: Array
    tangent: Array

    def project(self, between: Array) -> float:
        """Return how many times the tangent leads along a way."""
        return float(between @ self.tangent / (self.tangent @ self.tangent))


class RootCounts(tuple[int, int]):
    """How many roots to the right of the imaginary axis are real, how many pairs are not, and where all pairs go."""

    motion: Motion


def count_unstable(point: CurvePoint[Any]) -> RootCounts:
    """Return how many roots of an equilibrium of a branch lie to the right of the imaginary axis."""
    roots: Roots = point.at.roots
    right = roots.values[roots.values.real > 0.0]
    counts = RootCounts((int(np.sum(right.imag == 0.0)), int(np.sum(right.imag > 0.0))))
    pairs = np.flatnonzero(roots.values.imag > 0.0)
    scale = point.system.scaling.scale
    speeds = np.zeros(len(pairs), dtype=complex)
    if len(scale) and point.at.equilibrium.motion.n_states <= DENSE:
        speeds = _find_speeds(point, roots.values[pairs], roots.vectors[pairs])
    counts.motion = Motion(roots.values[pairs], speeds, point.x / scale, point.tangent / scale)
    return counts


def _find_speeds(point: CurvePoint[Any], values: Complex, vectors: Complex) -> Complex:
    """Return how fast roots move along the branch's tangent (n_roots,)."""
    here, before, after = (
        _linearise(point.system.at(point.x + way * DIFFERENCE * point.tangent)) for way in (0.0, -1.0, 1.0)
    )
    transposed = here.transpose()
    speeds = np.zeros(len(values), dtype=complex)
    for k, (value, q) in enumerate(zip(values.tolist(), vectors, strict=True)):
        p = transposed.find_smallest(value)[1]
        change = (after.at(value)[0] - before.at(value)[0]) / (2.0 * DIFFERENCE)
        with np.errstate(all="ignore"):
            speeds[k] = -(p @ (change @ q)) / (p @ (here.at(value)[1] @ q))
    return np.where(np.isfinite(speeds), speeds, 0.0)


def _linearise(at: Any) -> CharacteristicMatrix:
    equilibrium = at.equilibrium
    matrix: CharacteristicMatrix = equilibrium.motion.linearise(equilibrium.states, equilibrium.parameters)
    return matrix


def hides_crossings(before: Counts, after: Counts) -> bool:
    """Return whether more pairs may have crossed the axis between two points than their numbers show.

    Each pair is taken for that of the other point to which, with their speeds, all together are nearest. In between it
    is the cubic that has both values and both speeds; where the speeds lead past the other value by more than the pair
    is away from the axis, it may have crossed too.
    """
    if not isinstance(before, RootCounts) or not isinstance(after, RootCounts):
        return False
    a, b = before.motion, after.motion
    if a.x.shape != b.x.shape:
        return False
    ahead, back = (m.speeds * m.project(b.x - a.x) for m in (a, b))
    misses = [np.abs((a.pairs + ahead)[:, None] - b.pairs), np.abs(a.pairs[:, None] - (b.pairs - back))]
    rows, columns = linear_sum_assignment(misses[0] + misses[1])
    ends = np.stack([a.pairs[rows].real, b.pairs[columns].real])
    slopes = np.stack([ahead[rows].real, back[columns].real])
    # A pair on the axis at both ends, but for rounding, is there all along, as without damping: it crosses nowhere.
    moves = np.any(np.abs(ends) > ON_AXIS * np.abs(np.stack([a.pairs[rows], b.pairs[columns]])), axis=0)
    doubtful = np.min(np.abs(ends), axis=0) <= np.maximum(*misses)[rows, columns]
    if np.any(moves & doubtful & (ends[0] * ends[1] > 0.0)):
        return True
    zeros = CubicHermiteSpline([0.0, 1.0], ends[:, moves], slopes[:, moves]).roots(extrapolate=False)
    return sum(len(of_pair) for of_pair in zeros) > abs(after[1] - before[1])
