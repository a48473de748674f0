"""In three dimensions: branches and curves over the plane of two parameters, or orbits along one of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pddecont.errors import ResultsError
from pddecont.plot.axis_labels import format_axis_label
from pddecont.plot.branch_colours import assign_branch_colours, make_style_handles
from pddecont.plot.branch_parts import split_branch
from pddecont.plot.columns import choose_plane, list_free_parameters, read_column, share_values
from pddecont.plot.heights import choose_height, read_heights
from pddecont.plot.layouts import finish_figure, make_figure
from pddecont.plot.limits import widen_for_columns
from pddecont.plot.point_labels import PointLabel
from pddecont.plot.special_points import find_special_rows, read_curve_sort, read_kind
from pddecont.plot.style import find_marker
from pddecont.plot.view import Drawing, ViewRequest
from pddecont.plot.views.plane import make_curve_handles
from pddecont.results import Results, Step
from pddecont.tables import holds_equilibria

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.figure import Figure

# Of branches: apart from the colours of the curves' kinds.
FAMILY_COLOURS = ("0.25", "#3aa0b5", "#c45f96", "#7d9b3c", "0.65")


def draw_figure(steps: list[Step], request: ViewRequest) -> Figure:
    """Return branches and curves over a plane or, where two signals are asked for, the orbits along a parameter."""
    figure = make_figure(7.4, 6.4)
    axes = figure.add_subplot(projection="3d")
    axes.set_box_aspect((4, 4, 3), zoom=0.98)
    if request.x and request.y and _are_signals(steps[-1], request):
        height = request.z or list_free_parameters(steps[-1])[0]
        lines = draw_orbits_along(axes, steps[-1], request.x, request.y, height)
        figure.colorbar(lines, ax=axes, label=format_axis_label(steps, height), shrink=0.6, pad=0.12)
        return figure
    x, y = choose_plane(steps, request.x, request.y)
    return finish_figure(figure, axes, *draw_manifold(axes, steps, x, y, request.z or choose_height(steps[::-1])))


def choose_steps(steps: list[Step], results: Results, request: ViewRequest) -> list[Step]:
    """Return the curves and branches in one plane or, where two signals are asked for, the last step."""
    if _are_signals(steps[-1], request):
        return steps[-1:]
    x, y = choose_plane(steps, request.x, request.y)
    found = find_within_plane(steps, x, y)
    if not found:
        raise ResultsError(f"{results.path} has no branch or curve in {x} and {y}")
    return found


def find_within_plane(steps: Sequence[Step], x: str, y: str) -> list[Step]:
    """Return the curves in the parameters ``x``, ``y`` and the branches in one of them that lie in the same plane.

    A branch lies in a plane if its other parameters have the values that they have on the first curve (or, without
    curves, on the last branch).
    """
    curves = [s for s in steps if set(list_free_parameters(s)) == {x, y}]
    branches = [s for s in steps if list_free_parameters(s) in ([x], [y])]
    if not curves and not branches:
        return []
    first = (curves or branches[-1:])[0]
    others = [name for name in first.meta["parameters"] if name not in (x, y)]
    return [step for step in (*curves, *branches) if share_values(step, first, others)]


def draw_manifold(axes: Any, steps: Sequence[Step], x: str, y: str, z: str) -> tuple[list[PointLabel], list[Artist]]:
    """Draw curves in two parameters as thick lines and branches as thin ones, in three dimensions.

    Returns the labels of special points, placed where these are seen, and the handles of the legend.
    """
    from mpl_toolkits.mplot3d.proj3d import proj_transform

    curves = [s for s in steps if len(list_free_parameters(s)) == 2]
    branches = [s for s in steps if len(list_free_parameters(s)) == 1]
    families = {part.family for branch in branches for part in split_branch(branch)}
    colours = assign_branch_colours(branches, FAMILY_COLOURS if len(families) > 1 else FAMILY_COLOURS[:1])
    special: list[tuple[str, list[float]]] = []
    for step in steps:
        is_curve = step in curves
        (xs, ys), heights = [read_column(step, name) for name in (x, y)], read_heights(step, z)
        for part in split_branch(step):
            colour = read_curve_sort(step).colour if is_curve else colours.of_parts[step.name, part.family]
            for zs in heights:
                axes.plot(
                    *(values[part.rows] for values in (xs, ys, zs)),
                    ls=part.style,
                    lw=2.8 if is_curve else 1.0,
                    color=colour,
                )
        for i in find_special_rows(step):
            marker = find_marker(read_kind(step, i))
            for zs in heights:
                axes.plot(*([v[i]] for v in (xs, ys, zs)), marker=marker, ls="", color="black", ms=4)
            special.append((step.labels[i], [float(v[i]) for v in (xs, ys, heights[0])]))
    widen_for_columns(axes, steps, {"z": [read_heights(step, z) for step in steps]})
    for name, set_label in ((x, axes.set_xlabel), (y, axes.set_ylabel), (z, axes.set_zlabel)):
        set_label(format_axis_label(steps, name))
    seen = [(name, proj_transform(*place, axes.get_proj())) for name, place in special]
    labels = [PointLabel(name, float(place[0]), float(place[1])) for name, place in seen]
    named = colours.make_handles() if len(families) > 1 else []
    return labels, [*make_curve_handles(curves), *named, *make_style_handles(steps)]


def draw_orbits_along(axes: Any, step: Step, x: str, y: str, z: str) -> Any:
    """Draw each point's orbit in two signals, at the height of a parameter: the solution manifold.

    Returns the coloured lines.
    """
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    heights = read_column(step, z)[step.order]
    columns = [list_signals(step).index(name) for name in (x, y)]
    lines = []
    for i, height in zip(step.order, heights, strict=True):
        orbit = step.orbit(int(i))
        signals = np.hstack([orbit["states"], orbit["delayed"]]) if "delayed" in orbit else orbit["states"]
        closed = signals[np.append(np.arange(len(signals)), 0)][:, columns]
        lines.append(np.column_stack([closed, np.full(len(closed), height)]))
    collection = Line3DCollection(lines, array=heights, cmap="viridis", linewidths=0.9)
    axes.add_collection3d(collection)
    every = np.vstack(lines)
    for k, (which, name) in enumerate((("x", x), ("y", y), ("z", z))):
        getattr(axes, f"set_{which}label")(format_axis_label(step, name))
        getattr(axes, f"set_{which}lim")(every[:, k].min(), every[:, k].max())
    return collection


def list_signals(step: Step) -> list[str]:
    """Return what orbits are drawn in: the states, and their delayed values as the model writes them."""
    return [*step.meta["states"], *step.meta.get("delayed", [])]


def spans_plane(step: Step) -> bool:
    """Return whether a step by itself says which plane is meant: a curve in two parameters."""
    return len(list_free_parameters(step)) == 2


def _are_signals(step: Step, request: ViewRequest) -> bool:
    named = bool(request.x and request.y) and {request.x, request.y} <= set(list_signals(step))
    return named and not holds_equilibria(step)


DRAWING = Drawing(draw_figure, stands_alone=spans_plane, choose_steps=choose_steps)
