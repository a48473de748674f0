"""Branches as lines: curved between their points as these lie, so that few of them are enough."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.plot.branch_parts import BranchPart, split_branch
from pddecont.results import Step

Array = NDArray[np.float64]
# From a point to the next a line has so many straight pieces.
PIECES = 8
# Points nearer to the one before than this share of a part's length add nothing to its shape but rounding.
SAME_POINT = 1e-6


def smooth_branch(step: Step, columns: Array) -> Array:
    """Return a branch as a line in order, :data:`PIECES` pieces from each point to the next.

    Along each of its parts every column is a function of the arclength: piecewise cubic, by the modified method of
    Akima, which overshoots neither at kinks nor at jumps. Where that is not possible the line is straight.

    Parameters
    ----------
    columns
        Values of each point, by rows of the step, shape (n_columns, n_points).

    Returns
    -------
    numpy.ndarray
        Shape (n_columns, PIECES (n_points - 1) + 1); each PIECES-th value is that of a point.
    """
    places = np.arange(PIECES * (len(step) - 1) + 1) / PIECES
    values = columns[:, step.order]
    line = np.array([np.interp(places, np.arange(len(step)), column) for column in values])
    for part in split_branch(step):
        along = np.asarray(step.points["arclength"][part.rows], dtype=float)
        own = columns[:, part.rows]
        apart = np.diff(along, prepend=-np.inf) > SAME_POINT * abs(along[-1] - along[0])
        if np.count_nonzero(apart) > 2 and np.isfinite(along).all() and np.isfinite(own).all():
            line[:, slice_part(part)] = _interpolate(along, own, apart)
    line[:, ::PIECES] = values
    return line


def slice_part(part: BranchPart) -> slice:
    """Return where a part lies in the line of its branch."""
    return slice(PIECES * part.start, PIECES * (part.start + len(part.rows) - 1) + 1)


def _interpolate(along: Array, columns: Array, apart: NDArray[np.bool_]) -> Array:
    """Return columns (n_columns, n) over arclengths (n,) between all points, shaped by those ``apart`` (n,)."""
    from scipy.interpolate import Akima1DInterpolator

    places = np.arange(PIECES * (len(along) - 1) + 1) / PIECES
    fine = np.interp(places, np.arange(len(along)), along)
    shape = Akima1DInterpolator(along[apart], columns[:, apart], axis=1, method="makima")
    return np.asarray(shape(np.minimum(fine, along[apart][-1])))
