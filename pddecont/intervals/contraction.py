"""Boxes made smaller without the loss of a zero, and whether one holds more than one.

Over a box X with the midpoint c all zeros x of equations F satisfy

    F(c) + J (x - c) = 0,    J in the slopes J(X) over the box.

Each row gives an interval for each unknown that has a slope other than zero in it; so do the rows of C F, C being the
inverse of the middle of J(X), for which J is nearly the unit matrix. Where C J is regular for every J in J(X) no two
zeros lie in X. Where the operator of Krawczyk

    K(X) = c - C F(c) + (1 - C J(X)) (X - c)

leads into the inside of X there is one.

References: Krawczyk, Computing 4 (1969) 187, doi:10.1007/BF02234767; Neumaier, Interval Methods for Systems of
Equations (1990), chapters 4 and 5.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import accumulate
from operator import add

import numpy as np

from pddecont.intervals.arithmetic import Array, Bools, Interval, invert, make_interval, make_point, stack
from pddecont.intervals.boxes import Boxes
from pddecont.intervals.enclosure import Enclosure

# How often rows are gone through with the same slopes.
SWEEPS = 2
# Steps towards the positive vector in which a distance from the unit matrix is smallest.
POWERS = 6
# Underflow of products.
TINY = float(np.finfo(float).tiny)
# A distance below this is below one, rounding errors included.
SLACK = 0.99


@dataclass(frozen=True, eq=False)
class Rows:
    """Linear equations over boxes: ``slopes`` (n, n_variables, n_boxes), ``values`` at the centres (n, n_boxes)."""

    slopes: Interval
    values: Interval

    def __getitem__(self, chosen: Bools) -> Rows:
        return Rows(self.slopes[..., chosen], self.values[..., chosen])


@dataclass(frozen=True, eq=False)
class Outcome:
    """Boxes that may hold a zero, as they were ``before``, and what is ``left`` of them.

    ``single`` says which of them hold no more than one.
    """

    before: Boxes
    left: Boxes
    single: Bools

    def __getitem__(self, chosen: Bools) -> Outcome:
        return Outcome(self.before[chosen], self.left[chosen], self.single[chosen])

    @property
    def is_inside(self) -> Bools:
        """Whether what is left of a box lies inside it."""
        inside = (self.left.low > self.before.low) & (self.left.high < self.before.high)
        return np.asarray(np.all(inside | (self.before.widths == 0.0), axis=0))


def contract(equations: Enclosure, boxes: Boxes) -> Outcome:
    """Return what is left of boxes, of as many unknowns as there are equations."""
    values, slopes = equations.derivatives(boxes.low, boxes.high)
    kept = np.all(values.holds_zero, axis=0)
    boxes, values, slopes = boxes[kept], values[:, kept], slopes[..., kept]
    smooth = np.all(values.sure, axis=0) & np.all(slopes.is_bounded, axis=(0, 1))
    low, high, single = boxes.low.copy(), boxes.high.copy(), np.zeros(len(boxes), dtype=bool)
    if np.any(smooth):
        inner, center = boxes[smooth], boxes[smooth].center
        rows = Rows(slopes[..., smooth], equations.values(center, center))
        near = precondition(rows)
        single[smooth] = is_regular(near.slopes, inner.widths)
        for part in (rows, near):
            inner = _narrow(inner, center, part)
        low[:, smooth], high[:, smooth] = inner.low, inner.high
    outcome = Outcome(boxes, Boxes(low, high), single)
    return outcome[~outcome.left.is_empty]


def precondition(rows: Rows) -> Rows:
    """Return rows multiplied by the inverse of the middle of their slopes."""
    inverse = invert_matrices(rows.slopes.middle)
    return Rows(multiply(inverse, rows.slopes), multiply(inverse, rows.values[:, None])[:, 0])


def multiply(matrices: Array, intervals: Interval) -> Interval:
    """Return the products of matrices (n, n, n_boxes) with matrices of bounded intervals (n, m, n_boxes).

    Products of middles and radii, with a bound on the rounding errors of sums of products (Higham, Accuracy and
    Stability of Numerical Algorithms, 2002, equation 3.13).
    """
    left, middle = np.moveaxis(matrices, -1, 0), np.moveaxis(intervals.middle, -1, 0)
    radius = np.maximum(np.moveaxis(intervals.high, -1, 0) - middle, middle - np.moveaxis(intervals.low, -1, 0))
    error = 2.0 * (left.shape[1] + 3) * np.finfo(float).eps
    product, reach = left @ middle, np.abs(left) @ (radius + error * (np.abs(middle) + radius)) + TINY
    low, high = (np.moveaxis(np.nextafter(product + way * reach, way * np.inf), 0, -1) for way in (-1.0, 1.0))
    return Interval(low, high, np.broadcast_to(intervals.sure[:1], low.shape))


def invert_matrices(matrices: Array) -> Array:
    """Return inverses (n, n, n_boxes) of matrices of that shape; of singular ones something like it."""
    stacked = np.moveaxis(matrices, -1, 0)
    try:
        inverse = np.linalg.inv(stacked)
    except np.linalg.LinAlgError:
        inverse = np.linalg.pinv(stacked)
    return np.moveaxis(np.nan_to_num(inverse, nan=0.0, posinf=0.0, neginf=0.0), 0, -1)


def is_regular(slopes: Interval, widths: Array) -> Bools:
    """Return where no matrix in ``slopes`` (n, n, n_boxes) takes a difference of two points of a box to zero.

    The matrices are near the unit matrix: with positive numbers d, |1 - A| d < d. Unknowns of which a box holds one
    value do not count.
    """
    wide = widths > 0.0
    scale = np.where(wide, widths, 1.0)
    distance = np.where(wide[:, None] & wide[None], measure_distance(slopes) * scale[None] / scale[:, None], 0.0)
    d = np.where(wide, 1.0, 0.0)
    for _ in range(POWERS):
        reached = np.einsum("jkb,kb->jb", distance, d)
        d = np.where(wide, d + reached / np.maximum(np.max(reached, axis=0), 1.0), 0.0)
    reached = np.einsum("jkb,kb->jb", distance, d)
    return np.asarray(np.all((reached < SLACK * d) | ~wide, axis=0))


def measure_distance(slopes: Interval) -> Array:
    """Return a bound on |A - 1| for the matrices A in ``slopes``."""
    return (slopes - make_point(np.eye(slopes.low.shape[0])[:, :, None])).magnitude


def _narrow(boxes: Boxes, center: Array, rows: Rows) -> Boxes:
    """Return what linear equations leave of boxes."""
    n, at = boxes.low.shape[0], make_point(center)
    bounds = invert(rows.slopes)
    solvable = ~rows.slopes.holds_zero & bounds.is_bounded
    for _ in range(SWEEPS):
        away = make_interval(boxes.low, boxes.high) - at
        terms = rows.slopes * away[None]
        before = list(accumulate([rows.values, *(terms[:, k] for k in range(n))], add))
        after = list(accumulate([terms[:, k] for k in range(n - 1, 0, -1)], add))[::-1]
        others = [b + a for b, a in zip(before, after, strict=False)] + [before[n - 1]]
        found = at[None] - stack(others, axis=1) * bounds
        low = np.max(np.where(solvable, found.low, -np.inf), axis=0)
        high = np.min(np.where(solvable, found.high, np.inf), axis=0)
        nothing = np.any(~before[n].holds_zero, axis=0)
        boxes = Boxes(np.maximum(boxes.low, np.where(nothing, np.inf, low)), np.minimum(boxes.high, high))
    return boxes
