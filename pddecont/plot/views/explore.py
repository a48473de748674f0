"""A whole diagram: all branches of an exploration, and under them in grey where motions settled."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pddecont.errors import ResultsError
from pddecont.plot.columns import find_state, list_free_parameters, read_parameter
from pddecont.plot.heights import choose_state
from pddecont.plot.layouts import finish_figure, make_axes
from pddecont.plot.legend import make_line_handle
from pddecont.plot.view import Drawing, ViewRequest
from pddecont.plot.views.diagram import draw_diagram
from pddecont.results import Results, Step
from pddecont.tables import list_branches

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Motions that lie on a branch, and those that lie on none.
ON_BRANCH, ON_NONE = "0.72", "0.25"
DOT, CROSS = 5.5, 5.0


def draw_figure(steps: list[Step], request: ViewRequest) -> Figure:
    """Return the diagram."""
    *branches, exploration = steps
    x = request.x or list_free_parameters(exploration)[0]
    y = request.y or choose_state(branches or [exploration])
    figure, axes = make_axes(8.4, 5.4)
    handles = draw_motions(axes, exploration, x, y) if y in exploration.meta["states"] else []
    if not branches:
        return finish_figure(figure, axes, handles=handles)
    labels, of_branches = draw_diagram(axes, branches, x, y)
    return finish_figure(figure, axes, labels, [*of_branches, *handles])


def draw_motions(axes: Axes, step: Step, x: str, state: str) -> list[Artist]:
    """Draw the lowest and the highest value of a state along motions that settled; return the legend's handles."""
    j, xs, handles = find_state(step, state), read_parameter(step, x), []
    codes = np.array([step.reason(i).code for i in range(len(step))])
    styles: dict[str, tuple[str, dict[str, Any]]] = {
        "explained": ("motions that settled", {"marker": "o", "ms": DOT, "color": ON_BRANCH, "mew": 0}),
        "unexplained": ("motions on no branch", {"marker": "x", "ms": CROSS, "color": ON_NONE, "mew": 0.8}),
    }
    for code, (text, style) in styles.items():
        rows = np.flatnonzero(codes == code)
        for key in ("lowest", "highest"):
            axes.plot(xs[rows], step.points[key][rows, j], ls="", zorder=1, **style)
        if len(rows):
            handles.append(make_line_handle(text, ls="", **style))
    return handles


def choose_steps(steps: list[Step], results: Results, request: ViewRequest) -> list[Step]:
    """Return the last exploration, after its branches."""
    return pick_steps(steps, results)


def pick_steps(steps: list[Step], results: Results) -> list[Step]:
    """Return the last exploration among ``steps``, after its branches that the file holds."""
    explorations = [step for step in steps if step.kind == "explore"]
    if not explorations:
        raise ResultsError("the view 'explore' needs an explore step")
    names = [row["branch"] for row in list_branches(explorations[-1])]
    return [*(results.steps[name] for name in names if name in results.steps), explorations[-1]]


DRAWING = Drawing(draw_figure, choose_steps=choose_steps, pick_steps=pick_steps)
