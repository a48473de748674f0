"""Brute-force diagrams: returns to the section over a parameter, each class of motion in its colour, under branches."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ResultsError
from pddecont.plot.axis_labels import format_axis_label
from pddecont.plot.branch_returns import draw_branch_returns
from pddecont.plot.class_colours import assign_class_colours, find_middle, list_attractor_rows
from pddecont.plot.columns import find_state, list_free_parameters, read_parameter, share_values
from pddecont.plot.layouts import finish_figure, make_axes, make_stack
from pddecont.plot.legend import make_area_handle, make_line_handle
from pddecont.plot.limits import measure_size, varies, widen_axis
from pddecont.plot.point_labels import PointLabel
from pddecont.plot.region_labels import find_inside, write_in_region
from pddecont.plot.view import Drawing, ViewRequest
from pddecont.results import Results, Step
from pddecont.tables import name_motion

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
# Dots are smaller the more there are: (beyond so many, size in points); beyond the last number they are an image.
DOT_SIZES = ((0, 5.0), (1000, 3.0), (5000, 1.2))
MAX_VECTOR_DOTS = 20_000


def draw_figure(steps: list[Step], request: ViewRequest) -> Figure:
    """Return the brute-force diagram, with Lyapunov exponents below it where they were computed."""
    sweeps, branches = [s for s in steps if s.kind == "sweep"], [s for s in steps if s.kind == "continue"]
    free = list_free_parameters(sweeps[-1])
    if len(free) == 2:
        figure, axes = make_axes(6.4, 5.0)
        handles = draw_classes(axes, sweeps[-1], request.x or free[0], request.y or free[1])
        return finish_figure(figure, axes, handles=handles)
    x, y = request.x or free[0], request.y or choose_state(sweeps)
    measured = [s for s in sweeps if np.any(np.isfinite(s.points["lyapunov"]))]
    figure, panels = make_stack(7.4, 6.6, 2, [2, 1]) if measured else make_stack(7.4, 4.6, 1)
    labels, of_branches = draw_branch_returns(panels[0], branches, sweeps[-1], x, y)
    numbers, of_classes = draw_returns(panels[0], sweeps, x, y)
    if measured:
        panels[0].set_xlabel("")
        draw_exponents(panels[1], measured, x)
    return finish_figure(figure, panels[0], [*labels, *numbers], [*of_classes, *of_branches])


def choose_steps(steps: list[Step], results: Results, request: ViewRequest) -> list[Step]:
    """Return the sweeps over the last one's parameters, after the branches that may be drawn over them."""
    free = list_free_parameters(steps[-1])
    sweeps = [step for step in steps if list_free_parameters(step) == free]
    return pick_steps([*(step for step in results.steps.values() if step.kind == "continue"), *sweeps], results)


def pick_steps(steps: list[Step], results: Results) -> list[Step]:
    """Return the sweeps among ``steps``, after the branches in the same parameter that may be drawn over them."""
    sweeps = [s for s in steps if s.kind == "sweep" and len(s)]
    if not sweeps:
        raise ResultsError("a brute-force diagram needs a sweep step with points")
    free = list_free_parameters(sweeps[-1])
    others = [name for name in sweeps[-1].meta["parameters"] if name not in free]
    branches = [
        s
        for s in steps
        if s.kind == "continue" and len(s) and list_free_parameters(s) == free and share_values(s, sweeps[-1], others)
    ]
    return [*branches, *sweeps]


def choose_state(steps: Sequence[Step]) -> str:
    """Return the first state whose returns vary beyond rounding: on an event's section a state may be constant."""
    states: list[str] = list(steps[-1].meta["states"])
    found = (s for s in states if varies(values := _collect_returns(steps, s), measure_size(steps, values)))
    return next(found, states[0])


