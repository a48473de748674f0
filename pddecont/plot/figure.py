"""Whole pictures: how the panels of a view are laid out."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pddecont.errors import ResultsError
from pddecont.plot.animate import animate
from pddecont.plot.basin import basin_colours, draw_basin
from pddecont.plot.beside import beside_diagram, beside_plane, segment_colours, several_segments
from pddecont.plot.brute_force import default_state, draw_branches, draw_classes, draw_exponents, draw_returns, has_exponents
from pddecont.plot.choice import View, choose, chosen_rows, height, pair
from pddecont.plot.columns import default_columns, free_of, title
from pddecont.plot.diagram import draw_diagram
from pddecont.plot.look import look
from pddecont.plot.manifold import draw_manifold, draw_orbits_along, signals
from pddecont.plot.multipliers import draw_multipliers
from pddecont.plot.orbits import draw_orbit, draw_profile, draw_together, draw_trajectory
from pddecont.plot.plane import draw_plane
from pddecont.plot.precision import draw_distances, draw_enlarged, draw_family, draw_work, varied
from pddecont.plot.style import label
from pddecont.plot.tags import Tag, place_tags
from pddecont.plot.units import axis_label
from pddecont.results.attractors import found
from pddecont.results.precision import distances
from pddecont.results.reader import Results, Step

SUFFIXES = (".png", ".svg", ".pdf")
MOVING = (".gif", ".mp4")
BESIDE = 4
# Bytes of an SVG beyond which a PNG is the better picture.
LARGE = 1_000_000
# Letters of a legend that fit in an inch.
PER_INCH = 19


def draw(results: Results, view: View, path: Path, style: str | None = None) -> None:
    """Draw ``view`` of a results file to ``path``, whose suffix says how; ``style`` is a style sheet over this program's own look."""
    suffix, moving = path.suffix.lower(), view.kind == "animate"
    if suffix in MOVING and not moving:
        raise ResultsError(f"{path}: '{suffix}' holds moving pictures; give '--view animate', or one of {', '.join(SUFFIXES)}")
    if suffix not in (MOVING if moving else SUFFIXES):
        what = "moving pictures" if moving else "pictures"
        raise ResultsError(f"{path}: {what} are {', '.join(MOVING if moving else SUFFIXES)}; found '{path.suffix or 'no suffix'}'")
    with look(style), np.errstate(all="ignore"):
        try:
            if moving:
                _, steps = choose(results, view)
                animate(steps[-1], view, path)
            else:
                picture(results, view).savefig(path)
        except OSError as exc:
            raise ResultsError(f"{path} cannot be written: {exc.strerror}") from exc
        except (ValueError, OverflowError, np.linalg.LinAlgError) as exc:
            # Axes cannot be laid out for numbers that are not finite, or too large to be subtracted.
            raise ResultsError(f"what {results.path} holds cannot be drawn so: {' '.join(str(exc).split())[:200]}") from exc


def image(results: Results, view: View) -> tuple[str, bytes]:
    """Return ``view`` of a results file as (media type, contents): SVG, or PNG where that would be large."""
    with look(), io.BytesIO() as drawn:
        figure = picture(results, view)
        figure.savefig(drawn, format="svg", metadata={"Date": None})
        if drawn.tell() <= LARGE:
            return "image/svg+xml", drawn.getvalue()
        drawn.seek(0)
        drawn.truncate()
        figure.savefig(drawn, format="png")
        return "image/png", drawn.getvalue()


def picture(results: Results, view: View) -> Any:
    """Return ``view`` of a results file as a matplotlib figure."""
    kind, steps = choose(results, view)
    views = {"diagram": _diagram, "plane": _plane, "manifold": _manifold, "multipliers": _multipliers, "orbit": _orbits,
             "profile": _profiles, "trajectory": _trajectory, "sweep": _sweep, "basin": _basin,
             "precision": _precision, "distance": _distance}  # fmt: skip
    return views[kind](steps, view)


def _figure(width: float, height: float) -> Any:
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height))


def _states(step: Step, view: View) -> tuple[str, str]:
    states = list(step.meta["states"])
    return view.x or states[0], view.y or states[min(1, len(states) - 1)]


def _diagram(steps: list[Step], view: View) -> Any:
    """Return the diagram with phase plots of chosen or special points beside it."""
    x, y = default_columns(steps[-1])
    rows = chosen_rows(steps, view, BESIDE, ends=False)
    figure, axes = _with_orbits(steps, rows, beside_diagram(steps, rows))
    return _finished(figure, axes, *draw_diagram(axes, steps, view.x or x, view.y or y))


def _plane(steps: list[Step], view: View) -> Any:
    """Return the curves in two parameters, with phase plots of points that were asked for."""
    asked = chosen_rows(steps, view, ends=False) if view.labels or view.indices else []
    figure, axes = _with_orbits(steps, asked, beside_plane(steps, asked))
    return _finished(figure, axes, *draw_plane(axes, steps, *pair(steps[::-1], view)))


