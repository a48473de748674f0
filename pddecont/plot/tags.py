"""Names beside marked points, placed so that they cover neither each other nor the curves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
FONT_SIZE = 8.5
DISTANCES = (5.0, 12.0, 20.0, 32.0, 46.0, 62.0)
ANGLES = np.deg2rad([45, 135, -45, -135, 90, -90, 0, 180])


@dataclass(frozen=True)
class Tag:
    """A text that belongs to a point, in the axes' own units."""

    text: str
    x: float
    y: float


def place_tags(axes: Any, tags: Sequence[Tag]) -> None:
    """Write every tag near its point; one that had to go further gets a thin line. Call it when all else is drawn."""
    if not tags:
        return
    axes.figure.draw_without_rendering()
    points = 72.0 / axes.figure.dpi
    tags = _merged([t for t in tags if np.isfinite([t.x, t.y]).all()], axes, points)
    places = np.array([axes.transData.transform((t.x, t.y)) for t in tags]).reshape(-1, 2) * points
    frame = axes.get_window_extent()
    room = np.array([frame.x0, frame.y0, frame.x1, frame.y1]) * points
    curves = _samples(axes, points)
    taken = [np.concatenate([p - 3.5, p + 3.5]) for p in places]
    for tag, place in zip(tags, places, strict=True):
        box, distance = _best(place, tag.text, taken, curves, room)
        taken.append(box)
        line = {"arrowstyle": "-", "color": "0.45", "lw": 0.6, "shrinkA": 0, "shrinkB": 3} if distance > DISTANCES[0] else None
        note = axes.annotate(tag.text, (tag.x, tag.y), xytext=tuple(box[:2] - place), textcoords="offset points", ha="left",
                             va="bottom", fontsize=FONT_SIZE, zorder=6, arrowprops=line)  # fmt: skip
        note.set_in_layout(False)


def _merged(tags: Sequence[Tag], axes: Any, points: float) -> list[Tag]:
    """Return the tags with those of one and the same place made one."""
    result: list[Tag] = []
    where: list[Array] = []
    for tag in tags:
        place = axes.transData.transform((tag.x, tag.y)) * points
        near = [k for k, p in enumerate(where) if np.max(np.abs(p - place)) < 1.0]
        if not near:
            result.append(tag)
            where.append(place)
        elif tag.text not in result[near[0]].text.split(", "):
            result[near[0]] = Tag(f"{result[near[0]].text}, {tag.text}", result[near[0]].x, result[near[0]].y)
    return result


def _best(place: Array, text: str, taken: Sequence[Array], curves: Array, room: Array) -> tuple[Array, float]:
    """Return the box (left, bottom, right, top) with least in its way, and its distance from the point; in points."""
    size = np.array([0.68 * FONT_SIZE * len(text) + 1.0, 1.15 * FONT_SIZE])
    boxes = np.array(taken)
    best: tuple[float, Array, float] | None = None
    for distance in DISTANCES:
        for angle in ANGLES:
            way = np.array([np.cos(angle), np.sin(angle)])
            corner = place + distance * way + np.where(way < -0.1, -size, np.where(way > 0.1, 0.0, -0.5 * size))
            box = np.concatenate([corner, corner + size])
            cost = 10.0 * _overlap(box, boxes) / np.prod(size) + 0.05 * distance
            cost += 0.5 * np.count_nonzero(np.all((curves > box[:2]) & (curves < box[2:]), axis=1))
            cost += 20.0 * bool(np.any(box[:2] < room[:2]) or np.any(box[2:] > room[2:]))
            if best is None or cost < best[0]:
                best = cost, box, distance
    assert best is not None
    return best[1], best[2]


def _overlap(box: Array, boxes: Array) -> float:
    shared = np.minimum(box[2:], boxes[:, 2:]) - np.maximum(box[:2], boxes[:, :2])
    return float(np.sum(np.prod(np.clip(shared, 0.0, None), axis=1)))


def _samples(axes: Any, points: float) -> Array:
    """Return places along all lines, a few points apart, shape (n, 2)."""
    result = [np.empty((0, 2))]
    for line in axes.lines:
        xy = np.ma.filled(np.ma.masked_invalid(line.get_xydata()), np.nan)
        if len(xy) < 2 or line.get_transform() != axes.transData:
            continue
        places = line.get_transform().transform(xy) * points
        if line.get_linestyle() == "None":
            result.append(places)
            continue
        steps = np.nan_to_num(np.hypot(*np.diff(places, axis=0).T))
        along = np.concatenate([[0.0], np.cumsum(steps)])
        fine = np.linspace(0.0, along[-1], max(2, min(2000, int(along[-1] / 3.0))))
        result.append(np.column_stack([np.interp(fine, along, places[:, k]) for k in (0, 1)]))
    everything = np.vstack(result)
    return everything[np.isfinite(everything).all(axis=1)]