def draw_returns(axes: Axes, steps: Sequence[Step], x: str, state: str) -> tuple[list[PointLabel], list[Artist]]:
    """Draw the returns of all attractors over the parameter ``x``.

    Returns the numbers of classes that have one, as labels, and the handles of the legend.
    """
    classes, labels = assign_class_colours(steps), []
    for name, colour in reversed(list(classes.colours.items())):
        found = []
        for step in steps:
            xs, j = read_parameter(step, x), find_state(step, state)
            rows = [i for i in list_attractor_rows(step) if name_motion(step, i) == name]
            returns = [step.orbit(i)["returns"][:, j] for i in rows]
            found += [(float(xs[i]), float(values[0])) for i, values in zip(rows, returns, strict=True) if len(values)]
            ys = np.concatenate([np.empty(0), *returns])
            size = [size for least, size in DOT_SIZES if len(ys) >= least][-1]
            axes.plot(
                np.repeat(xs[rows], np.array([len(values) for values in returns], dtype=np.intp)),
                ys,
                ".",
                ms=size,
                mew=0,
                color=colour,
                zorder=3,
                rasterized=len(ys) > MAX_VECTOR_DOTS,
            )
        if name in classes.numbers and found:
            place = found[find_middle(np.array([place for place, _ in found]))]
            labels.append(PointLabel(str(classes.numbers[name]), *place))
    widen_axis(axes, "y", measure_size(steps, _collect_returns(steps, state)))
    axes.set_xlabel(format_axis_label(steps, x))
    axes.set_ylabel(f"{format_axis_label(steps, state)} at returns")
    return labels, [make_line_handle(text, marker=".", ls="", color=c) for text, c in classes.list_legend()]


def draw_exponents(axes: Axes, steps: Sequence[Step], x: str) -> None:
    """Draw the largest Lyapunov exponents of all attractors over the parameter ``x``."""
    classes = assign_class_colours(steps)
    for step in steps:
        xs = read_parameter(step, x)
        for name, colour in classes.colours.items():
            rows = [i for i in list_attractor_rows(step) if name_motion(step, i) == name]
            axes.plot(xs[rows], step.points["lyapunov"][rows], ".", ms=3.5, mew=0, color=colour)
    axes.axhline(0.0, color="0.3", lw=0.8)
    axes.set_xlabel(format_axis_label(steps, x))
    axes.set_ylabel("largest Lyapunov exponent")


def draw_classes(axes: Axes, step: Step, x: str, y: str) -> list[Artist]:
    """Draw over two parameters which class of motion most starts lead to, and return the handles of the legend."""
    from matplotlib.colors import ListedColormap

    classes = assign_class_colours([step])
    names = list(classes.colours)
    (xs, columns), (ys, rows) = (np.unique(read_parameter(step, name), return_inverse=True) for name in (x, y))
    best, image = np.zeros((len(ys), len(xs))), np.full((len(ys), len(xs)), np.nan)
    for i in list_attractor_rows(step):
        cell, share = (rows[i], columns[i]), step.points["share"][i]
        if share > best[cell]:
            best[cell], image[cell] = share, names.index(name_motion(step, i))
    axes.pcolormesh(
        xs,
        ys,
        np.ma.masked_invalid(image),
        cmap=ListedColormap(list(classes.colours.values())),
        vmin=-0.5,
        vmax=len(names) - 0.5,
        shading="nearest",
        rasterized=True,
    )
    for name, number in classes.numbers.items():
        if np.any(image == names.index(name)):
            row, column = find_inside(image == names.index(name))
            write_in_region(axes, str(number), xs[column], ys[row])
    axes.grid(False)
    axes.set_xlabel(format_axis_label(step, x))
    axes.set_ylabel(format_axis_label(step, y))
    return [make_area_handle(text, color=colour) for text, colour in classes.list_legend()]


def _collect_returns(steps: Sequence[Step], state: str) -> Array:
    """Return a state at all returns of all attractors, shape (n_returns,)."""
    values = [step.orbit(i)["returns"][:, find_state(step, state)] for step in steps for i in list_attractor_rows(step)]
    return np.concatenate([np.empty(0), *values])


DRAWING = Drawing(draw_figure, choose_steps=choose_steps, pick_steps=pick_steps)