def _with_orbits(steps: list[Step], rows: Sequence[tuple[Step, int]], colours: Sequence[Mapping[str, str]]) -> tuple[Any, Any]:
    """Return a figure and its large panel, with phase plots of ``rows`` in ``colours`` of their segments to the right of it."""
    states = list(steps[-1].meta["states"])
    if not rows or len(states) == 1:
        figure = _figure(6.4, 4.4)
        return figure, figure.subplots()
    figure = _figure(9.2, 2.3 * max(2, len(rows)))
    grid = figure.add_gridspec(len(rows), 3)
    axes = figure.add_subplot(grid[:, :2])
    panels = [figure.add_subplot(grid[k, 2]) for k in range(len(rows))]
    for panel, (step, row), own in zip(panels, rows, colours, strict=True):
        draw_orbit(panel, step, row, states[0], states[1], own, title(step, row))
    _name_segments(panels, rows)
    return figure, axes


def _name_segments(panels: Sequence[Any], rows: Sequence[tuple[Step, int]]) -> None:
    """Put a legend of segments into the first panel whose orbit has several."""
    for axes, row in zip(panels, rows, strict=True):
        if several_segments(*row):
            handles, names = axes.get_legend_handles_labels()
            unique = dict(zip(names, handles, strict=True))
            axes.legend(unique.values(), unique.keys(), fontsize=8)
            return


def _finished(figure: Any, axes: Any, tags: Sequence[Tag], handles: Sequence[Any]) -> Any:
    if handles:
        longest = max(len(line) for handle in handles for line in handle.get_label().splitlines())
        columns = max(1, min(3, len(handles), int(figure.get_figwidth() * PER_INCH / (longest + 6))))
        figure.legend(handles=handles, loc="outside lower center", ncols=columns, fontsize=8.5)
    place_tags(axes, tags)
    return figure


def _manifold(steps: list[Step], view: View) -> Any:
    figure = _figure(7.4, 6.4)
    axes = figure.add_subplot(projection="3d")
    axes.set_box_aspect((4, 4, 3), zoom=0.98)
    if view.x and view.y and {view.x, view.y} <= set(signals(steps[-1])):
        lines = draw_orbits_along(axes, steps[-1], view.x, view.y, view.z or free_of(steps[-1])[0])
        figure.colorbar(lines, ax=axes, label=axis_label(steps, view.z or free_of(steps[-1])[0]), shrink=0.6, pad=0.12)
        return figure
    return _finished(figure, axes, *draw_manifold(axes, steps, *pair(steps, view), height(steps, view)))


def _multipliers(steps: list[Step], view: View) -> Any:
    step, rows = steps[0], [row for _, row in chosen_rows(steps, view, ends=False)]
    figure = _figure(6.4, 5.2)
    axes = figure.subplots()
    dots = draw_multipliers(axes, step, rows)
    if dots is not None:
        figure.colorbar(dots, ax=axes, label=axis_label(step, free_of(step)[0]), shrink=0.85)
    handles, _ = axes.get_legend_handles_labels()
    if handles:
        figure.legend(handles=handles, loc="outside lower center", ncols=min(2, len(handles)), fontsize=8.5)
    return figure


