"""Basins of attraction as an image, with the attractors' returns on it."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pddecont.plot.style import palette
from pddecont.plot.units import axis_label
from pddecont.results.attractors import basin_shares, class_of, found, label_map
from pddecont.results.reader import Step

NOWHERE = "#d9d9d9"
# Letters of a reason in one line of a legend.
WIDTH = 44
# A note goes on after these with numbers and advice.
_BEGINNING = re.compile(r": |; | \(| (?:at|near|after) t = ")


def basin_colours(steps: Sequence[Step]) -> dict[tuple[str, int], str]:
    """Return a colour for each class of motion and the number of the attractor within it, the same on all basins."""
    keys = list(dict.fromkeys(key for step in steps for key in _keys(step)))
    known = [key for key in keys if key[0] != "none"]
    return dict.fromkeys(keys, NOWHERE) | dict(zip(known, palette(len(known)), strict=True))


def _keys(step: Step) -> list[tuple[str, int]]:
    names = [class_of(step, int(row)) for row in found(step)]
    return [(name, names[:k].count(name)) for k, name in enumerate(names)]


def draw_basin(axes: Any, step: Step, palette: Mapping[tuple[str, int], str]) -> list[Any]:
    """Draw the map of attractors over the grid of initial states; return the handles of the legend, the largest basin first.

    States from which no attractor was reached come last, with the reasons.
    """
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    labels, rows, shares = label_map(step), found(step), basin_shares(step)
    colours = [palette[key] for key in _keys(step)]
    ys = np.array(step.meta["y"])[: len(labels)]
    xs = np.array(step.meta["x"])
    axes.pcolormesh(xs, ys, labels, cmap=ListedColormap(colours or [NOWHERE]), vmin=-0.5, vmax=max(len(rows), 1) - 0.5, alpha=0.75,
                    shading="nearest", rasterized=True)  # fmt: skip
    axes.grid(False)
    i, j = (list(step.meta["states"]).index(name) for name in step.meta["over"])
    for row, colour in zip(rows, colours, strict=True):
        points = step.orbit(int(row))["returns"]
        inside = (points[:, i] >= xs[0]) & (points[:, i] <= xs[-1]) & (points[:, j] >= ys[0]) & (points[:, j] <= ys[-1])
        if step.labels[row]:
            axes.plot(points[inside, i], points[inside, j], "o", ms=6, mfc=colour, mec="white", mew=1.2)
    axes.set_xlim(xs[0], xs[-1])
    axes.set_ylim(ys[0], ys[-1])
    axes.set_xlabel(f"{axis_label(step, step.meta['over'][0])} at the start")
    axes.set_ylabel(f"{axis_label(step, step.meta['over'][1])} at the start")
    reached = sorted((k for k, row in enumerate(rows) if step.labels[row]), key=lambda k: -shares[int(rows[k])][0])
    handles = [Patch(color=colours[k], alpha=0.75, label=f"{step.labels[rows[k]]}: {class_of(step, int(rows[k]))}, "
                     f"{100 * shares[int(rows[k])][0]:.1f} %") for k in reached]  # fmt: skip
    astray = [int(row) for row in rows if not step.labels[row]]
    if astray:
        handles.append(Patch(color=NOWHERE, alpha=0.75, label=_nowhere(step, astray, sum(shares[row][0] for row in astray))))
    return handles


def _nowhere(step: Step, rows: Sequence[int], share: float) -> str:
    """Return what a legend says of the states from which no attractor was reached, with the beginnings of the reasons."""
    notes = [step.points["note"][row].decode(errors="replace") for row in rows]
    reasons = [textwrap.fill(r, WIDTH, subsequent_indent="   ") for r in dict.fromkeys(_BEGINNING.split(n, maxsplit=1)[0] for n in notes)]
    return "\n".join([f"no attractor recognised, {100 * share:.1f} %", *reasons])
