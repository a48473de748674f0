"""Curves of special points in the plane of two parameters, with the side where the orbit lives on."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pddecont.plot.columns import column, free_of
from pddecont.plot.diagram import mark_special, special_rows
from pddecont.plot.stretches import family, stretches, style_handles
from pddecont.plot.style import KIND_COLOURS, marker
from pddecont.plot.tags import Tag
from pddecont.plot.units import axis_label
from pddecont.results.reader import Step
from pddecont.results.summary import WORDS, short_signature, signature
from pddecont.results.tables import note

Array = NDArray[np.float64]
BAND = 0.055
SHADES = (1.0, 0.66, 0.33)
WIDTHS = np.linspace(1.0, 0.05, 20)
OTHER = "0.45"
# What the shaded side of a curve keeps.
SIDES = {"GR": "signature kept", "VS": "signature kept", "LP": "orbits exist", "PD": "stable", "TR": "stable"}


def draw_plane(axes: Any, steps: Sequence[Step], x: str, y: str) -> tuple[list[Tag], list[Any]]:
    """Draw curves in two parameters, one colour a kind; a soft band marks the side that each point's ``side`` names.

    Returns the names of points of codimension two, which go in last, and the handles of the legend.
    """
    tags: list[Tag] = []
    for step in steps:
        xs, ys = column(step, x), column(step, y)
        for s in stretches(step):
            axes.plot(xs[s.rows], ys[s.rows], s.style, color=curve_colour(step), lw=1.2 if s.style == ":" else 1.8,
                      marker="." if len(xs) < 3 else None)  # fmt: skip
        tags += mark_special(axes, step, x, y)
    axes.margins(0.07)
    axes.autoscale_view()
    axes.set_xlim(axes.get_xlim())
    axes.set_ylim(axes.get_ylim())
    shaded = [step for step in steps if _shade(axes, step, x, y)]
    axes.set_xlabel(axis_label(steps, x))
    axes.set_ylabel(axis_label(steps, y))
    return tags, [*curve_handles(steps), *style_handles(steps), *_point_handles(steps), *_side_handles(shaded)]


def kind_of(step: Step) -> str:
    """Return the kind of special point that a curve follows; empty if it is not said."""
    return step.meta.get("curve") or ""


def curve_colour(step: Step) -> str:
    """Return the colour of a curve's kind."""
    return KIND_COLOURS.get(kind_of(step), OTHER)


def curve_handles(steps: Sequence[Step]) -> list[Any]:
    """Return the legend's handles, one a kind of curve, in words."""
    from matplotlib.lines import Line2D

    return [Line2D([], [], color=KIND_COLOURS.get(kind, OTHER), lw=1.8, label=_words(kind, steps))
            for kind in dict.fromkeys(kind_of(step) for step in steps)]  # fmt: skip


def _words(kind: str, steps: Sequence[Step]) -> str:
    words = WORDS.get(kind, kind or "curve")
    if kind != "UF":
        return words
    names = dict.fromkeys(note(step, i) for step in steps if kind_of(step) == kind for i in range(len(step)))
    return f"{words} {', '.join(n for n in names if n)}".strip()


def _point_handles(steps: Sequence[Step]) -> list[Any]:
    from matplotlib.lines import Line2D

    kinds = sorted({step.labels[i][:2] for step in steps for i in special_rows(step)})
    return [Line2D([], [], color="black", ls="", marker=marker(kind), ms=5, label=f"{kind}: {WORDS.get(kind, kind)}") for kind in kinds]


def _side_handles(steps: Sequence[Step]) -> list[Any]:
    from matplotlib.patches import Patch

    if not steps:
        return []
    texts = {kind: _side_words(kind, [s for s in steps if kind_of(s) == kind]) for kind in dict.fromkeys(map(kind_of, steps))}
    said = [words if len(texts) == 1 else f"{words} ({WORDS.get(kind, 'curve')})" for kind, words in texts.items()]
    return [Patch(facecolor=KIND_COLOURS.get(kind, OTHER), alpha=0.25, linewidth=0, label=f"shaded side: {words}")
            for kind, words in zip(texts, said, strict=True)]  # fmt: skip


