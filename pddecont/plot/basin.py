"""Basins of attraction as an image, with the attractors' returns on it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pddecont.plot.style import COLOURS
from pddecont.plot.units import axis_label
from pddecont.results.attractors import basin_shares, class_of, found, label_map
from pddecont.results.reader import Step

NOWHERE = "#d9d9d9"


def basin_colours(steps: Sequence[Step]) -> dict[tuple[str, int], str]:
    """Return a colour for each class of motion and the number of the attractor within it, the same on all basins."""
    colours: dict[tuple[str, int], str] = {}
    for step in steps:
        for key in _keys(step):
            colours.setdefault(key, NOWHERE if key[0] == "none" else COLOURS[len(colours) % len(COLOURS)])
    return colours


def _keys(step: Step) -> list[tuple[str, int]]:
    names = [class_of(step, int(row)) for row in found(step)]
    return [(name, names[:k].count(name)) for k, name in enumerate(names)]


def draw_basin(axes: Any, step: Step, palette: Mapping[tuple[str, int], str]) -> list[Any]:
    """Draw the map of attractors over the grid of initial states; return the handles of the legend, the largest basin first."""
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
    names = [f"{step.labels[row] or 'none'}: {class_of(step, int(row))}, {100 * shares[int(row)][0]:.1f} %" for row in rows]
    handles = [Patch(color=colour, alpha=0.75, label=name) for name, colour in zip(names, colours, strict=True)]
    order = np.argsort([-shares[int(row)][0] for row in rows], kind="stable")
    return [handles[k] for k in order]
