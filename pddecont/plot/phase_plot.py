"""Orbits in the plane of two states, with the event surfaces that show there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pddecont.plot.axis_labels import format_axis_label
from pddecont.plot.columns import find_state
from pddecont.plot.interpolated_orbits import interpolate_segments
from pddecont.plot.limits import measure_size, widen_axis
from pddecont.plot.segment_colours import list_segments
from pddecont.plot.style import COLOURS, TITLE_SIZE
from pddecont.results import Step

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# A reset that moves the states by less than this share of their size is none.
NO_JUMP = 1e-9


def draw_orbit(axes: Axes, step: Step, row: int, x: str, y: str, colours: Mapping[str, str], title: str = "") -> None:
    """Draw the orbit of one point, each segment in the colour of its name, with the event surfaces in this plane."""
    i, j = find_state(step, x), find_state(step, y)
    arcs = [values for _, values in interpolate_segments(step, row)]
    for values, name in zip(arcs, list_segments(step, row), strict=True):
        axes.plot(values[:, i], values[:, j], color=colours[name], label=name)
    # A jump at a reset is drawn as a thin line.
    for before, after in zip(arcs, arcs[1:] + arcs[:1], strict=True):
        ends = np.array([before[-1, [i, j]], after[0, [i, j]]])
        if np.max(np.abs(ends[1] - ends[0])) > NO_JUMP * np.max(np.abs(ends), initial=1e-300):
            axes.plot(ends[:, 0], ends[:, 1], color="0.5", lw=0.8, ls="--")
    _draw_surfaces(axes, step, row, i, j)
    _finish_axes(axes, [step], x, y)
    if title:
        axes.set_title(title, fontsize=TITLE_SIZE)


def draw_orbits_together(axes: Axes, steps: Sequence[Step], x: str, y: str, title: str = "") -> None:
    """Draw the first orbits of several steps in one plane, each in its colour, later ones dashed over earlier ones."""
    for k, step in enumerate(steps):
        i, j = find_state(step, x), find_state(step, y)
        # Where a reset jumps, nothing is drawn.
        gap = np.full((1, len(step.meta["states"])), np.nan)
        values = np.concatenate([part for _, arc in interpolate_segments(step, 0) for part in (arc, gap)])
        axes.plot(
            values[:, i],
            values[:, j],
            ls="-" if k == 0 else (0, (4, 2)),
            lw=1.6 if k == 0 else 1.2,
            color=COLOURS[k % len(COLOURS)],
            label=step.name,
        )
    _draw_surfaces(axes, steps[0], 0, find_state(steps[0], x), find_state(steps[0], y))
    _finish_axes(axes, steps, x, y)
    axes.set_title(title, fontsize=TITLE_SIZE)


def _draw_surfaces(axes: Axes, step: Step, row: int, i: int, j: int) -> None:
    """Draw the event surfaces normal . z = level of a point that depend on states ``i`` and ``j`` alone."""
    n = len(step.meta["states"])
    for surface in step.points["surfaces"][row]:
        normal, level = surface[:n], surface[n]
        shown = [i, j]
        if not np.all(np.isfinite(surface)) or np.any(np.delete(normal, shown)) or not np.any(normal[shown]):
            continue
        style: dict[str, Any] = {"color": "0.35", "lw": 1.0, "zorder": 0}
        if normal[j] == 0.0:
            axes.axvline(level / normal[i], **style)
        elif normal[i] == 0.0:
            axes.axhline(level / normal[j], **style)
        else:
            axes.axline((0.0, level / normal[j]), slope=-normal[i] / normal[j], **style)


def _finish_axes(axes: Axes, steps: Sequence[Step], x: str, y: str) -> None:
    for which, name in (("x", x), ("y", y)):
        sizes = [measure_size([step], step.orbits["states"][:, find_state(step, name)]) for step in steps]
        widen_axis(axes, which, max(sizes))
    axes.set_xlabel(format_axis_label(steps, x))
    axes.set_ylabel(format_axis_label(steps, y))
