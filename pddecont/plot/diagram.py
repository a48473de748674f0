"""Bifurcation diagrams: any column of points against any other, one or several branches."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pddecont.plot.columns import column
from pddecont.plot.limits import size_of, widen
from pddecont.plot.stretches import colouring, stretches, style_handles
from pddecont.plot.style import marker
from pddecont.plot.tags import Tag
from pddecont.plot.units import axis_label
from pddecont.results.reader import Step


def draw_diagram(axes: Any, steps: Sequence[Step], x: str, y: str) -> tuple[list[Tag], list[Any]]:
    """Draw branches: unstable parts dashed, those that are not admissible dotted, each signature in its colour.

    Returns the names of special points, which go in last, and the handles of the legend.
    """
    colours, handles = colouring(steps)
    tags: list[Tag] = []
    for step in steps:
        xs, ys = column(step, x), column(step, y)
        for s in stretches(step):
            axes.plot(xs[s.rows], ys[s.rows], s.style, color=colours[step.name, s.family], lw=1.0 if s.style == ":" else 1.6,
                      marker="." if len(xs) < 3 else None)  # fmt: skip
        tags += mark_special(axes, step, x, y)
    for which, name in (("x", x), ("y", y)):
        widen(axes, which, size_of(steps, np.concatenate([column(step, name) for step in steps])))
    axes.set_xlabel(axis_label(steps, x))
    axes.set_ylabel(axis_label(steps, y))
    return tags, [*handles, *style_handles(steps)]


def mark_special(axes: Any, step: Step, x: str, y: str) -> list[Tag]:
    """Mark the special points of a branch or curve and return their names."""
    xs, ys = column(step, x), column(step, y)
    rows = special_rows(step)
    for i in rows:
        axes.plot([xs[i]], [ys[i]], marker=marker(step.labels[i][:2]), ls="", color="black", ms=5, zorder=5)
    return [Tag(step.labels[i], float(xs[i]), float(ys[i])) for i in rows]


def special_rows(step: Step) -> list[int]:
    """Return the rows of special points in order along the branch, without end points."""
    return [int(i) for i in step.order if step.labels[i] and not step.labels[i].startswith("EP")]
