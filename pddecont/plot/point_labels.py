"""Labels beside marked points, placed so that they cover neither each other nor the curves.

Of places at growing distances all around a point the one with least in its way is taken, one label after the other. On
the pictures of all shipped runs this leaves no label on another, on a mark, on a curve or outside the axes; adjustText,
which pushes labels apart until nothing moves, leaves some on curves, takes twice as long and needs pyplot.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pddecont.plot.style import LABEL_SHARE, scale_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
POINTS_PER_INCH = 72.0
# Distances are in points.
# Of a letter as wide as the widest in labels, and of a line, as multiples of the font's size.
LETTER_WIDTH, LINE_HEIGHT = 0.68, 1.15
# Half the width of a mark, with a little room.
HALF_MARK = 3.5
# Points nearer to each other than this share a label.
SAME_PLACE = 1.0
DISTANCES = (5.0, 12.0, 20.0, 32.0, 46.0, 62.0)
DIRECTIONS = np.deg2rad([45, 135, -45, -135, 90, -90, 0, 180])
# Apart along a curve where it is looked whether a label covers it; at most so many places a curve.
SAMPLE_GAP, MAX_SAMPLES = 3.0, 2000
# What is bad about a place: to lie outside the axes, to be covered wholly, to lie over one sample of a curve, to be one
# point away. So labels leave the axes last, and go a little further to keep clear of curves.
OUTSIDE_COST, COVERED_COST, CURVE_COST, DISTANCE_COST = 20.0, 10.0, 0.5, 0.05
# The share of a label that others may cover; one that has no such place is left out and counted.
MAX_COVERED = 0.1


@dataclass(frozen=True)
class PointLabel:
    """A text that belongs to a point, which is given in the axes' own units."""

    text: str
    x: float
    y: float


def place_labels(axes: Axes, labels: Sequence[PointLabel]) -> None:
    """Write labels near their points; one that had to go further gets a thin line. Call it when all else is drawn.

    Where so many points lie together that a label would cover others, it is left out; how many are is said above.
    """
    if not labels:
        return
    figure = axes.get_figure(root=True)
    assert figure is not None
    figure.draw_without_rendering()
    finite = [label for label in labels if np.isfinite([label.x, label.y]).all()]
    scale = _points_per_pixel(axes)
    merged = _merge_labels(finite, _find_places(axes, finite) * scale)
    places = _find_places(axes, merged) * scale
    frame = np.array(axes.get_window_extent().extents) * scale
    curves = sample_curves(axes)
    taken = [np.concatenate([place - HALF_MARK, place + HALF_MARK]) for place in places]
    taken += [np.array(text.get_window_extent().extents) * scale for text in axes.texts]
    n_left_out = 0
    for label, place in zip(merged, places, strict=True):
        box, distance = _choose_box(place, label.text, np.array(taken), curves, frame)
        if _measure_overlap(box, np.array(taken[len(places) :]).reshape(-1, 4)) > MAX_COVERED * np.prod(
            box[2:] - box[:2]
        ):
            n_left_out += len(label.text.split(", "))
            continue
        taken.append(box)
        line = {"arrowstyle": "-", "color": "0.45", "lw": 0.6, "shrinkA": 0, "shrinkB": 3}
        note = axes.annotate(
            label.text,
            (label.x, label.y),
            xytext=(box[0] - place[0], box[1] - place[1]),
            textcoords="offset points",
            ha="left",
            va="bottom",
            fontsize=scale_text(LABEL_SHARE),
            zorder=6,
            arrowprops=line if distance > DISTANCES[0] else None,
        )
        note.set_in_layout(False)
    if n_left_out:
        words = f"{n_left_out} label{'s' if n_left_out > 1 else ''} left out: no room"
        axes.set_title(words, loc="right", fontsize=scale_text(LABEL_SHARE), color="0.45")


def sample_curves(axes: Axes) -> Array:
    """Return places along all lines and marks of the axes in points, shape (n, 2), a few points apart."""
    result = [np.empty((0, 2))]
    for line in axes.lines:
        xy = np.ma.filled(np.ma.masked_invalid(line.get_xydata()), np.nan)
        if len(xy) < 2 or line.get_transform() != axes.transData:
            continue
        places = line.get_transform().transform(xy) * _points_per_pixel(axes)
        if line.get_linestyle() == "None":
            result.append(places)
            continue
        steps = np.nan_to_num(np.hypot(*np.diff(places, axis=0).T))
        along = np.concatenate([[0.0], np.cumsum(steps)])
        fine = np.linspace(0.0, along[-1], max(2, min(MAX_SAMPLES, int(along[-1] / SAMPLE_GAP))))
        result.append(np.column_stack([np.interp(fine, along, places[:, k]) for k in (0, 1)]))
    everything = np.vstack(result)
    return everything[np.isfinite(everything).all(axis=1)]


def _points_per_pixel(axes: Axes) -> float:
    return POINTS_PER_INCH / axes.figure.dpi


def _find_places(axes: Axes, labels: Sequence[PointLabel]) -> Array:
    """Return where the points of labels lie in pixels, shape (n, 2)."""
    return np.array([axes.transData.transform((label.x, label.y)) for label in labels]).reshape(-1, 2)


def _merge_labels(labels: Sequence[PointLabel], places: Array) -> list[PointLabel]:
    """Return the labels, those of one and the same place made one; ``places`` are in points, shape (n, 2)."""
    merged: list[PointLabel] = []
    first: list[Array] = []
    for label, place in zip(labels, places, strict=True):
        near = next((k for k, other in enumerate(first) if np.max(np.abs(other - place)) < SAME_PLACE), None)
        if near is None:
            merged.append(label)
            first.append(place)
        elif label.text not in merged[near].text.split(", "):
            merged[near] = PointLabel(f"{merged[near].text}, {label.text}", merged[near].x, merged[near].y)
    return merged


def _choose_box(place: Array, text: str, taken: Array, curves: Array, frame: Array) -> tuple[Array, float]:
    """Return the box (left, bottom, right, top) with least in its way, and its distance from the point.

    ``taken`` (n, 4) holds marks and labels that stand already, ``curves`` (m, 2) samples, ``frame`` (4,) the axes.
    """
    size = scale_text(LABEL_SHARE) * np.array([LETTER_WIDTH * len(text), LINE_HEIGHT]) + np.array([1.0, 0.0])
    best: tuple[float, Array, float] | None = None
    for distance in DISTANCES:
        for angle in DIRECTIONS:
            way = np.array([np.cos(angle), np.sin(angle)])
            corner = place + distance * way + np.where(way < -0.1, -size, np.where(way > 0.1, 0.0, -0.5 * size))
            box = np.concatenate([corner, corner + size])
            cost = COVERED_COST * _measure_overlap(box, taken) / np.prod(size) + DISTANCE_COST * distance
            cost += CURVE_COST * np.count_nonzero(np.all((curves > box[:2]) & (curves < box[2:]), axis=1))
            cost += OUTSIDE_COST * bool(np.any(box[:2] < frame[:2]) or np.any(box[2:] > frame[2:]))
            if best is None or cost < best[0]:
                best = float(cost), box, distance
    assert best is not None
    return best[1], best[2]


def _measure_overlap(box: Array, boxes: Array) -> float:
    """Return the area that a box (4,) shares with ``boxes`` (n, 4), summed."""
    shared = np.minimum(box[2:], boxes[:, 2:]) - np.maximum(box[:2], boxes[:, :2])
    return float(np.sum(np.prod(np.clip(shared, 0.0, None), axis=1)))
