"""Bifurcation diagrams: any column of points against any other."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ResultsError, suggest
from pddecont.plot.style import COLOURS, MARKERS, label
from pddecont.results.reader import Step

Array = NDArray[np.float64]


def column(step: Step, name: str) -> Array:
    """Return a parameter, a monitor or another number of each point, by name."""
    for group in ("parameters", "monitors"):
        if name in step.meta[group]:
            return step.points[group][:, step.meta[group].index(name)]
    if name in step.points and step.points[name].ndim == 1 and step.points[name].dtype.kind == "f":
        return step.points[name]
    known = columns(step)
    raise ResultsError(f"step '{step.name}' has no column '{name}'{suggest(name, known)} (columns: {', '.join(known)})")


def columns(step: Step) -> list[str]:
    """Return the names that :func:`column` knows."""
    plain = [n for n in ("period", "error_estimate", "clearance", "arclength") if n in step.points]
    return [*step.meta["parameters"], *step.meta["monitors"], *plain]


def default_columns(step: Step) -> tuple[str, str]:
    """Return what a diagram shows when nobody says: the free parameter and the first monitor, else the period."""
    free = step.meta.get("free") or step.meta["parameters"][:1] or ["period"]
    others = [m for m in step.meta["monitors"] if np.any(np.isfinite(column(step, m)))]
    return free[0], others[0] if others else "period"


def draw_diagram(axes: Any, step: Step, x: str, y: str, colour: str = COLOURS[0]) -> None:
    """Draw a branch with its special points; parts that are not admissible are dotted."""
    order = step.order
    xs, ys = column(step, x)[order], column(step, y)[order]
    good = step.points["admissible"][order] != 0
    # A line between two points is drawn solid where either end is admissible: only one of them may be the grazing itself.
    for solid, style in ((True, "-"), (False, ":")):
        piece = np.ma.masked_array(ys, mask=~good if solid else good & np.roll(good, 1) & np.roll(good, -1))
        axes.plot(xs, piece, style, color=colour, lw=1.6 if solid else 1.0, marker="." if len(xs) < 3 else None)
    offset = 1
    for i, (px, py) in zip(order, zip(xs, ys, strict=True), strict=True):
        name = step.labels[i]
        if not name or name.startswith("EP"):
            continue
        axes.plot([px], [py], MARKERS[name[:2]], color="black", ms=5, zorder=5)
        axes.annotate(name, (px, py), textcoords="offset points", xytext=(5, 6 * offset), fontsize=8.5)
        offset = -offset if offset > 0 else 1
    axes.set_xlabel(label(x))
    axes.set_ylabel(label(y))
