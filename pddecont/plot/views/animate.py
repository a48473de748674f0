"""A moving picture: the orbit along a branch, beside the diagram with a mark on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ResultsError
from pddecont.plot.branch_parts import LineStyle, split_branch
from pddecont.plot.columns import choose_states, describe_point, find_state, list_free_parameters, read_column
from pddecont.plot.heights import choose_columns
from pddecont.plot.interpolated_orbits import interpolate_segments
from pddecont.plot.layouts import make_figure
from pddecont.plot.legend import MAX_COLUMNS, add_legend
from pddecont.plot.limits import measure_size, widen_limits
from pddecont.plot.phase_plot import draw_orbit
from pddecont.plot.point_labels import place_labels
from pddecont.plot.segment_colours import match_diagram, match_plane
from pddecont.plot.style import MOVING_DPI
from pddecont.plot.view import Drawing, ViewRequest
from pddecont.plot.views.diagram import draw_diagram
from pddecont.plot.views.plane import draw_plane
from pddecont.plot.views.profile import draw_profile
from pddecont.results import Step

if TYPE_CHECKING:
    from matplotlib.animation import FuncAnimation
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

# At twelve frames a second ten seconds: a GIF of some megabytes.
MAX_FRAMES = 120
# Of its limits, around all orbits, as a share of their size.
MARGIN = 0.05
WORDS = {LineStyle.SOLID: "", LineStyle.DASHED: "unstable", LineStyle.DOTTED: "not admissible"}


def draw_animation(steps: list[Step], request: ViewRequest) -> FuncAnimation:
    """Return the orbits of a branch one after another, beside its diagram or, of a curve, the plane of its parameters.

    The request may name the two states (of a model with one state the time stands in for the first).
    """
    from matplotlib.animation import FuncAnimation

    step = steps[-1]
    if not can_move(step):
        raise ResultsError(f"step '{step.name}' has one point; there is nothing to move along")
    figure = make_figure(9.0, 4.4)
    figure.set_dpi(MOVING_DPI)
    left, right = figure.subplots(1, 2, width_ratios=[1.1, 1])
    rows = choose_frames(step)
    panel = OrbitPanel.make(step, request, rows)
    panel.draw(right, rows[0])
    free = list_free_parameters(step)
    x, y = (free[0], free[1]) if len(free) == 2 else choose_columns([step])
    labels, handles = draw_plane(left, steps[-1:], x, y) if len(free) == 2 else draw_diagram(left, steps[-1:], x, y)
    add_legend(figure, handles, MAX_COLUMNS)
    place_labels(left, labels)
    (mark,) = left.plot([], [], "o", ms=9, mfc="none", mec="black", mew=1.6, zorder=7)
    # The panels stay where they are from frame to frame.
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    xs, ys = read_column(step, x), read_column(step, y)

    def draw_frame(row: int) -> list[Artist]:
        mark.set_data([xs[row]], [ys[row]])
        panel.draw(right, int(row))
        return []

    return FuncAnimation(figure, draw_frame, frames=rows, cache_frame_data=False)


def can_move(step: Step) -> bool:
    """Return whether a step has points to move along."""
    return len(step) > 1


def choose_frames(step: Step) -> list[int]:
    """Return the rows that are shown, in order along the branch, special ones among them, at most MAX_FRAMES."""
    order = step.order
    places = np.unique(np.linspace(0, len(order) - 1, min(len(order), MAX_FRAMES)).round().astype(int))
    special = [k for k, row in enumerate(order) if step.labels[row]]
    for k in special[:MAX_FRAMES]:
        places[np.argmin(np.abs(places - k))] = k
    return [int(row) for row in order[np.unique(places)]]


@dataclass(frozen=True)
class OrbitPanel:
    """The panel with the orbit: its limits hold all orbits, so that it is the orbit that moves.

    ``colours`` and ``words`` go by row: colours of segments by name, and what the title says beside the point.
    """

    step: Step
    states: tuple[str, str]
    limits: tuple[tuple[float, float], tuple[float, float]]
    colours: Mapping[int, Mapping[str, str]]
    words: Mapping[int, str]

    @classmethod
    def make(cls, step: Step, request: ViewRequest, rows: list[int]) -> OrbitPanel:
        """Return the panel for the orbits ``rows`` of a step."""
        states = choose_states(step, request.x, request.y)
        match = match_plane if len(list_free_parameters(step)) == 2 else match_diagram
        colours = dict(zip(rows, match([step], [(step, row) for row in rows]), strict=True))
        values = np.concatenate([values for row in rows for _, values in interpolate_segments(step, row)])
        x, y = (
            find_limits(values[:, i], measure_size([step], step.orbits["states"][:, i]))
            for i in (find_state(step, state) for state in states)
        )
        if states[0] == states[1]:
            x = (0.0, float(np.max(step.points["period"][rows])))
        words = {int(row): WORDS[part.style] for part in split_branch(step) for row in part.rows[::-1]}
        return cls(step, states, (x, y), colours, words)

    def draw(self, axes: Axes, row: int) -> None:
        """Draw the orbit of a row in place of the one before."""
        axes.clear()
        title = "  ".join(text for text in (describe_point(self.step, row), self.words.get(row, "")) if text)
        if self.states[0] == self.states[1]:
            draw_profile(axes, self.step, row, [self.states[1]], title)
        else:
            draw_orbit(axes, self.step, row, *self.states, self.colours[row], title)
        axes.set_xlim(*self.limits[0])
        axes.set_ylim(*self.limits[1])


def find_limits(values: NDArray[np.float64], size: float) -> tuple[float, float]:
    """Return limits that hold ``values`` (n,) of a size with some room, far apart if these differ by rounding only."""
    low, high = widen_limits(float(np.nanmin(values)), float(np.nanmax(values)), size)
    gap = MARGIN * (high - low)
    return low - gap, high + gap


DRAWING = Drawing(draw_animation, stands_alone=can_move)
