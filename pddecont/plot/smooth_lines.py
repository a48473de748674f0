"""Branches as lines: curved between their points as these lie, so that few of them are enough."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.plot.branch_parts import BranchPart, split_branch
from pddecont.plot.slopes import turn_slopes
from pddecont.results import Step

Array = NDArray[np.float64]
# From a point to the next a line has so many straight pieces.
PIECES = 8
# Points nearer to the one before than this share of a part's length add nothing to its shape but rounding.
SAME_POINT = 1e-6
# How far a slope may be from those of the lines to the points beside it, as a multiple of these.
STEEPER = 1.5


def smooth_branch(step: Step, columns: Array, slopes: Array | None = None) -> Array:
    """Return a branch as a line in order, :data:`PIECES` pieces from each point to the next.

    Along each of its parts every column is a cubic function of the arclength between two points. At a point it has the
    slope that is stored there or, where none is, that of the modified method of Akima, which overshoots neither at
    kinks nor at jumps. Where that is not possible the line is straight.

    Parameters
    ----------
    columns
        Values of each point, by rows of the step, shape (n_columns, n_points).
    slopes
        Their derivatives with respect to the arclength, of either sign, NaN where they are not known, of the same
        shape; none by default.

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
        stored = np.full(own.shape, np.nan) if slopes is None else slopes[:, part.rows]
        apart = np.diff(along, prepend=-np.inf) > SAME_POINT * abs(along[-1] - along[0])
        if np.count_nonzero(apart) > 2 and np.isfinite(along).all() and np.isfinite(own).all():
            line[:, slice_part(part)] = _interpolate(along, own, stored, apart)
    line[:, ::PIECES] = values
    return line


def slice_part(part: BranchPart) -> slice:
    """Return where a part lies in the line of its branch."""
    return slice(PIECES * part.start, PIECES * (part.start + len(part.rows) - 1) + 1)


def _interpolate(along: Array, columns: Array, stored: Array, apart: NDArray[np.bool_]) -> Array:
    """Return columns (n_columns, n) over arclengths (n,) between all points, shaped by those ``apart`` (n,)."""
    from scipy.interpolate import CubicHermiteSpline

    places = np.arange(PIECES * (len(along) - 1) + 1) / PIECES
    fine = np.interp(places, np.arange(len(along)), along)
    knots, values = along[apart], columns[:, apart]
    shape = CubicHermiteSpline(knots, values, _choose_slopes(knots, values, stored[:, apart]), axis=1)
    return np.asarray(shape(np.minimum(fine, knots[-1])))


def _choose_slopes(along: Array, columns: Array, stored: Array) -> Array:
    """Return the slopes of columns (n_columns, n) at arclengths (n,): those stored, where the points allow them.

    A stored slope is not that of the line on this side where a branch has a corner, as at a boundary. There it is
    further from the lines to the two neighbours than these are steep, :data:`STEEPER` times.
    """
    from scipy.interpolate import Akima1DInterpolator

    akima = Akima1DInterpolator(along, columns, axis=1, method="makima")(along, nu=1)
    turned = turn_slopes(stored, columns, along)
    chords = np.diff(columns, axis=1) / np.diff(along)
    before, after = chords[:, [0, *range(chords.shape[1])]], chords[:, [*range(chords.shape[1]), -1]]
    off = np.minimum(np.abs(turned - before), np.abs(turned - after))
    fits = off <= STEEPER * np.maximum(np.abs(before), np.abs(after))
    return np.where(fits, turned, akima)
