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
from pddecont.plot.sizes import JOURNAL_WIDTH
from pddecont.plot.style import INNER_LEGEND_SIZE
from pddecont.results import Step

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Phase plots beside a diagram at most, and panels of one figure.
MAX_BESIDE, MAX_PANELS = 4, 6
# The height in inches that each phase plot beside a diagram needs with its title.
LEAST_HEIGHT = 1.35
# Names of segments longer than this would cover a panel.
LONGEST_NAME = 24


def make_figure(width: float, height: float) -> Figure:
    """Return an empty figure of a size in inches, or of that which matplotlib's settings ask for."""
    from matplotlib import rcParams, rcParamsDefault

    from pddecont.plot.shown_figure import ShownFigure

    asked = rcParams["figure.figsize"]
    if list(asked) == list(rcParamsDefault["figure.figsize"]):
        return ShownFigure(figsize=(width, height))
    # Without a height the picture keeps the proportions of its view.
    return ShownFigure(figsize=(asked[0], asked[1] or asked[0] * height / width))


def count_beside() -> int:
    """Return how many phase plots have room beside a diagram, in a picture of the height that was asked for."""
    from matplotlib import rcParams, rcParamsDefault

    asked = rcParams["figure.figsize"]
    is_free = list(asked) == list(rcParamsDefault["figure.figsize"]) or not asked[1]
    return MAX_BESIDE if is_free else min(MAX_BESIDE, int(asked[1] / LEAST_HEIGHT))


def make_axes(width: float, height: float) -> tuple[Figure, Axes]:
    """Return a figure of a size in inches and its one panel."""
    figure = make_figure(width, height)
    return figure, figure.subplots()


def make_panels(n: int) -> tuple[Figure, list[Axes]]:
    """Return a figure and its ``n`` panels of equal size, at most three in a row, one in a narrow picture."""
    columns = 1 if _is_narrow() else 2 if n == 4 else min(n, 3)
    rows = -(-n // columns)
    figure = make_figure(3.4, 2.4 * rows) if _is_narrow() else make_figure(4.2 * columns, 3.4 * rows)
    panels = list(np.ravel(figure.subplots(rows, columns, squeeze=False)))
    for spare in panels[n:]:
        spare.set_visible(False)
    return figure, panels[:n]


def make_pair() -> tuple[Figure, list[Axes]]:
    """Return a figure and its two panels, side by side or, in a picture as narrow as a journal's column, stacked."""
    figure = make_figure(3.4, 5.0) if _is_narrow() else make_figure(9.6, 4.4)
    shape = (2, 1) if _is_narrow() else (1, 2)
    return figure, list(np.ravel(figure.subplots(*shape, squeeze=False)))


def make_stack(width: float, height: float, n: int, ratios: Sequence[float] | None = None) -> tuple[Figure, list[Axes]]:
    """Return a figure and its ``n`` panels one below the other over one horizontal axis, as high as ``ratios`` say."""
    figure = make_figure(width, height)
    panels = figure.subplots(n, 1, sharex=True, squeeze=False, height_ratios=ratios)
    return figure, list(panels[:, 0])


def make_panel_beside_orbits(
    steps: Sequence[Step], rows: Sequence[tuple[Step, int]], colours: Sequence[Mapping[str, str]]
) -> tuple[Figure, Axes]:
    """Return a figure and its large panel, with phase plots of ``rows`` to the right in ``colours`` of their segments.

    There are none where a model has one state. In a picture as narrow as a journal's column they stand below.
    """
    states = list(steps[-1].meta["states"])
    if not rows or len(states) == 1:
        return make_axes(6.4, 4.4)
    figure, axes, panels = _make_room_below(len(rows)) if _is_narrow() else _make_room_beside(len(rows))
    for panel, (step, row), own in zip(panels, rows, colours, strict=True):
        shared = any(s.name != step.name and s.labels[i] == step.labels[row] for s, i in rows)
        title = f"{step.name}: {describe_point(step, row)}" if shared else describe_point(step, row)
        draw_orbit(panel, step, row, states[0], states[1], own, title)
    name_segments(panels, rows)
    return figure, axes


def _make_room_beside(n: int) -> tuple[Figure, Axes, list[Axes]]:
    figure = make_figure(9.2, 2.3 * max(2, n))
    grid = figure.add_gridspec(n, 3)
    return figure, figure.add_subplot(grid[:, :2]), [figure.add_subplot(grid[k, 2]) for k in range(n)]


def _make_room_below(n: int) -> tuple[Figure, Axes, list[Axes]]:
    n_rows = -(-n // 2)
    figure = make_figure(3.4, 2.5 + 1.6 * n_rows)
    grid = figure.add_gridspec(1 + n_rows, 2, height_ratios=[1.6, *([1] * n_rows)])
    panels = [figure.add_subplot(grid[1 + k // 2, k % 2 if n > 1 else slice(None)]) for k in range(n)]
    return figure, figure.add_subplot(grid[0, :]), panels


def _is_narrow() -> bool:
    """Whether matplotlib's settings ask for a picture as narrow as a journal's column."""
    from matplotlib import rcParams

    return bool(rcParams["figure.figsize"][0] < JOURNAL_WIDTH)


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
