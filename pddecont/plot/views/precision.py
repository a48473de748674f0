"""Work-precision diagrams: error against CPU time, and against unknowns or steps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pddecont.plot.axis_labels import format_name
from pddecont.plot.chain_distances import METHOD_MARKERS, draw_distances
from pddecont.plot.layouts import finish_figure, make_panels
from pddecont.plot.style import COLOURS
from pddecont.plot.view import Drawing, ViewRequest
from pddecont.results import Step
from pddecont.tables import find_envelope, find_rows, fit_slope, list_methods, measure_distances, read_reference_error

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Least error that a logarithmic axis can show for a result that agrees in all digits.
LEAST = 1e-16
# What an axis says of a cost.
COST_LABELS = {"cpu": "CPU time (s)", "n_unknowns": "unknowns", "n_steps": "steps", "memory": "memory (bytes)"}
# Letters of the names of all quantities that fit beside an axis.
MAX_LETTERS = 40


def draw_figure(steps: list[Step], request: ViewRequest) -> Figure:
    """Return error against CPU time and against unknowns (or steps), and Dist(N) where the length of a chain varies."""
    step = steps[0]
    costs = [request.x] if request.x else list_costs(step)
    n_panels = len(costs) + (bool(measure_distances(step)) and not request.x)
    figure, panels = make_panels(n_panels)
    handles = [draw_work(axes, step, cost) for axes, cost in zip(panels, costs, strict=False)]
    for axes in panels[1 : len(costs)]:
        axes.set_ylabel("")
    if n_panels > len(costs):
        draw_distances(panels[-1], step, "distance from the delay equation")
    return finish_figure(figure, panels[0], handles=handles[0])


def list_costs(step: Step) -> list[str]:
    """Return what errors are drawn against: time, and unknowns of orbits or steps of simulations."""
    return ["cpu", "n_steps"] if np.any(step.points["n_steps"] > 0) else ["cpu", "n_unknowns"]


def draw_work(axes: Axes, step: Step, x: str) -> list[Artist]:
    """Draw each method's errors against a cost, the best joined by a line, and return the handles with their slopes."""
    handles: list[Artist] = []
    cost, floor = step.points[x].astype(float), read_reference_error(step)
    for name, colour, mark in zip(list_methods(step), COLOURS, METHOD_MARKERS, strict=False):
        rows = find_rows(step, name)
        if not len(rows):
            continue
        errors = np.maximum(step.points["error"][rows], LEAST)
        axes.plot(cost[rows], errors, mark, ms=4, color=colour, alpha=0.35, mew=0)
        best = rows[find_envelope(cost[rows], errors)]
        shown = np.maximum(step.points["error"][best], LEAST)
        order = fit_slope(cost[best], shown, floor)
        text = f"{name}, slope {order:.1f}" if np.isfinite(order) else name
        handles += axes.plot(cost[best], shown, f"-{mark}", ms=5, color=colour, label=text)
        if x == "cpu":
            _draw_spread(axes, step, best, shown, colour)
    if floor > LEAST:
        _draw_floor(axes, floor)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel(COST_LABELS.get(x, x))
    names = ", ".join(map(format_name, step.meta["quantities"]))
    axes.set_ylabel(f"relative error of {names}" if len(names) < MAX_LETTERS else "largest relative error")
    return handles


def _draw_spread(axes: Axes, step: Step, rows: NDArray[np.intp], errors: NDArray[np.float64], colour: str) -> None:
    """Draw how far repeated measurements of CPU time lie apart, in the proportion of their wall times."""
    cpu, wall, low, high = (step.points[name][rows] for name in ("cpu", "wall", "wall_low", "wall_high"))
    spread: Sequence[NDArray[np.float64]] = [(wall - low) * (cpu / wall), (high - wall) * (cpu / wall)]
    axes.errorbar(cpu, errors, xerr=spread, fmt="none", ecolor=colour, lw=0.8)


def _draw_floor(axes: Axes, floor: float) -> None:
    axes.axhline(floor, color="#777777", lw=0.9, ls=":")
    axes.annotate(
        "error of the reference",
        (0.99, floor),
        xycoords=("axes fraction", "data"),
        xytext=(0, 2),
        fontsize=7.5,
        textcoords="offset points",
        ha="right",
        color="#555555",
    )


DRAWING = Drawing(draw_figure)
