"""In three dimensions: branches and curves over the plane of two parameters, or the orbits themselves along one of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pddecont.plot.columns import agree, column, free_of
from pddecont.plot.diagram import special_rows
from pddecont.plot.limits import size_of, widen
from pddecont.plot.plane import curve_colour, curve_handles
from pddecont.plot.stretches import colouring, stretches, style_handles
from pddecont.plot.style import marker
from pddecont.plot.tags import Tag
from pddecont.plot.units import axis_label
from pddecont.results.reader import Step

# Apart from the colours of the curves' kinds.
FAMILY_COLOURS = ("0.25", "#3aa0b5", "#c45f96", "#7d9b3c", "0.65")


def within_plane(steps: Sequence[Step], x: str, y: str) -> list[Step]:
    """Return the curves in the parameters ``x``, ``y`` and the branches in one of them that lie in the same plane.

    A branch lies in a plane if its other parameters have the values that they have on the first curve (or, without curves, on
    the last branch).
    """
    curves = [s for s in steps if set(free_of(s)) == {x, y}]
    branches = [s for s in steps if len(free_of(s)) == 1 and free_of(s)[0] in (x, y)]
    if not curves and not branches:
        return []
    first = (curves or branches[-1:])[0]
    others = [name for name in first.meta["parameters"] if name not in (x, y)]
    return [*(s for s in curves if agree(s, first, others)), *(s for s in branches if agree(s, first, others))]


def draw_manifold(axes: Any, steps: Sequence[Step], x: str, y: str, z: str) -> tuple[list[Tag], list[Any]]:
    """Draw curves in two parameters as thick lines and branches as thin ones, in three dimensions.

    Returns the names of special points, placed as they are seen, and the handles of the legend.
    """
    from mpl_toolkits.mplot3d.proj3d import proj_transform

    curves = [s for s in steps if len(free_of(s)) == 2]
    branches = [s for s in steps if len(free_of(s)) == 1]
    families = {stretch.family for branch in branches for stretch in stretches(branch)}
    colours, handles = colouring(branches, FAMILY_COLOURS if len(families) > 1 else FAMILY_COLOURS[:1]) if branches else ({}, [])
    special: list[tuple[str, list[float]]] = []
    for step in steps:
        thick = step in curves
        xyz = [column(step, name) for name in (x, y, z)]
        for s in stretches(step):
            axes.plot(*(values[s.rows] for values in xyz), s.style, lw=2.8 if thick else 1.0,
                      color=curve_colour(step) if thick else colours[step.name, s.family])  # fmt: skip
        for i in special_rows(step):
            axes.plot(*([values[i]] for values in xyz), marker=marker(step.labels[i][:2]), ls="", color="black", ms=4)
            special.append((step.labels[i], [float(values[i]) for values in xyz]))
    widen(axes, "z", size_of(steps, np.concatenate([column(step, z) for step in steps])))
    for name, put in ((x, axes.set_xlabel), (y, axes.set_ylabel), (z, axes.set_zlabel)):
        put(axis_label(steps, name))
    seen = [(name, proj_transform(*place, axes.get_proj())) for name, place in special]
    named = handles if len(families) > 1 else []
    return [Tag(name, float(p[0]), float(p[1])) for name, p in seen], [*curve_handles(curves), *named, *style_handles(steps)]


def signals(step: Step) -> list[str]:
    """Return what orbits are drawn in: the states, and their delayed values as the model writes them."""
    return [*step.meta["states"], *step.meta.get("delayed", [])]


def draw_orbits_along(axes: Any, step: Step, x: str, y: str, z: str) -> Any:
    """Draw each point's orbit in two signals, at the height of a parameter: the solution manifold. Returns the coloured lines."""
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    heights = column(step, z)
    lines, places = [], []
    for i in step.order:
        orbit = step.orbit(int(i))
        every = np.hstack([orbit["states"], orbit["delayed"]]) if "delayed" in orbit else orbit["states"]
        first, second = (every[:, signals(step).index(name)] for name in (x, y))
        around = np.append(np.arange(len(first)), 0)
        lines.append(np.stack([first[around], second[around], np.full(len(around), heights[i])], axis=1))
        places.append(heights[i])
    drawn = Line3DCollection(lines, array=np.array(places), cmap="viridis", linewidths=0.9)
    axes.add_collection3d(drawn)
    whole = np.vstack(lines)
    for k, (name, put, limit) in enumerate(((x, axes.set_xlabel, axes.set_xlim), (y, axes.set_ylabel, axes.set_ylim),
                                            (z, axes.set_zlabel, axes.set_zlim))):  # fmt: skip
        put(axis_label(step, name))
        limit(whole[:, k].min(), whole[:, k].max())
    return drawn
