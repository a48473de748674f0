"""The sides of a curve in two parameters: a soft band on the one where its orbits, or equilibria, live on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pddecont.plot.columns import list_free_parameters
from pddecont.plot.slopes import read_columns_with_slopes
from pddecont.plot.smooth_lines import PIECES, smooth_branch
from pddecont.plot.special_points import read_curve_sort
from pddecont.results import Step

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
# Width of a band, as a share of the smaller side of the axes.
BAND_WIDTH = 0.055
# A band fades outwards: areas of these shares of its width lie over one another.
SHADES, OPACITY = (1.0, 0.66, 0.33), 0.11
# Shares of its width that a band may have where another part of the curve is near, the widest first.
NARROWER = np.linspace(1.0, 0.05, 20)
# A point counts as beside the curve if no other part of it is nearer than this share of its distance.
NEARER = 0.85
# Places along a curve for one width of a band, and at most, where its other parts are looked for.
SAMPLES_PER_WIDTH, MAX_SAMPLES = 8.0, 20_000.0


@dataclass(frozen=True, eq=False)
class Sides:
    """A curve in the picture: its points' rows in order (n,), its line in pixels (m, 2) with unit normals (m, 2).

    The line is that of :func:`smooth_branch`. The signs (n,) say on which side of the curve, as its normals go, a
    point's ``side`` lies; 0 where it is not known.
    """

    rows: NDArray[np.intp]
    curve: Array
    normals: Array
    signs: Array
    scale: Array

    def slice_line(self, first: int, last: int) -> slice:
        """Return the part of the line from the point ``first`` to the one before ``last``."""
        return slice(PIECES * first, PIECES * (last - 1) + 1)


def find_sides(axes: Axes, step: Step, x: str, y: str) -> Sides | None:
    """Return the sides of a curve in the plane of ``x`` and ``y``; None of a step that has none there.

    Call it when the limits of the axes are set: directions are those of the picture, not of the parameters.
    """
    free = list_free_parameters(step)
    if "side" not in step.points or {x, y} != set(free) or len(step) < 2:
        return None
    rows = step.order
    limits = np.array([axes.get_xlim(), axes.get_ylim()])
    scale = np.array([axes.bbox.width, axes.bbox.height]) / (limits[:, 1] - limits[:, 0])
    curve = smooth_branch(step, *read_columns_with_slopes(step, x, y)).T * scale
    normals = _find_normals(curve)
    side = step.points["side"][rows][:, [free.index(x), free.index(y)]] * scale
    return Sides(rows, curve, normals, np.sign(np.nan_to_num(np.sum(normals[::PIECES] * side, axis=1))), scale)


def draw_side_band(axes: Axes, step: Step, x: str, y: str, shown: NDArray[np.bool_] | None = None) -> bool:
    """Draw the band on the side that each point's ``side`` points to, and return whether there was any to draw.

    ``shown`` says which rows have a band, shape (n_points,); None: all whose side is known. Call it when the limits of
    the axes are set: directions and widths are those of the picture, not of the parameters.
    """
    sides = find_sides(axes, step, x, y)
    if sides is None:
        return False
    special = [bool(step.labels[i]) for i in sides.rows]
    signs = fill_signs(sides.signs if shown is None else np.where(shown[sides.rows], sides.signs, 0.0), special)
    ranges = find_ranges(signs)
    width = BAND_WIDTH * min(axes.bbox.width, axes.bbox.height)
    for first, last in ranges:
        along = sides.slice_line(first, last)
        edge, directions = sides.curve[along], signs[first] * sides.normals[along]
        for share in SHADES:
            outer = _offset_edge(edge, directions, share * width, sides.curve)
            outline = np.vstack([edge, outer[::-1]]) / sides.scale
            colour = read_curve_sort(step).colour
            axes.fill(*outline.T, color=colour, alpha=OPACITY, linewidth=0, zorder=0.5)
    return bool(ranges)


def fill_signs(signs: Array, special: Sequence[bool]) -> Array:
    """Return the signs (n,) of the sides, those that are not known (0) at special points taken from a neighbour."""
    filled = signs.copy()
    for k in np.flatnonzero((signs == 0.0) & np.array(special)):
        near = [j for j in (k - 1, k + 1) if 0 <= j < len(signs) and signs[j]]
        filled[k] = signs[near[0]] if near else 0.0
    return filled


def find_ranges(signs: Array) -> list[tuple[int, int]]:
    """Return (first, last + 1) of each range of at least two points with one known side."""
    cuts = np.flatnonzero(np.diff(signs)) + 1
    edges = [0, *(int(c) for c in cuts), len(signs)]
    return [(a, b) for a, b in pairwise(edges) if b - a > 1 and signs[a]]


def _find_normals(curve: Array) -> Array:
    """Return a unit normal at each point of a curve (n, 2), to the left of its direction, shape (n, 2)."""
    steps = _normalise(np.diff(curve, axis=0))
    tangents = _normalise(np.vstack([steps[:1], steps[:-1] + steps[1:], steps[-1:]]))
    return np.column_stack([-tangents[:, 1], tangents[:, 0]])


def _normalise(vectors: Array) -> Array:
    lengths = np.hypot(*vectors.T)
    return np.asarray(vectors / np.where(lengths > 0.0, lengths, 1.0)[:, None])


def _offset_edge(edge: Array, directions: Array, width: float, curve: Array) -> Array:
    """Return the points ``width`` away from ``edge`` (n, 2), or nearer where they would come close to another part."""
    from scipy.spatial import cKDTree

    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(curve, axis=0).T))])
    fine = np.linspace(0.0, along[-1], int(min(MAX_SAMPLES, SAMPLES_PER_WIDTH * along[-1] / width)) + 2)
    tree = cKDTree(np.column_stack([np.interp(fine, along, curve[:, k]) for k in (0, 1)]))
    shares = np.zeros(len(edge))
    for share in NARROWER:
        clear = tree.query(edge + share * width * directions)[0] > NEARER * share * width
        shares = np.where(clear & (shares == 0.0), share, shares)
    return np.asarray(edge + (width * shares)[:, None] * directions)