def _side_words(kind: str, steps: Sequence[Step]) -> str:
    words = SIDES.get(kind, "orbit kept")
    kin = {s.family for step in steps for s in stretches(step)}
    if words != "signature kept" or len(kin) > 1:
        return words
    rows = (i for i in range(len(steps[0])) if family(steps[0], i) in kin)
    name = short_signature(signature(steps[0], next(rows)))
    return f"signature {name} kept" if name else words


def _shade(axes: Any, step: Step, x: str, y: str) -> bool:
    """Lay a band along the curve on the side that ``side`` points to; return whether there was any to lay."""
    free = free_of(step)
    if "side" not in step.points or {x, y} != set(free) or len(step) < 2:
        return False
    rows = step.order
    # Directions and widths are those of the picture, not of the parameters.
    box = np.array([axes.get_xlim(), axes.get_ylim()])
    paper = np.array([axes.bbox.width, axes.bbox.height]) / (box[:, 1] - box[:, 0])
    places = np.column_stack([column(step, x), column(step, y)])[rows] * paper
    normals = _normals(places)
    side = step.points["side"][rows][:, [free.index(x), free.index(y)]] * paper
    towards = _filled(np.sign(np.nan_to_num(np.sum(normals * side, axis=1))), [bool(step.labels[i]) for i in rows])
    width = BAND * min(axes.bbox.width, axes.bbox.height)
    bands = list(_bands(towards))
    for first, last in bands:
        edge = places[first:last]
        for share in SHADES:
            far = _beside(edge, towards[first:last, None] * normals[first:last], share * width, places)
            axes.fill(*(np.vstack([edge, far[::-1]]) / paper).T, color=curve_colour(step), alpha=0.11, linewidth=0, zorder=0.5)
    return bool(bands)


def _normals(places: Array) -> Array:
    """Return a unit normal at each point of a curve, to the left of its direction, shape (n, 2)."""
    steps = np.diff(places, axis=0)
    lengths = np.hypot(*steps.T)
    steps /= np.where(lengths > 0.0, lengths, 1.0)[:, None]
    tangents = np.vstack([steps[:1], steps[:-1] + steps[1:], steps[-1:]])
    sizes = np.hypot(*tangents.T)
    tangents /= np.where(sizes > 0.0, sizes, 1.0)[:, None]
    return np.column_stack([-tangents[:, 1], tangents[:, 0]])


def _beside(edge: Array, directions: Array, width: float, curve: Array) -> Array:
    """Return the points ``width`` away from ``edge``, or less where another part of the curve is nearer to them."""
    steps = np.hypot(*np.diff(curve, axis=0).T)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    fine = np.linspace(0.0, along[-1], int(min(20000.0, 8.0 * along[-1] / width)) + 2)
    tree = cKDTree(np.column_stack([np.interp(fine, along, curve[:, k]) for k in (0, 1)]))
    shares = np.zeros(len(edge))
    for share in WIDTHS:
        free = tree.query(edge + share * width * directions)[0] > 0.85 * share * width
        shares = np.where(free & (shares == 0.0), share, shares)
    return edge + (width * shares)[:, None] * directions


def _filled(signs: Array, special: Sequence[bool]) -> Array:
    """Return the signs with those missing at special points taken from a neighbour."""
    result = signs.copy()
    for k in np.flatnonzero((signs == 0.0) & np.array(special)):
        near = [j for j in (k - 1, k + 1) if 0 <= j < len(signs) and signs[j]]
        result[k] = signs[near[0]] if near else 0.0
    return result


def _bands(towards: Array) -> list[tuple[int, int]]:
    """Return (first, last + 1) of each stretch of at least two points with one known side."""
    cuts = np.flatnonzero(np.diff(towards)) + 1
    edges = [0, *(int(c) for c in cuts), len(towards)]
    return [(a, b) for a, b in pairwise(edges) if b - a > 1 and towards[a]]
