"""Basins of attraction as an image, with the attractors' returns on it."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pddecont.plot.axis_labels import format_axis_label
from pddecont.plot.columns import describe_differences, find_state
from pddecont.plot.layouts import MAX_PANELS, finish_figure, make_axes, make_panels
from pddecont.plot.legend import make_area_handle, shorten_list
from pddecont.plot.style import TITLE_SIZE, make_palette
from pddecont.plot.view import Drawing, ViewRequest
from pddecont.results import Results, Step
from pddecont.tables import describe_reason, estimate_shares, find_attractors, name_motion, read_label_map

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# A class of motion, and the number of the attractor within it.
Attractor = tuple[str, int]
# The colour of states from which no attractor was reached, and how a table calls their class.
NOWHERE, NO_CLASS = "#d9d9d9", "none"
# Of all colours of basins, so that the returns on them can be seen.
OPACITY = 0.75
# Attractors that a legend lists: below a figure of one basin, and below one panel of several.
MAX_ATTRACTORS, MAX_IN_PANEL = 20, 6
# How far below a panel its legend begins, in inches: under the numbers and the name of the axis.
LEGEND_BELOW = 0.42
# Letters of a reason in one line of a legend.
LINE_LENGTH = 44
# A note goes on after these with numbers and advice.
_END_OF_REASON = re.compile(r": |; | \(| (?:at|near|after) t = ")


def draw_figure(steps: list[Step], request: ViewRequest) -> Figure:
    """Return a panel for each basin, with the parameters in which they differ."""
    from matplotlib.transforms import ScaledTranslation

    colours = assign_attractor_colours(steps)
    if len(steps) == 1:
        figure, axes = make_axes(6.4, 5.4)
        return finish_figure(figure, axes, handles=draw_basin(axes, steps[0], colours))
    figure, panels = make_panels(len(steps))
    values = np.array([step.points["parameters"][find_attractors(step)[0]] for step in steps])
    titles = describe_differences(steps[0].meta["parameters"], values)
    for axes, step, title in zip(panels, steps, titles, strict=True):
        handles = draw_basin(axes, step, colours, MAX_IN_PANEL)
        axes.set_title(title or step.name, fontsize=TITLE_SIZE)
        below = axes.transAxes + ScaledTranslation(0.0, -LEGEND_BELOW, figure.dpi_scale_trans)
        axes.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, 0.0), bbox_transform=below, fontsize=7.5)
    return figure


def choose_steps(steps: list[Step], results: Results, request: ViewRequest) -> list[Step]:
    """Return the basins over the last one's states, as many as one figure shows."""
    return [step for step in steps if step.meta["over"] == steps[-1].meta["over"]][-MAX_PANELS:]


def assign_attractor_colours(steps: Sequence[Step]) -> dict[Attractor, str]:
    """Return a colour for each class of motion and the number of the attractor within it, the same on all basins."""
    every = list(dict.fromkeys(attractor for step in steps for attractor in _list_attractors(step)))
    known = [attractor for attractor in every if attractor[0] != NO_CLASS]
    return dict.fromkeys(every, NOWHERE) | dict(zip(known, make_palette(len(known)), strict=True))


def draw_basin(axes: Axes, step: Step, colours: Mapping[Attractor, str], most: int = MAX_ATTRACTORS) -> list[Artist]:
    """Draw the map of attractors over the grid of initial states, and their returns.

    Returns the handles of the legend, the largest basins first (at most so many, and the number of the others), at the
    end the states from which no attractor was reached with the reasons.
    """
    from matplotlib.colors import ListedColormap

    labels, rows = read_label_map(step), find_attractors(step)
    own = [colours[attractor] for attractor in _list_attractors(step)]
    xs, ys = np.array(step.meta["x"]), np.array(step.meta["y"])[: len(labels)]
    axes.pcolormesh(
        xs,
        ys,
        labels,
        cmap=ListedColormap(own or [NOWHERE]),
        vmin=-0.5,
        vmax=max(len(rows), 1) - 0.5,
        alpha=OPACITY,
        shading="nearest",
        rasterized=True,
    )
    axes.grid(False)
    i, j = (find_state(step, name) for name in step.meta["over"])
    for row, colour in zip(rows, own, strict=True):
        points = step.orbit(int(row))["returns"]
        inside = (points[:, i] >= xs[0]) & (points[:, i] <= xs[-1]) & (points[:, j] >= ys[0]) & (points[:, j] <= ys[-1])
        if step.labels[row]:
            axes.plot(points[inside, i], points[inside, j], "o", ms=6, mfc=colour, mec="white", mew=1.2)
    axes.set_xlim(xs[0], xs[-1])
    axes.set_ylim(ys[0], ys[-1])
    axes.set_xlabel(f"{format_axis_label(step, step.meta['over'][0])} at the start")
    axes.set_ylabel(f"{format_axis_label(step, step.meta['over'][1])} at the start")
    return _make_handles(step, own, most)


def _list_attractors(step: Step) -> list[Attractor]:
    classes = [name_motion(step, int(row)) for row in find_attractors(step)]
    return [(name, classes[:k].count(name)) for k, name in enumerate(classes)]


def _make_handles(step: Step, colours: Sequence[str], most: int) -> list[Artist]:
    """Return the legend's handles; ``colours`` are those of the rows of ``found``."""
    shares = {row: share[0] for row, share in estimate_shares(step).items()}
    pairs = [(int(row), colour) for row, colour in zip(find_attractors(step), colours, strict=True)]
    reached = sorted((pair for pair in pairs if step.labels[pair[0]]), key=lambda pair: -shares[pair[0]])
    handles = [
        make_area_handle(
            f"{step.labels[row]}: {name_motion(step, row)}, {100 * shares[row]:.1f} %", color=colour, alpha=OPACITY
        )
        for row, colour in reached
    ]
    handles = shorten_list(handles, most)
    astray = [row for row, _ in pairs if not step.labels[row]]
    if astray:
        text = _describe_astray(step, astray, sum(shares[row] for row in astray))
        handles.append(make_area_handle(text, color=NOWHERE, alpha=OPACITY))
    return handles


def _describe_astray(step: Step, rows: Sequence[int], share: float) -> str:
    """Return what a legend says of the states from which no attractor was reached, with how each reason begins."""
    notes = [describe_reason(step.reason(row)) for row in rows]
    reasons = dict.fromkeys(_END_OF_REASON.split(note, maxsplit=1)[0] for note in notes)
    lines = [textwrap.fill(reason, LINE_LENGTH, subsequent_indent="   ") for reason in reasons]
    return "\n".join([f"no attractor recognised, {100 * share:.1f} %", *lines])


DRAWING = Drawing(draw_figure, choose_steps=choose_steps)
