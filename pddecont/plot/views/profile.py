"""States over one period, and the delayed values of one of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pddecont.plot.axis_labels import format_axis_label, format_name
from pddecont.plot.columns import describe_point, find_state
from pddecont.plot.interpolated_orbits import interpolate_segments
from pddecont.plot.layouts import make_panels
from pddecont.plot.limits import measure_size, widen_axis
from pddecont.plot.point_selection import select_points
from pddecont.plot.style import COLOURS, INNER_LEGEND_SIZE, TITLE_SIZE
from pddecont.plot.view import Drawing, ViewRequest
from pddecont.results import Step

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Of delayed values, one after the other.
DELAYED_STYLES = ("--", ":", "-.")


def draw_figure(steps: list[Step], request: ViewRequest) -> Figure:
    """Return a panel for each chosen point, with all states or the one that was asked for."""
    rows = select_points(steps, request)
    figure, panels = make_panels(len(rows))
    for axes, (step, row) in zip(panels, rows, strict=True):
        states = [request.y] if request.y else list(step.meta["states"])
        draw_profile(axes, step, row, states, describe_point(step, row))
    return figure


def draw_profile(axes: Axes, step: Step, row: int, states: list[str], title: str = "") -> None:
    """Draw states over one period, a single one with its delayed values; events are thin vertical lines."""
    arcs = interpolate_segments(step, row)
    start = arcs[0][0][0]
    for k, state in enumerate(states):
        index, name = find_state(step, state), format_name(state)
        for s, (t, values) in enumerate(arcs):
            axes.plot(t - start, values[:, index], color=COLOURS[k % len(COLOURS)], label=None if s else name)
    differ = _draw_delayed(axes, step, row, states[0], start) if len(states) == 1 else len(states) > 1
    for t, _ in arcs[1:]:
        axes.axvline(t[0] - start, color="0.7", lw=0.7, zorder=0)
    widen_axis(
        axes, "y", max(measure_size([step], step.orbits["states"][:, find_state(step, state)]) for state in states)
    )
    axes.set_xlabel(format_axis_label(step, "t"))
    axes.set_ylabel(", ".join(format_axis_label(step, state) for state in states))
    if differ:
        axes.legend(fontsize=INNER_LEGEND_SIZE)
    if title:
        axes.set_title(title, fontsize=TITLE_SIZE)


def _draw_delayed(axes: Axes, step: Step, row: int, state: str, start: float) -> bool:
    """Draw the delayed values of a state that the model reads, and return whether there are any."""
    names = list(step.meta.get("delayed", []))
    own = [name for name in names if name.startswith(f"{state}(")]
    for k, name in enumerate(own):
        for s, (t, values) in enumerate(interpolate_segments(step, row, "delayed")):
            axes.plot(
                t - start,
                values[:, names.index(name)],
                color="0.15",
                ls=DELAYED_STYLES[k % len(DELAYED_STYLES)],
                label=None if s else format_name(name),
            )
    return bool(own)


DRAWING = Drawing(draw_figure)
