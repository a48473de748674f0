"""A moving picture: the orbit along a branch, beside the diagram with a mark on it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ResultsError
from pddecont.plot.beside import beside_diagram, beside_plane
from pddecont.plot.choice import View
from pddecont.plot.columns import column, default_columns, free_of, title
from pddecont.plot.curves import segments
from pddecont.plot.diagram import draw_diagram
from pddecont.plot.limits import size_of, widened
from pddecont.plot.orbits import draw_orbit, draw_profile, state_index
from pddecont.plot.plane import draw_plane
from pddecont.plot.stretches import DASHED, DOTTED, stretches
from pddecont.plot.tags import place_tags
from pddecont.results.reader import Step

MAX_FRAMES = 120
PER_SECOND = 12
DPI = 100
WORDS = {DASHED: "unstable", DOTTED: "not admissible"}


def animate(step: Step, view: View, path: Path) -> None:
    """Write the orbits of a branch one after another, as GIF or MP4 by the suffix of ``path``.

    Of a branch the diagram goes with them, of a curve in two parameters their plane. ``view`` may name the two states (of a model
    with one state the time stands in for the first).
    """
    from matplotlib.figure import Figure

    if len(step) < 2:
        raise ResultsError(f"step '{step.name}' has one point; there is nothing to move along")
    writer = _writer(path)
    figure = Figure(figsize=(9.0, 4.4), dpi=DPI)
    left, right = figure.subplots(1, 2, width_ratios=[1.1, 1])
    shown = _Shown(right, step, view)
    shown.draw(int(step.order[0]))
    x, y = default_columns(step) if len(free_of(step)) < 2 else (free_of(step)[0], free_of(step)[1])
    draw = draw_plane if len(free_of(step)) == 2 else draw_diagram
    tags, handles = draw(left, [step], x, y)
    if handles:
        figure.legend(handles=handles, loc="outside lower center", ncols=min(3, len(handles)), fontsize=8.5)
    place_tags(left, tags)
    (mark,) = left.plot([], [], "o", ms=9, mfc="none", mec="black", mew=1.6, zorder=7)
    # The panels stay where they are from frame to frame.
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    xs, ys = column(step, x), column(step, y)
    with writer.saving(figure, str(path), DPI):
        for row in frames(step):
            mark.set_data([xs[row]], [ys[row]])
            shown.draw(int(row))
            writer.grab_frame()


def frames(step: Step) -> NDArray[np.intp]:
    """Return the rows that are shown, in order along the branch, at most :data:`MAX_FRAMES`; special points are among them."""
    order = step.order
    places = np.unique(np.linspace(0, len(order) - 1, min(len(order), MAX_FRAMES)).round().astype(int))
    special = [k for k, row in enumerate(order) if step.labels[row]]
    for k in special[:MAX_FRAMES]:
        places[np.argmin(np.abs(places - k))] = k
    return order[np.unique(places)]


class _Shown:
    """The panel with the orbit: its limits hold all orbits, so that it is the orbit that moves."""

    def __init__(self, axes: Any, step: Step, view: View):
        self.axes, self.step = axes, step
        self.states = list(step.meta["states"])
        self.names = (view.x or self.states[0], view.y or self.states[min(1, len(self.states) - 1)])
        i, j = (state_index(step, name) for name in self.names)
        rows = frames(step)
        orbits = [(step, int(row)) for row in rows]
        beside = beside_plane if len(free_of(step)) == 2 else beside_diagram
        self.colours = dict(zip(map(int, rows), beside([step], orbits), strict=True))
        arcs = [arc for row in rows for arc in segments(step, int(row))]
        if i == j:
            self.across = (0.0, float(np.max(step.points["period"][rows])))
        else:
            self.across = _limits(np.concatenate([z[:, i] for _, z in arcs]), size_of([step], step.orbits["states"][:, i]))
        self.up = _limits(np.concatenate([z[:, j] for _, z in arcs]), size_of([step], step.orbits["states"][:, j]))
        self.notes = {int(row): WORDS.get(s.style, "") for s in stretches(step) for row in s.rows[::-1]}

    def draw(self, row: int) -> None:
        """Draw the orbit of a row in place of the one before."""
        self.axes.clear()
        words = [title(self.step, row), self.notes.get(row, "")]
        text = "  ".join(w for w in words if w)
        if self.names[0] == self.names[1]:
            draw_profile(self.axes, self.step, row, [self.names[1]], text)
        else:
            draw_orbit(self.axes, self.step, row, *self.names, self.colours[row], text)
        self.axes.set_xlim(*self.across)
        self.axes.set_ylim(*self.up)


def _limits(values: NDArray[np.float64], size: float) -> tuple[float, float]:
    low, high = widened(float(np.nanmin(values)), float(np.nanmax(values)), size)
    gap = 0.05 * (high - low)
    return low - gap, high + gap


def _writer(path: Path) -> Any:
    from matplotlib.animation import FFMpegWriter, PillowWriter

    if path.suffix.lower() == ".gif":
        return PillowWriter(fps=PER_SECOND)
    if not FFMpegWriter.isAvailable():
        raise ResultsError(f"{path}: MP4 is written by the program 'ffmpeg', which was not found; install it, or write a .gif")
    return FFMpegWriter(fps=PER_SECOND)
