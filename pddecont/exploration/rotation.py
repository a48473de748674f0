"""The rotation number of a motion on a torus, from its returns to a section.

The returns lie on a closed curve; the rotation number is the part of it by which they go on in one return, in the mean.
Which way round is forward nobody can say, so that rho and 1 - rho are one: it lies between 0 and 1/2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# Returns from which a rotation number is taken at least, of motions without a period and of periodic ones.
LEAST_RETURNS, LEAST_PERIOD = 64, 3
# The widest gap between directions in which returns are seen from amid them, for them to go all round.
WIDEST_GAP = 2.5
# How much the distance from amid them may go up and down along the curve, in parts of its range: a curve that no
# direction meets twice goes so a few times, points of a cloud once or so each.
MOST_TURNS = 16.0
# What covers less than this part of how far motions go is at rest: it settles yet, as noise does. Of two extents one
# that is so small beside the other makes a line.
STILL, LINE = 1e-5, 1e-9


@dataclass(frozen=True)
class RotationNumber:
    """A rotation number from 0 to 1/2, and how far those of halves and thirds of the motion lie from it."""

    value: float
    error: float


def find_rotation_number(returns: Array, scale: Array, *, is_periodic: bool = False) -> RotationNumber | None:
    """Return the rotation number of returns (n_returns, n_states); None if they do not go round a curve.

    ``scale`` is how far motions of the model go (n_states,).

    The directions in which returns are seen from their middle, in the plane of their largest extents, have to follow
    the curve: no direction meets it twice. Of a periodic motion, whose returns are those of one period, the number is
    a fraction. Of others it is a mean with weights that fall to zero at both ends, which converges faster than any
    power of the number of returns.

    References
    ----------
    Das, Saiki, Sander, Yorke, Nonlinearity 30 (2017) 4111.
    """
    n = len(returns)
    if n < (LEAST_PERIOD if is_periodic else LEAST_RETURNS):
        return None
    seen = _project(returns, scale)
    if seen is None:
        return None
    angles = np.arctan2(seen[:, 1], seen[:, 0])
    order = np.argsort(angles, kind="stable")
    gaps = np.diff(angles[order], append=angles[order[0]] + 2 * np.pi)
    if np.max(gaps) > WIDEST_GAP or not (is_periodic or _is_curve(np.linalg.norm(seen, axis=1)[order])):
        return None
    turns = (np.roll(angles, -1) - angles if is_periodic else np.diff(angles)) / (2 * np.pi)
    turns = _lift(turns, order[order < len(turns)])
    if is_periodic:
        return RotationNumber(_fold(round(float(np.sum(turns))) / n), 0.0)
    mean = _average(turns)
    parts = [_average(part) for count in (2, 3) for part in np.array_split(turns, count)]
    return RotationNumber(_fold(mean), max(abs(part - mean) for part in parts))


def _project(returns: Array, scale: Array) -> Array | None:
    """Return returns in the plane of their largest extents (n_returns, 2), each of unit size; None of a point or line.

    States are taken in units of what they cover.
    """
    size = np.ptp(returns, axis=0)
    moves = size > STILL * scale
    if np.count_nonzero(moves) < 2:
        return None
    centred = (returns[:, moves] - returns[:, moves].mean(axis=0)) / size[moves]
    left, singular, _ = np.linalg.svd(centred, full_matrices=False)
    return None if singular[1] < LINE * singular[0] else left[:, :2]


def _is_curve(distances: Array) -> bool:
    """Return whether distances, in the order of their directions, are those of a curve and not of a cloud."""
    return float(np.sum(np.abs(np.diff(distances)))) <= MOST_TURNS * float(np.ptp(distances)) + LINE * len(distances)


def _lift(turns: Array, order: NDArray[np.intp]) -> Array:
    """Return turns, known but for whole ones, so that they change gradually round the curve."""
    lifted = np.empty(len(turns))
    lifted[order] = np.unwrap(turns[order], period=1.0)
    return lifted


def _average(turns: Array) -> float:
    places = (np.arange(len(turns)) + 0.5) / len(turns)
    weights = np.exp(-1.0 / (places * (1.0 - places)))
    return float(np.sum(weights * turns) / np.sum(weights))


def _fold(turn: float) -> float:
    part = turn % 1.0
    return min(part, 1.0 - part)
