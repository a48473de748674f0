"""Numbers beside curves of special equilibria in two parameters: how many roots are unstable on either side.

A Hopf point has n unstable roots besides the pair on the axis: so many has the equilibrium on the side that is recorded
along the curve, and n + 2 on the other. Beside a fold there are two equilibria, with n and n + 1, on the side that is
recorded, and none on the other.
"""

from __future__ import annotations

from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pddecont.plot.point_labels import POINTS_PER_INCH, sample_curves
from pddecont.plot.side_bands import Sides, find_sides
from pddecont.plot.special_points import CurveSort, read_curve_sort
from pddecont.results import Step

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
# Sizes and distances are in points: of a number, and between its middle and the curve.
FONT_SIZE, GAP, COLOUR = 8.0, 8.5, "0.2"
# What is nearer to the middle of a number, a curve or another number, covers it.
ROOM = 6.5
# Of numbers that are the same one.
SAME_PLACE = 1.0
# From the curve to the side that is recorded, and to the other.
WAYS = (1.0, -1.0)
# Places tried along each stretch of a curve with one number.
N_PLACES = 41
# What a place half a stretch away from its middle may be better by, in points of distance from all curves.
OFF_MIDDLE = 4.0


def write_side_counts(axes: Axes, step: Step, x: str, y: str) -> int:
    """Write the numbers of unstable roots on both sides of a curve, once a stretch, and return how many there are.

    Call it when the limits of the axes are set and all curves drawn.
    """
    sort, sides = read_curve_sort(step), find_sides(axes, step, x, y)
    if not sort.of_equilibria or sides is None:
        return 0
    numbers, counts = 0, step.points["n_unstable"][sides.rows]
    known = np.where([step.labels[i] == "" for i in sides.rows], np.where(sides.signs != 0.0, counts, -1), -2)
    for (n, _), group in groupby(range(len(known)), key=lambda k: (known[k], sides.signs[k])):
        stretch = list(group)
        texts = name_counts(sort, int(n))
        if n < 0 or not texts or len(stretch) < 2:
            continue
        line, ways = _offset_stretch(axes, sides, stretch)
        if all(_stands(axes, text, line + way * ways, sides.scale) for text, way in zip(texts, WAYS, strict=False)):
            continue
        best = _choose_place(axes, line, ways, sides.scale)
        for text, way in zip(texts, WAYS, strict=False) if best is not None else ():
            _write(axes, text, line[best] + way * ways[best], sides.scale)
            numbers += 1
    return numbers


def name_counts(sort: CurveSort, n: int) -> tuple[str, ...]:
    """Return what is written on the side that is recorded, and on the other, beside ``n`` other unstable roots."""
    return {"HB": (f"{n}", f"{n + 2}"), "LP": (f"{n}, {n + 1}",)}.get(sort.kind, ())


def _offset_stretch(axes: Axes, sides: Sides, stretch: list[int]) -> tuple[Array, Array]:
    """Return places along a stretch in pixels, and from each the way to the middle of a number on its recorded side."""
    unit = axes.figure.dpi / POINTS_PER_INCH
    shown = sides.slice_line(stretch[0], stretch[-1] + 1)
    curve = sides.curve[shown]
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(curve, axis=0).T))])
    values = np.column_stack([curve, sides.signs[stretch[0]] * sides.normals[shown]])
    places = np.linspace(0.0, along[-1], N_PLACES)[1:-1]
    fine = np.column_stack([np.interp(places, along, column) for column in values.T])
    return fine[:, :2], GAP * unit * fine[:, 2:]


def _stands(axes: Axes, text: str, places: Array, scale: Array) -> bool:
    """Whether a text is at one of ``places`` in pixels already: curves of symmetric equilibria are one line."""
    same = [np.array(note.get_position()) * scale for note in axes.texts if note.get_text() == text]
    near = SAME_PLACE * axes.figure.dpi / POINTS_PER_INCH + np.max(np.hypot(*np.diff(places, axis=0).T))
    return any(np.min(np.hypot(*(places - place).T)) < near for place in same)


def _choose_place(axes: Axes, line: Array, ways: Array, scale: Array) -> int | None:
    """Return the number of a place, far from all other curves and in the axes; None where there is no room."""
    unit = axes.figure.dpi / POINTS_PER_INCH
    others = _find_obstacles(axes) * unit - np.array([axes.bbox.x0, axes.bbox.y0])
    corner = np.array([axes.get_xlim()[0], axes.get_ylim()[0]]) * scale
    worth = np.full(len(line), np.inf)
    for ends in (line + ways - corner, line - ways - corner):
        gaps = np.hypot(*(ends[:, None] - others[None]).transpose(2, 0, 1)).min(axis=1, initial=np.inf)
        inside = np.all((ends > 0.0) & (ends < [axes.bbox.width, axes.bbox.height]), axis=1)
        worth = np.minimum(worth, np.where(inside, np.minimum(gaps, GAP * unit), -np.inf))
    off_middle = np.abs(np.linspace(-1.0, 1.0, N_PLACES)[1:-1])
    best = int(np.argmax(worth - OFF_MIDDLE * unit * off_middle))
    return best if worth[best] > ROOM * unit else None


def _find_obstacles(axes: Axes) -> Array:
    """Return places in points that numbers keep away from: of curves, and of numbers that stand there already."""
    texts = [axes.transData.transform(text.get_position()) for text in axes.texts]
    scale = POINTS_PER_INCH / axes.figure.dpi
    return np.vstack([sample_curves(axes), np.array(texts).reshape(-1, 2) * scale])


def _write(axes: Axes, text: str, place: Array, scale: Array) -> None:
    x, y = (place / scale).tolist()
    note = axes.text(x, y, text, fontsize=FONT_SIZE, color=COLOUR, ha="center", va="center", zorder=4)
    note.set_in_layout(False)
    note.set_clip_on(True)