def _panels(n: int) -> tuple[Any, list[Any]]:
    columns = 2 if n == 4 else min(n, 3)
    lines = -(-n // columns)
    figure = _figure(4.2 * columns, 3.4 * lines)
    flat = list(np.ravel(figure.subplots(lines, columns, squeeze=False)))
    for spare in flat[n:]:
        spare.set_visible(False)
    return figure, flat[:n]


def _orbits(steps: list[Step], view: View) -> Any:
    if len(steps[0].meta["states"]) == 1:
        return _profiles(steps, view)
    if len(steps) > 1:
        return _orbits_together(steps, view)
    rows = chosen_rows(steps, view)
    figure, panels = _panels(len(rows))
    colours = segment_colours(rows)
    for axes, (step, row) in zip(panels, rows, strict=True):
        draw_orbit(axes, step, row, *_states(step, view), colours, title(step, row))
    _name_segments(panels, rows)
    return figure


def _orbits_together(steps: list[Step], view: View) -> Any:
    """Return a panel for each set of parameters with all orbits that have them, one over the other."""
    groups: dict[tuple[float, ...], list[Step]] = {}
    for step in steps:
        groups.setdefault(tuple(step.points["parameters"][0]), []).append(step)
    figure, panels = _panels(len(groups))
    values = np.array(list(groups))
    changing = np.flatnonzero(np.ptp(values, axis=0) > 0)
    names = list(steps[0].meta["parameters"])
    for axes, (parameters, same) in zip(panels, groups.items(), strict=True):
        title = "  ".join(f"{label(names[k])} = {parameters[k]:.6g}" for k in changing)
        draw_together(axes, same, *_states(steps[0], view), title)
        axes.legend(fontsize=8)
    return figure


def _profiles(steps: list[Step], view: View) -> Any:
    rows = chosen_rows(steps, view)
    figure, panels = _panels(len(rows))
    for axes, (step, row) in zip(panels, rows, strict=True):
        draw_profile(axes, step, row, [view.y] if view.y else list(step.meta["states"]), title(step, row))
    return figure


def _sweep(steps: list[Step], view: View) -> Any:
    """Return the brute-force diagram, with Lyapunov exponents below it where they were computed."""
    sweeps, branches = [s for s in steps if s.kind == "sweep"], [s for s in steps if s.kind == "continue"]
    free = free_of(sweeps[-1])
    if len(free) == 2:
        figure = _figure(6.4, 5.0)
        axes = figure.subplots()
        return _finished(figure, axes, [], draw_classes(axes, sweeps[-1], view.x or free[0], view.y or free[1]))
    x, y = view.x or free[0], view.y or default_state(sweeps)
    measured = [s for s in sweeps if has_exponents(s)]
    figure = _figure(7.4, 6.6 if measured else 4.6)
    panels = figure.subplots(2 if measured else 1, sharex=True, squeeze=False, height_ratios=[2, 1] if measured else [1])[:, 0]
    tags, of_branches = draw_branches(panels[0], branches, sweeps[-1], x, y)
    handles = draw_returns(panels[0], sweeps, x, y) + of_branches
    if measured:
        panels[0].set_xlabel("")
        draw_exponents(panels[1], measured, x)
    return _finished(figure, panels[0], tags, handles)


def _basin(steps: list[Step], view: View) -> Any:
    """Return a panel for each basin, with the parameters in which they differ."""
    values = np.array([step.points["parameters"][found(step)[0]] for step in steps])
    changing = np.flatnonzero(np.ptp(values, axis=0) > 0)
    if len(steps) == 1:
        figure = _figure(6.4, 5.4)
        axes = figure.subplots()
        return _finished(figure, axes, [], draw_basin(axes, steps[0], basin_colours(steps)))
    figure, panels = _panels(len(steps))
    palette = basin_colours(steps)
    for axes, step, parameters in zip(panels, steps, values, strict=True):
        handles = draw_basin(axes, step, palette)
        axes.set_title("  ".join(f"{label(step.meta['parameters'][k])} = {parameters[k]:.6g}" for k in changing) or step.name, fontsize=9.5)
        axes.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.16), fontsize=7.5)
    return figure


def _precision(steps: list[Step], view: View) -> Any:
    """Return error against CPU time and against unknowns (or steps), and Dist(N) where the length of a chain varies."""
    step = steps[0]
    costs = [view.x] if view.x else list(varied(step))
    with_distances = bool(distances(step)) and not view.x
    figure = _figure(4.4 * (len(costs) + with_distances), 4.6)
    panels = figure.subplots(1, len(costs) + with_distances, squeeze=False)[0]
    handles = [draw_work(axes, step, cost) for axes, cost in zip(panels, costs, strict=False)]
    for axes in panels[1 : len(costs)]:
        axes.set_ylabel("")
    if with_distances:
        draw_distances(panels[-1], step, "distance from the delay equation")
    return _finished(figure, panels[0], [], handles[0])


def _distance(steps: list[Step], view: View) -> Any:
    """Return the family of orbits of the last step, then Dist(N) of every step."""
    figure, panels = _panels(len(steps) + 2)
    draw_family(panels[0], steps[-1], *_states(steps[-1], view))
    draw_enlarged(panels[1], steps[-1], *_states(steps[-1], view))
    values = np.array([step.points["parameters"][0] for step in steps])
    changing, names = np.flatnonzero(np.ptp(values, axis=0) > 0), list(steps[0].meta["parameters"])

    def at(row: Any) -> str:
        return "  ".join(f"{label(names[k])} = {row[k]:.6g}" for k in changing)

    panels[0].set_title(at(values[-1]), fontsize=9.5)
    for axes, step, row in zip(panels[2:], steps, values, strict=True):
        draw_distances(axes, step, at(row) or step.name)
    return figure


def _trajectory(steps: list[Step], view: View) -> Any:
    """Return a panel for each of a trajectory's first states and its signals, or for the one that was asked for."""
    step = steps[0]
    names = [view.y] if view.y else [*list(step.meta["states"])[:2], *step.meta.get("signals", [])]
    figure = _figure(8.5, 1.2 + 2.2 * len(names))
    panels = figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0]
    for axes, name in zip(panels, names, strict=True):
        draw_trajectory(axes, step, name)
    panels[-1].set_xlabel(axis_label(step, "t"))
    return figure
