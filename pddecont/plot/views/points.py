"""The points of any step: one column of their table over another, for kinds of steps without views of their own."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ResultsError, suggest
from pddecont.plot.layouts import finish_figure, make_axes
from pddecont.plot.point_labels import PointLabel
from pddecont.plot.style import COLOURS
from pddecont.plot.view import Drawing, ViewRequest
from pddecont.results import Step
from pddecont.tables import make_arrays

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def can_show(step: Step) -> bool:
    """Return whether a step's points have a number that can be drawn."""
    return bool(list_number_columns(step))


def list_number_columns(step: Step) -> dict[str, NDArray[Any]]:
    """Return the columns of a step's points that hold numbers, those first that differ from point to point."""
    columns = {name: values for name, values in make_arrays(step).items() if values.dtype.kind in "fiu"}
    index = {name: values for name, values in columns.items() if name == "index"}
    others = {name: values for name, values in columns.items() if name != "index"}
    return dict(sorted(others.items(), key=lambda item: len(np.unique(item[1])) == 1)) | index


def draw_figure(steps: list[Step], request: ViewRequest) -> Figure:
    """Return the figure of one column over another; without names the first two that vary."""
    step = steps[-1]
    columns = list_number_columns(step)
    names = list(columns)
    for name in (request.x, request.y):
        if name is not None and name not in columns:
            known = f"{suggest(name, names)} (columns: {', '.join(names)})"
            raise ResultsError(f"step '{step.name}' has no column '{name}'{known}")
    y = request.y or next((name for name in names[1:] if name != request.x), names[0])
    x = request.x or next((name for name in names if name != y), y)
    figure, axes = make_axes(6.4, 4.4)
    axes.plot(columns[x], columns[y], marker="o", ms=3, lw=0.9, color=COLOURS[0])
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    labels = [step.labels[i] for i in step.order]
    points = zip(labels, columns[x], columns[y], strict=True)
    return finish_figure(figure, axes, [PointLabel(label, float(a), float(b)) for label, a, b in points if label])


DRAWING = Drawing(draw_figure, can_show=can_show)
