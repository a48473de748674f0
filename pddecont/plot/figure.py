"""Whole pictures: which panels a results file gives, and how they are laid out."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pddecont.errors import ResultsError
from pddecont.plot.diagram import column, default_columns, draw_diagram
from pddecont.plot.orbits import draw_orbit, draw_profile, draw_trajectory
from pddecont.plot.style import RC, label
from pddecont.results.reader import Results, Step

SUFFIXES = (".png", ".svg", ".pdf")
MAX_PANELS = 6


@dataclass(frozen=True)
class View:
    """What to draw; None leaves the choice to the file's contents."""

    kind: str | None = None
    step: str | None = None
    x: str | None = None
    y: str | None = None
    labels: tuple[str, ...] = ()
    indices: tuple[int, ...] = ()


def draw(results: Results, view: View, path: Path) -> None:
    """Draw ``view`` of a results file to ``path`` (PNG, SVG or PDF by suffix)."""
    if path.suffix.lower() not in SUFFIXES:
        raise ResultsError(f"{path}: pictures are {', '.join(SUFFIXES)}; found '{path.suffix or 'no suffix'}'")
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    step = _chosen(results, view)
    with plt.rc_context(dict(RC)):
        views = {"diagram": _diagram, "orbit": _orbits, "profile": _profiles, "trajectory": _trajectory}
        figure = views[_kind(step, view)](plt, step, view)
        try:
            figure.savefig(path)
        except OSError as exc:
            raise ResultsError(f"{path} cannot be written: {exc.strerror}") from exc
        finally:
            plt.close(figure)


def _chosen(results: Results, view: View) -> Step:
    if view.step is not None:
        return results.step(view.step)
    wanted = {"trajectory": ("simulate",), "diagram": ("continue",)}.get(view.kind or "", ("continue", "orbit", "simulate"))
    for kind in wanted:
        found = [s for s in results.steps.values() if s.kind == kind and len(s)]
        if found:
            return found[-1]
    raise ResultsError(f"{results.path} holds nothing to draw (steps: {', '.join(results.steps) or 'none'})")


def _kind(step: Step, view: View) -> str:
    fits = {"simulate": ("trajectory",), "orbit": ("orbit", "profile"), "continue": ("diagram", "orbit", "profile")}[step.kind]
    kind = view.kind or fits[0]
    if kind not in fits:
        raise ResultsError(f"step '{step.name}' is a {step.kind} step; it can be drawn as {', '.join(fits)}, not as {kind}")
    return kind


def _rows(step: Step, view: View) -> list[int]:
    """Return the rows whose orbits are shown: those asked for, else the special points, else the first and the last."""
    asked = [*(step.row(name) for name in view.labels), *view.indices]
    for i in asked:
        if i >= len(step):
            raise ResultsError(f"step '{step.name}' has {len(step)} points, no index {i}")
    if asked:
        return asked
    special = [i for i in step.order if step.labels[i] and not step.labels[i].startswith("EP")]
    return (special or [int(i) for i in dict.fromkeys((step.order[0], step.order[-1]))])[:MAX_PANELS]


def _title(step: Step, row: int) -> str:
    free = step.meta.get("free") or []
    values = [f"{label(name)} = {column(step, name)[row]:.6g}" for name in free]
    return "  ".join([t for t in (step.labels[row],) if t] + values)


def _states(step: Step, view: View) -> tuple[str, str]:
    states = list(step.meta["states"])
    return view.x or states[0], view.y or states[min(1, len(states) - 1)]


def _diagram(plt: Any, step: Step, view: View) -> Any:
    """Return the diagram with phase plots of chosen or special points beside it."""
    x, y = default_columns(step)
    x, y = view.x or x, view.y or y
    rows = _rows(step, view) if len(step.meta["states"]) > 1 else []
    if not any(step.labels[i] for i in rows) and not (view.labels or view.indices):
        rows = []
    rows = rows[:4]
    if not rows:
        figure, axes = plt.subplots(figsize=(6.4, 4.2))
        draw_diagram(axes, step, x, y)
        return figure
    figure = plt.figure(figsize=(9.2, 2.3 * max(2, len(rows))))
    grid = figure.add_gridspec(len(rows), 3)
    draw_diagram(figure.add_subplot(grid[:, :2]), step, x, y)
    states = list(step.meta["states"])
    for k, row in enumerate(rows):
        draw_orbit(figure.add_subplot(grid[k, 2]), step, row, states[0], states[1], _title(step, row))
    return figure


def _panels(plt: Any, n: int) -> tuple[Any, list[Any]]:
    columns = min(n, 3)
    lines = -(-n // columns)
    figure, axes = plt.subplots(lines, columns, figsize=(4.2 * columns, 3.4 * lines), squeeze=False)
    flat = list(np.ravel(axes))
    for spare in flat[n:]:
        spare.set_visible(False)
    return figure, flat[:n]


def _orbits(plt: Any, step: Step, view: View) -> Any:
    rows = _rows(step, view)
    if len(step.meta["states"]) == 1:
        return _profiles(plt, step, view)
    figure, panels = _panels(plt, len(rows))
    for axes, row in zip(panels, rows, strict=True):
        draw_orbit(axes, step, row, *_states(step, view), _title(step, row))
    if len(np.unique(step.orbit(rows[0])["segment"])) > 1:
        handles, names = panels[0].get_legend_handles_labels()
        unique = dict(zip(names, handles, strict=True))
        panels[0].legend(unique.values(), unique.keys(), fontsize=8)
    return figure


def _profiles(plt: Any, step: Step, view: View) -> Any:
    rows = _rows(step, view)
    figure, panels = _panels(plt, len(rows))
    states = [view.y] if view.y else list(step.meta["states"])
    for axes, row in zip(panels, rows, strict=True):
        draw_profile(axes, step, row, states, _title(step, row))
    return figure


def _trajectory(plt: Any, step: Step, view: View) -> Any:
    figure, axes = plt.subplots(figsize=(8.5, 3.6))
    draw_trajectory(axes, step, [view.y] if view.y else list(step.meta["states"])[:2])
    return figure
