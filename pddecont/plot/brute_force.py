"""Brute-force diagrams: returns to the section over a parameter, each class of motion in its colour, under branches where there are any."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.plot.curves import segments
from pddecont.plot.diagram import special_rows
from pddecont.plot.limits import size_of, varies, widen
from pddecont.plot.orbits import state_index
from pddecont.plot.stretches import stretches, style_handles
from pddecont.plot.style import COLOURS, marker
from pddecont.plot.tags import Tag
from pddecont.plot.units import axis_label
from pddecont.results.attractors import class_of
from pddecont.results.reader import Step

Array = NDArray[np.float64]
# Classes that have a colour of their own.
MAX_CLASSES = 7


def classes(steps: Sequence[Step]) -> dict[str, str]:
    """Return the colour of each class of motion, the most frequent first; those beyond the palette are grey."""
    counts: dict[str, int] = {}
    for step in steps:
        for i in range(len(step)):
            if step.labels[i]:
                name = class_of(step, i)
                counts[name] = counts.get(name, 0) + 1
    ordered = sorted(counts, key=lambda name: (-counts[name], name))
    return {name: COLOURS[k] if k < MAX_CLASSES else "0.6" for k, name in enumerate(ordered)}


def draw_returns(axes: Any, steps: Sequence[Step], x: str, state: str) -> list[Any]:
    """Draw the returns of all attractors over the parameter ``x``; return the handles of the legend."""
    from matplotlib.lines import Line2D

    colours = classes(steps)
    for name, colour in reversed(colours.items()):
        for step in steps:
            column, j = list(step.meta["parameters"]).index(x), state_index(step, state)
            points: list[Array] = [np.empty((0, 2))]
            for i in range(len(step)):
                if step.labels[i] and class_of(step, i) == name:
                    values = step.orbit(i)["returns"][:, j]
                    points.append(np.stack([np.full(len(values), step.points["parameters"][i, column]), values], axis=-1))
            xy = np.concatenate(points)
            size = 5.0 if len(xy) < 1000 else 3.0 if len(xy) < 5000 else 1.2
            axes.plot(xy[:, 0], xy[:, 1], ".", ms=size, mew=0, color=colour, zorder=3, rasterized=len(xy) > 20_000)
    widen(axes, "y", size_of(steps, _values(steps, state)))
    axes.set_xlabel(axis_label(steps, x))
    axes.set_ylabel(f"{axis_label(steps, state)} at returns")
    return [Line2D([], [], marker=".", ls="", color=colour, label=name) for name, colour in colours.items()]


def default_state(steps: Sequence[Step]) -> str:
    """Return the first state whose returns vary beyond rounding; on a section that an event makes a state may be constant."""
    states = list(steps[-1].meta["states"])
    return next((s for s in states if varies(values := _values(steps, s), size_of(steps, values))), states[0])


def _values(steps: Sequence[Step], state: str) -> Array:
    """Return a state at all returns of all attractors, shape (n_returns,)."""
    rows = [step.orbit(i)["returns"][:, state_index(step, state)] for step in steps for i in range(len(step)) if step.labels[i]]
    return np.concatenate([np.empty(0), *rows])


def draw_branches(axes: Any, branches: Sequence[Step], sweep: Step, x: str, state: str) -> tuple[list[Tag], list[Any]]:
    """Draw where the orbits of branches return to the section of a sweep: solid lines are stable, dashed ones unstable.

    Returns the names of special points, which go in last, and the handles of the legend.
    """
    from matplotlib.lines import Line2D

    tags: list[Tag] = []
    drawn = []
    for branch in branches:
        column, j = list(branch.meta["parameters"]).index(x), state_index(branch, state)
        for stretch in stretches(branch):
            lines = [_returns(branch, int(row), j, sweep) for row in stretch.rows]
            n = min((len(values) for values in lines), default=0)
            if n == 0:
                continue
            xs = branch.points["parameters"][stretch.rows, column]
            for values in _joined([v[:n] for v in lines]).T:
                axes.plot(xs, values, stretch.style, color="0.45", lw=0.9, zorder=1)
            drawn.append(branch)
        for row in special_rows(branch):
            place, values = float(branch.points["parameters"][row, column]), _returns(branch, row, j, sweep)
            axes.plot(np.full(len(values), place), values, marker=marker(branch.labels[row][:2]), ls="", color="black", ms=4, zorder=5)
            tags += [Tag(branch.labels[row], place, float(value)) for value in values[:1]]
    if not drawn:
        return tags, []
    handles = style_handles(drawn) or [Line2D([], [], label="orbits")]
    for handle in handles:
        handle.set(color="0.45", lw=0.9, label=f"followed: {handle.get_label()}")
    return tags, handles


def _joined(lines: Sequence[Array]) -> Array:
    """Return the values of neighbouring orbits in such a turn that each continues the nearest one before, shape (n_orbits, n)."""
    result = [lines[0]]
    for values in lines[1:]:
        turned = [np.roll(values, k) for k in range(len(values))]
        result.append(min(turned, key=lambda v: float(np.max(np.abs(v - result[-1])))))
    return np.array(result)


def _returns(branch: Step, row: int, j: int, sweep: Step) -> Array:
    """Return a state of an orbit where it returns to a sweep's section, shape (n_returns,); empty where that cannot be told."""
    section = sweep.meta["section"]
    parts = segments(branch, row)
    if "phase" in section:
        n = int(branch.points["n_periods"][row])
        period = float(branch.points["period"][row]) / n
        start, end = parts[0][0][0], parts[-1][0][-1]
        times = (np.ceil(start / period - section["phase"]) + section["phase"] + np.arange(n)) * period
        times = start + (times - start) % (end - start)
        found = []
        for t in times:
            part = next((p for p in parts if p[0][0] <= t <= p[0][-1]), parts[-1])
            found.append(float(np.interp(t, part[0], part[1][:, j])))
        return np.array(found)
    return np.empty(0)


