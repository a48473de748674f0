"""How the panels of a figure are laid out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pddecont.plot.columns import describe_point
from pddecont.plot.legend import add_inner_legend, add_legend
from pddecont.plot.phase_plot import draw_orbit
from pddecont.plot.point_labels import PointLabel, place_labels
from pddecont.plot.segment_colours import has_several_names, list_segments
from pddecont.plot.style import INNER_LEGEND_SIZE
from pddecont.results import Step

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Phase plots beside a diagram at most, and panels of one figure.
MAX_BESIDE, MAX_PANELS = 4, 6
# Names of segments longer than this would cover a panel.
LONGEST_NAME = 24


def make_figure(width: float, height: float) -> Figure:
    """Return an empty figure of a size in inches."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height))


def make_axes(width: float, height: float) -> tuple[Figure, Axes]:
    """Return a figure of a size in inches and its one panel."""
    figure = make_figure(width, height)
    return figure, figure.subplots()


def make_panels(n: int) -> tuple[Figure, list[Axes]]:
    """Return a figure and its ``n`` panels of equal size, at most three in a row."""
    columns = 2 if n == 4 else min(n, 3)
    rows = -(-n // columns)
    figure = make_figure(4.2 * columns, 3.4 * rows)
    panels = list(np.ravel(figure.subplots(rows, columns, squeeze=False)))
    for spare in panels[n:]:
        spare.set_visible(False)
    return figure, panels[:n]


def make_stack(width: float, height: float, n: int, ratios: Sequence[float] | None = None) -> tuple[Figure, list[Axes]]:
    """Return a figure and its ``n`` panels one below the other over one horizontal axis, as high as ``ratios`` say."""
    figure = make_figure(width, height)
    panels = figure.subplots(n, 1, sharex=True, squeeze=False, height_ratios=ratios)
    return figure, list(panels[:, 0])


def make_panel_beside_orbits(
    steps: Sequence[Step], rows: Sequence[tuple[Step, int]], colours: Sequence[Mapping[str, str]]
) -> tuple[Figure, Axes]:
    """Return a figure and its large panel, with phase plots of ``rows`` to the right in ``colours`` of their segments.

    There are none where a model has one state.
    """
    states = list(steps[-1].meta["states"])
    if not rows or len(states) == 1:
        return make_axes(6.4, 4.4)
    figure = make_figure(9.2, 2.3 * max(2, len(rows)))
    grid = figure.add_gridspec(len(rows), 3)
    axes = figure.add_subplot(grid[:, :2])
    panels = [figure.add_subplot(grid[k, 2]) for k in range(len(rows))]
    for panel, (step, row), own in zip(panels, rows, colours, strict=True):
        draw_orbit(panel, step, row, states[0], states[1], own, describe_point(step, row))
    name_segments(panels, rows)
    return figure, axes


def name_segments(panels: Sequence[Axes], rows: Sequence[tuple[Step, int]]) -> None:
    """Put a legend of segments into the first panel whose orbit has several with names that leave room for it."""
    for axes, row in zip(panels, rows, strict=True):
        if has_several_names(*row) and max(map(len, list_segments(*row))) <= LONGEST_NAME:
            add_inner_legend(axes, INNER_LEGEND_SIZE)
            return


def finish_figure(
    figure: Figure, axes: Axes, labels: Sequence[PointLabel] = (), handles: Sequence[Artist] = ()
) -> Figure:
    """Add what goes in last, the legend and then the labels of points, and return the figure."""
    add_legend(figure, handles)
    place_labels(axes, labels)
    return figure
