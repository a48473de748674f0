"""Special points of branches and curves: which they are, of what kind, and their marks."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pddecont.plot.columns import read_column
from pddecont.plot.point_labels import PointLabel
from pddecont.plot.style import find_marker
from pddecont.results import Step

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# The kind of an end point of a branch, which is labelled and recorded as special points are but is not marked.
END = "EP"


def read_kind(step: Step, row: int) -> str:
    """Return the recorded kind of a point; empty for an ordinary one."""
    return step.points["kind"][row].decode() if "kind" in step.points else ""


def read_curve_kind(step: Step) -> str:
    """Return the kind of special point that a curve in two parameters follows; empty if it is not said."""
    return step.meta.get("curve") or ""


def find_special_rows(step: Step) -> list[int]:
    """Return the rows of special points in order along the branch, without end points."""
    return [int(i) for i in step.order if read_kind(step, int(i)) not in ("", END)]


def mark_special_points(axes: Axes, step: Step, x: str, y: str) -> list[PointLabel]:
    """Mark the special points of a branch or curve and return their labels."""
    xs, ys = read_column(step, x), read_column(step, y)
    rows = find_special_rows(step)
    for i in rows:
        axes.plot([xs[i]], [ys[i]], marker=find_marker(read_kind(step, i)), ls="", color="black", ms=5, zorder=5)
    return [PointLabel(step.labels[i], float(xs[i]), float(ys[i])) for i in rows]
