"""Special points of branches and curves: which they are, of what kind, and their marks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pddecont.plot.point_labels import PointLabel
from pddecont.plot.style import find_curve_colour, find_marker
from pddecont.results import Step
from pddecont.tables import holds_equilibria

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
# Of more steps labels stay short, and repeat.
MOST_NAMED = 4
# Points of two steps whose places differ by less than this part of the largest are one.
SAME_PLACE = 1e-6
# The kind of an end point of a branch, which is labelled and recorded as special points are but is not marked.
END = "EP"


def read_kind(step: Step, row: int) -> str:
    """Return the recorded kind of a point; empty for an ordinary one."""
    return step.points["kind"][row].decode() if "kind" in step.points else ""


@dataclass(frozen=True)
class CurveSort:
    """What a curve in two parameters follows: special points of a kind (empty if it is not said), of what."""

    kind: str
    of_equilibria: bool = False

    @property
    def colour(self) -> str:
        """The colour of such curves."""
        return find_curve_colour(self.kind, self.of_equilibria)


def read_curve_sort(step: Step) -> CurveSort:
    """Return what a curve in two parameters follows."""
    return CurveSort(step.meta.get("curve") or "", holds_equilibria(step))


def find_special_rows(step: Step) -> list[int]:
    """Return the rows of special points in order along the branch, without end points."""
    return [int(i) for i in step.order if read_kind(step, int(i)) not in ("", END)]


def mark_special_points(axes: Axes, step: Step, xs: Array, heights: Array) -> list[PointLabel]:
    """Mark the special points of a branch or curve on lines ``heights`` (n_lines, n_points), and return their labels.

    The labels go to the first line. Points on no branch are marks by themselves.
    """
    rows = find_special_rows(step)
    for i in rows if step.format.has_branch else ():
        marker = find_marker(read_kind(step, i))
        axes.plot(np.full(len(heights), xs[i]), heights[:, i], marker=marker, ls="", color="black", ms=5, zorder=5)
    return [PointLabel(step.labels[i], float(xs[i]), float(heights[0, i])) for i in rows]


def name_apart(labels: Mapping[str, Sequence[PointLabel]]) -> list[PointLabel]:
    """Return the labels of some steps, by the steps' names, in which no text stands for two points.

    Of a few steps those that have a text in common with another, at another place, have their step's name before it.
    """
    together = [(name, label) for name, own in labels.items() for label in own]
    if len(labels) > MOST_NAMED or not together:
        return [label for _, label in together]
    places = np.array([(label.x, label.y) for _, label in together])
    size = np.maximum(np.ptp(places, axis=0), np.max(np.abs(places), axis=0))
    apart = np.any(np.abs(places[:, None] - places[None]) > SAME_PLACE * size, axis=2)

    def has_double(k: int) -> bool:
        name, label = together[k]
        return any(apart[k, i] and label.text == o.text and name != other for i, (other, o) in enumerate(together))

    return [
        replace(label, text=f"{name}: {label.text}") if has_double(k) else label
        for k, (name, label) in enumerate(together)
    ]
