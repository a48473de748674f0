"""A whole diagram: all branches of an exploration, and under them in grey where motions settled."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ResultsError
from pddecont.plot.axis_labels import format_axis_label
from pddecont.plot.branch_colours import assign_kind_colours
from pddecont.plot.columns import find_state, list_free_parameters, read_parameter
from pddecont.plot.heights import choose_state
from pddecont.plot.layouts import finish_figure, make_axes
from pddecont.plot.legend import make_line_handle, shorten_list
from pddecont.plot.region_labels import label_regions, number_long_names
from pddecont.plot.style import COLOURS
from pddecont.plot.view import Drawing, ViewRequest
from pddecont.plot.views.diagram import draw_diagram
from pddecont.plot.views.plane import draw_plane
from pddecont.results import Results, Step
from pddecont.tables import list_branches, name_settled

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

# Motions that lie on a branch, and those that lie on none.
ON_BRANCH, ON_NONE = "0.72", "0.25"
# Those of tori that were followed.
OF_TORUS = "tab:purple"
# Labels of special points up to which all are written; of more those beside which something is stable.
MAX_LABELS = 24
# Marks of motions in the plane, when the colours are used up.
PLANE_MARKERS = ("o", "s", "^", "v")
DOT, CROSS = 5.5, 5.0
# How far beyond those on branches motions are shown, as a multiple of how far these go.
FARTHER = 10.0
# The error of a motion, as a multiple of what a step of it was allowed.
ERRORS = 100.0
# A branch is zero that goes no farther from it than this part of what motions on it do.
ROUNDING = 1e-3
# Letters of the name of a motion that are written into its regions; longer ones are numbered.
LONGEST_NAME = 22


def draw_figure(steps: list[Step], request: ViewRequest) -> Figure:
    """Return the diagram."""
    *branches, exploration = steps
    free = list_free_parameters(exploration)
    if len(free) == 2 and not (request.x or request.y):
        return draw_two_parameters([step for step in branches if len(list_free_parameters(step)) == 2], exploration)
    branches = [step for step in branches if len(list_free_parameters(step)) == 1]
    x = request.x or free[0]
    y = request.y or (choose_state(branches) if branches else exploration.meta["states"][0])
    figure, axes = make_axes(8.4, 5.4)
    handles = draw_motions(axes, exploration, x, y) if y in exploration.meta["states"] else []
    if not branches:
        axes.set_xlabel(format_axis_label([exploration], x))
        axes.set_ylabel(format_axis_label([exploration], y))
        return finish_figure(figure, axes, handles=handles)
    of_motions = len(axes.lines)
    labels, of_branches = draw_diagram(axes, branches, x, y, assign_kind_colours(branches))
    motions, lines = (measure_reach(some) for some in (axes.lines[:of_motions], axes.lines[of_motions:]))
    if motions <= find_error(exploration) and lines <= ROUNDING * motions:
        # All that is shown is zero but for the errors of motions, which would fill the picture.
        axes.set_ylim(-1.0, 1.0)
    if len(labels) > MAX_LABELS:
        beside_stable = {key for step in branches for key in list_beside_stable(step, x)}
        labels = [label for label in labels if (label.text, label.x) in beside_stable]
    return finish_figure(figure, axes, labels, [*of_branches, *handles])


def measure_reach(lines: Iterable[Line2D]) -> float:
    """Return how far lines go from zero."""
    values = [np.abs(np.asarray(line.get_ydata(), dtype=np.float64)) for line in lines]
    return max((float(np.max(v[np.isfinite(v)], initial=0.0)) for v in values), default=0.0)


def find_error(exploration: Step) -> float:
    """Return how far from zero motions may have ended that ought to end there."""
    return ERRORS * float(json.loads(exploration.meta["settings"])["step"]["explore"]["atol"])


def list_beside_stable(step: Step, x: str) -> list[tuple[str, float]]:
    """Return the labels of points beside which a branch is stable, each with the point's parameter."""
    xs, stable = read_parameter(step, x), step.points["stable"][step.order] == 1
    found = []
    for k, row in enumerate(step.order):
        if step.labels[row] and stable[max(0, k - 1) : k + 2].any():
            found.append((step.labels[row], float(xs[row])))
    return found


