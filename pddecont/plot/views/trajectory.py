"""A simulation: states and signals over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pddecont.errors import ResultsError, suggest
from pddecont.plot.axis_labels import format_axis_label
from pddecont.plot.layouts import make_stack
from pddecont.plot.limits import measure_size, widen_axis
from pddecont.plot.style import COLOURS
from pddecont.plot.view import Drawing, ViewRequest
from pddecont.results import Step

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# States that are shown when none is asked for.
MAX_STATES = 2


def draw_figure(steps: list[Step], request: ViewRequest) -> Figure:
    """Return a panel for each of a trajectory's first states and its signals, or for the one that was asked for."""
    step = steps[0]
    names = [*list(step.meta["states"])[:MAX_STATES], *step.meta.get("signals", [])]
    names = [request.y] if request.y else names
    figure, panels = make_stack(8.5, 1.2 + 2.2 * len(names), len(names))
    for axes, name in zip(panels, names, strict=True):
        draw_trajectory(axes, step, name)
    panels[-1].set_xlabel(format_axis_label(step, "t"))
    return figure


def draw_trajectory(axes: Axes, step: Step, name: str) -> None:
    """Draw a state or a signal of a trajectory over time; dashed lines stand where parameters change."""
    rows = step.orbit(0)
    states, signals = list(step.meta["states"]), list(step.meta.get("signals", []))
    if name in signals:
        values = rows["signals"][:, signals.index(name)]
    elif name in states:
        values = rows["states"][:, states.index(name)]
    else:
        known = [*states, *signals]
        raise ResultsError(
            f"step '{step.name}' has no state or signal '{name}'{suggest(name, known)} (there are: {', '.join(known)})"
        )
    axes.plot(rows["time"], values, color=COLOURS[(states + signals).index(name) % len(COLOURS)], lw=0.9)
    widen_axis(axes, "y", measure_size([step], values))
    for t in step.meta.get("changes", []):
        if t >= rows["time"][0]:
            axes.axvline(t, color="0.3", lw=0.9, ls="--")
    axes.set_ylabel(format_axis_label(step, name))


DRAWING = Drawing(draw_figure)