def draw_exponents(axes: Any, steps: Sequence[Step], x: str) -> None:
    """Draw the largest Lyapunov exponents of all attractors over the parameter ``x``."""
    colours = classes(steps)
    for step in steps:
        column = list(step.meta["parameters"]).index(x)
        for name, colour in colours.items():
            rows = [i for i in range(len(step)) if step.labels[i] and class_of(step, i) == name]
            values = step.points["lyapunov"][rows]
            axes.plot(step.points["parameters"][rows, column], values, ".", ms=3.5, mew=0, color=colour)
    axes.axhline(0.0, color="0.3", lw=0.8)
    axes.set_xlabel(axis_label(steps, x))
    axes.set_ylabel("largest Lyapunov exponent")


def has_exponents(step: Step) -> bool:
    """Whether any Lyapunov exponent was computed."""
    return bool(np.any(np.isfinite(step.points["lyapunov"])))


def draw_classes(axes: Any, step: Step, x: str, y: str) -> list[Any]:
    """Draw which class of motion most starts lead to over the plane of two parameters; return the handles of the legend."""
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    colours = classes([step])
    names = list(colours)
    columns = [list(step.meta["parameters"]).index(name) for name in (x, y)]
    xs, ys = (np.unique(step.points["parameters"][:, c]) for c in columns)
    best, image = np.zeros((len(ys), len(xs))), np.full((len(ys), len(xs)), np.nan)
    for i in range(len(step)):
        at = tuple(np.searchsorted(v, step.points["parameters"][i, c]) for v, c in ((ys, columns[1]), (xs, columns[0])))
        if step.labels[i] and step.points["share"][i] > best[at]:
            best[at], image[at] = step.points["share"][i], names.index(class_of(step, i))
    axes.pcolormesh(xs, ys, np.ma.masked_invalid(image), cmap=ListedColormap(list(colours.values())), vmin=-0.5, vmax=len(names) - 0.5,
                    shading="nearest", rasterized=True)  # fmt: skip
    axes.grid(False)
    axes.set_xlabel(axis_label(step, x))
    axes.set_ylabel(axis_label(step, y))
    return [Patch(color=colour, label=name) for name, colour in colours.items()]