def draw_two_parameters(curves: list[Step], exploration: Step) -> Figure:
    """Return the curves in two parameters, over what motions settle to at random places, with names in regions."""
    x, y = list_free_parameters(exploration)
    figure, axes = make_axes(8.4, 5.8)
    labels, of_curves = draw_plane(axes, curves, x, y) if curves else ([], [])
    found: dict[str, list[int]] = {}
    for i in range(len(exploration)):
        reason = exploration.reason(i)
        if reason.code in ("settled", "halted") and "motion" in reason.values:
            found.setdefault(name_settled(reason), []).append(i)
    xs, ys = read_parameter(exploration, x), read_parameter(exploration, y)
    handles = []
    ordered = dict(sorted(found.items(), key=lambda item: (-len(item[1]), item[0])))
    written = number_long_names(list(ordered), LONGEST_NAME)
    for k, (name, places) in enumerate(ordered.items()):
        style: dict[str, Any] = {"color": COLOURS[k % len(COLOURS)] if k < len(COLOURS) else ON_BRANCH}
        style |= {"marker": PLANE_MARKERS[k // len(COLOURS) % len(PLANE_MARKERS)], "ms": DOT, "mew": 0, "alpha": 0.55}
        axes.plot(xs[places], ys[places], ls="", zorder=0.5, **style)
        text = name if written[name] == name else f"{written[name]}: {name}"
        handles.append(make_line_handle(text, ls="", **style))
    rows = [i for of_motion in found.values() for i in of_motion]
    if rows:
        # Curves alone had their limits fixed before.
        for get, put, values in ((axes.get_xlim, axes.set_xlim, xs), (axes.get_ylim, axes.set_ylim, ys)):
            put(min(get()[0], values[rows].min()), max(get()[1], values[rows].max()))
    label_regions(axes, {written[name]: np.column_stack([xs[own], ys[own]]) for name, own in ordered.items()})
    axes.set_xlabel(format_axis_label([exploration], x))
    axes.set_ylabel(format_axis_label([exploration], y))
    return finish_figure(figure, axes, labels, [*of_curves, *shorten_list(handles)])


def draw_motions(axes: Axes, step: Step, x: str, state: str) -> list[Artist]:
    """Draw the lowest and the highest value of a state along motions that settled; return the legend's handles."""
    j, xs, handles = find_state(step, state), read_parameter(step, x), []
    codes = np.array([step.reason(i).code for i in range(len(step))])
    styles: dict[str, tuple[str, dict[str, Any]]] = {
        "explained": ("motions that settled", {"marker": "o", "ms": DOT, "color": ON_BRANCH, "mew": 0}),
        "on_torus": ("tori that were followed", {"marker": "|", "ms": CROSS, "color": OF_TORUS, "mew": 0.8}),
        "unexplained": ("motions on no branch", {"marker": "x", "ms": CROSS, "color": ON_NONE, "mew": 0.8}),
    }
    shown = find_shown(step, j)
    for code, (text, style) in styles.items():
        rows = np.flatnonzero((codes == code) & shown)
        text += f" ({n} farther away not shown)" if (n := np.count_nonzero((codes == code) & ~shown)) else ""
        for key in ("lowest", "highest"):
            axes.plot(xs[rows], step.points[key][rows, j], ls="", zorder=1, **style)
        if len(rows):
            handles.append(make_line_handle(text, ls="", **style))
    return handles


def find_shown(step: Step, state: int) -> NDArray[np.bool_]:
    """Return the rows of motions that have room beside those on branches, shape (n_points,).

    What goes away without bound would leave nothing of the diagram to be seen.
    """
    codes = np.array([step.reason(i).code for i in range(len(step))])
    lowest, highest = step.points["lowest"][:, state], step.points["highest"][:, state]
    on_branch = (codes == "explained") & np.isfinite(lowest) & np.isfinite(highest)
    away = np.array([step.reason(i).values.get("look") == "away" for i in range(len(step))], dtype=bool)
    if not on_branch.any():
        return ~away
    low, high = lowest[on_branch].min(), highest[on_branch].max()
    room = FARTHER * max(high - low, abs(low), abs(high))
    with np.errstate(invalid="ignore"):
        return np.asarray(~away & ~(lowest < low - room) & ~(highest > high + room))


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
