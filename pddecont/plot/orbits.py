"""Orbits in the plane of two states, with the event surface; states over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pddecont.errors import ResultsError, suggest
from pddecont.plot.curves import segments
from pddecont.plot.limits import size_of, widen
from pddecont.plot.style import COLOURS, label
from pddecont.plot.units import axis_label
from pddecont.results.reader import Step
from pddecont.results.summary import signature


def state_index(step: Step, name: str) -> int:
    """Return a state's number, or raise :class:`ResultsError` with the states there are."""
    states = list(step.meta["states"])
    if name not in states:
        raise ResultsError(f"step '{step.name}' has no state '{name}'{suggest(name, states)} (states: {', '.join(states)})")
    return states.index(name)


def draw_orbit(axes: Any, step: Step, row: int, x: str, y: str, colours: Mapping[str, str], title: str = "") -> None:
    """Draw the orbit of one point, each segment in the colour of its name, with the event surfaces that show in this plane."""
    i, j = state_index(step, x), state_index(step, y)
    arcs = segments(step, row)
    for (_, z), name in zip(arcs, segment_names(step, row), strict=True):
        axes.plot(z[:, i], z[:, j], color=colours[name], label=name)
    # A jump at a reset is drawn as a thin line.
    for (_, before), (_, after) in zip(arcs, arcs[1:] + arcs[:1], strict=True):
        ends = np.array([before[-1, [i, j]], after[0, [i, j]]])
        if np.max(np.abs(ends[1] - ends[0])) > 1e-9 * np.max(np.abs(ends), initial=1e-300):
            axes.plot(ends[:, 0], ends[:, 1], color="0.5", lw=0.8, ls="--")
    _draw_surfaces(axes, step, row, i, j)
    for which, k in (("x", i), ("y", j)):
        widen(axes, which, size_of([step], step.orbits["states"][:, k]))
    axes.set_xlabel(axis_label(step, x))
    axes.set_ylabel(axis_label(step, y))
    if title:
        axes.set_title(title, fontsize=9.5)


def draw_together(axes: Any, steps: Sequence[Step], x: str, y: str, title: str = "") -> None:
    """Draw the orbits of several steps in one plane, each in its colour, later ones dashed over earlier ones."""
    for k, step in enumerate(steps):
        i, j = state_index(step, x), state_index(step, y)
        # Where a reset jumps, nothing is drawn.
        gap = np.full((1, len(step.meta["states"])), np.nan)
        z = np.concatenate([part for _, arc in segments(step, 0) for part in (arc, gap)])
        axes.plot(z[:, i], z[:, j], ls="-" if k == 0 else (0, (4, 2)), lw=1.6 if k == 0 else 1.2, color=COLOURS[k % len(COLOURS)],
                  label=step.name)  # fmt: skip
    _draw_surfaces(axes, steps[0], 0, state_index(steps[0], x), state_index(steps[0], y))
    for which, name in (("x", x), ("y", y)):
        widen(axes, which, max(size_of([step], step.orbits["states"][:, state_index(step, name)]) for step in steps))
    axes.set_xlabel(axis_label(steps, x))
    axes.set_ylabel(axis_label(steps, y))
    axes.set_title(title, fontsize=9.5)


def _draw_surfaces(axes: Any, step: Step, row: int, i: int, j: int) -> None:
    n = len(step.meta["states"])
    for surface in step.points["surfaces"][row]:
        normal, level = surface[:n], surface[n]
        shown = [i, j]
        if not np.all(np.isfinite(surface)) or np.any(np.delete(normal, shown)) or not np.any(normal[shown]):
            continue
        style = {"color": "0.35", "lw": 1.0, "zorder": 0}
        if normal[j] == 0.0:
            axes.axvline(level / normal[i], **style)
        elif normal[i] == 0.0:
            axes.axhline(level / normal[j], **style)
        else:
            axes.axline((0.0, level / normal[j]), slope=-normal[i] / normal[j], **style)


def segment_names(step: Step, row: int) -> list[str]:
    """Return the segments' names of a recorded orbit."""
    return signature(step, row).split()


def draw_profile(axes: Any, step: Step, row: int, states: list[str], title: str = "") -> None:
    """Draw states over one period, a single one with its delayed values; events are thin vertical lines."""
    arcs = segments(step, row)
    start = arcs[0][0][0]
    for k, state in enumerate(states):
        index = state_index(step, state)
        for s, (t, z) in enumerate(arcs):
            axes.plot(t - start, z[:, index], color=COLOURS[k % len(COLOURS)], label=label(state) if s == 0 else None)
    named = _draw_delayed(axes, step, row, states[0], start) if len(states) == 1 else len(states) > 1
    if len(arcs) > 1:
        for t, _ in arcs[1:]:
            axes.axvline(t[0] - start, color="0.7", lw=0.7, zorder=0)
    widen(axes, "y", max(size_of([step], step.orbits["states"][:, state_index(step, state)]) for state in states))
    axes.set_xlabel(axis_label(step, "t"))
    axes.set_ylabel(", ".join(axis_label(step, s) for s in states))
    if named:
        axes.legend(fontsize=8)
    if title:
        axes.set_title(title, fontsize=9.5)


def _draw_delayed(axes: Any, step: Step, row: int, state: str, start: float) -> bool:
    """Draw the delayed values of a state that the model reads, and return whether there are any."""
    names = list(step.meta.get("delayed", []))
    own = [name for name in names if name.startswith(f"{state}(")]
    for k, name in enumerate(own):
        for s, (t, z) in enumerate(segments(step, row, "delayed")):
            axes.plot(t - start, z[:, names.index(name)], color="0.15", ls=("--", ":", "-.")[k % 3], label=label(name) if s == 0 else None)
    return bool(own)


def draw_trajectory(axes: Any, step: Step, name: str) -> None:
    """Draw a state or a signal of a trajectory over time; dashed lines stand where parameters change."""
    rows = step.orbit(0)
    states, signals = list(step.meta["states"]), list(step.meta.get("signals", []))
    if name in signals:
        values = rows["signals"][:, signals.index(name)]
    elif name in states:
        values = rows["states"][:, states.index(name)]
    else:
        known = [*states, *signals]
        raise ResultsError(f"step '{step.name}' has no state or signal '{name}'{suggest(name, known)} (there are: {', '.join(known)})")
    axes.plot(rows["time"], values, color=COLOURS[(states + signals).index(name) % len(COLOURS)], lw=0.9)
    widen(axes, "y", size_of([step], values))
    for t in step.meta.get("changes", []):
        if t >= rows["time"][0]:
            axes.axvline(t, color="0.3", lw=0.9, ls="--")
    axes.set_ylabel(axis_label(step, name))
