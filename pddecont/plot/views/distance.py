"""The orbits of all chains of a family, an enlargement of them, and their distance from the delay equation."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pddecont.plot.axis_labels import format_axis_label
from pddecont.plot.chain_distances import draw_distances
from pddecont.plot.columns import choose_states, describe_differences, find_state
from pddecont.plot.layouts import MAX_PANELS, make_panels
from pddecont.plot.style import COLOURS, TITLE_SIZE
from pddecont.plot.view import Drawing, ViewRequest
from pddecont.results import Results, Step
from pddecont.tables import REFERENCE, measure_distances, name_method

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Half the width of an enlargement, as part of the orbit's.
ENLARGED = 0.12
# Opacity of the shortest and of the longest chain.
FAINT, FULL = 0.15, 0.7


def draw_figure(steps: list[Step], request: ViewRequest) -> Figure:
    """Return the family of orbits of the last step, then Dist(N) of every step."""
    figure, panels = make_panels(len(steps) + 2)
    x, y = choose_states(steps[-1], request.x, request.y)
    draw_family(panels[0], steps[-1], x, y)
    draw_enlarged(panels[1], steps[-1], x, y)
    titles = describe_differences(
        steps[0].meta["parameters"], np.array([step.points["parameters"][0] for step in steps])
    )
    panels[0].set_title(titles[-1], fontsize=TITLE_SIZE)
    for axes, step, title in zip(panels[2:], steps, titles, strict=True):
        draw_distances(axes, step, title or step.name)
    return figure


def choose_steps(steps: list[Step], results: Results, request: ViewRequest) -> list[Step]:
    """Return the last steps, as many as one figure shows."""
    return steps[-MAX_PANELS:]


def has_distances(step: Step) -> bool:
    """Return whether a step compares chains of several lengths."""
    return bool(measure_distances(step))


def draw_family(axes: Axes, step: Step, x: str, y: str) -> None:
    """Draw the orbits of all chains, faint to full with N, and the delay equation's dashed over them."""
    i, j = find_state(step, x), find_state(step, y)
    lengths = step.points["n"]
    chains = [k for k in range(len(step)) if lengths[k] > 0 and np.isfinite(step.points["error"][k])]
    shades = np.linspace(FAINT, FULL, max(len(chains), 1))
    for shade, k in zip(shades, sorted(chains, key=lambda k: int(lengths[k])), strict=False):
        _draw_closed(axes, step, k, i, j, color=COLOURS[0], alpha=float(shade), lw=0.8)
    for k in range(len(step)):
        if name_method(step, k) == REFERENCE:
            _draw_closed(axes, step, k, i, j, color=COLOURS[1], ls="--", lw=1.2)
    axes.set_xlabel(format_axis_label(step, x))
    axes.set_ylabel(format_axis_label(step, y))


def draw_enlarged(axes: Axes, step: Step, x: str, y: str) -> None:
    """Draw the same near the first end of a segment of the delay equation's orbit."""
    draw_family(axes, step, x, y)
    states = step.orbit(0)["states"]
    i, j = find_state(step, x), find_state(step, y)
    ends = np.array(step.meta["ends"])
    axes.plot(*ends[:, [i, j]].T, "o", ms=4, color=COLOURS[1])
    for set_limits, k in ((axes.set_xlim, i), (axes.set_ylim, j)):
        half = ENLARGED * float(np.ptp(states[:, k]))
        set_limits(ends[0, k] - half, ends[0, k] + half)
    axes.set_title("enlarged, with the events", fontsize=TITLE_SIZE)


def _draw_closed(axes: Axes, step: Step, row: int, i: int, j: int, **style: Any) -> None:
    states = step.orbit(row)["states"]
    axes.plot(np.append(states[:, i], states[0, i]), np.append(states[:, j], states[0, j]), **style)


DRAWING = Drawing(draw_figure, can_show=has_distances, choose_steps=choose_steps)
