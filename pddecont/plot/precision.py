"""Work-precision diagrams, error against unknowns, and the distance of chains from the delay equation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pddecont.plot.style import COLOURS, label
from pddecont.plot.units import axis_label
from pddecont.results.precision import REFERENCE, distances, envelope, families, family, reference_error, rows_of, slope
from pddecont.results.reader import Step

MARKS = "os^DvPX*"
# Least error that a logarithmic axis can show for a result that agrees in all digits.
LEAST = 1e-16
# Half the width of an enlargement, as part of the orbit's.
ENLARGED = 0.12


def draw_work(axes: Any, step: Step, x: str) -> list[Any]:
    """Draw each method's errors against a cost, the best of them joined by a line; return the handles with their slopes."""
    handles = []
    cost, floor = step.points[x].astype(float), reference_error(step)
    for name, colour, mark in zip(families(step), COLOURS, MARKS, strict=False):
        rows = rows_of(step, name)
        if not len(rows):
            continue
        errors = np.maximum(step.points["error"][rows], LEAST)
        axes.plot(cost[rows], errors, mark, ms=4, color=colour, alpha=0.35, mew=0)
        best = rows[envelope(cost[rows], errors)]
        shown = np.maximum(step.points["error"][best], LEAST)
        order = slope(cost[best], shown, floor)
        text = f"{name}, slope {order:.1f}" if np.isfinite(order) else name
        handles += axes.plot(cost[best], shown, f"-{mark}", ms=5, color=colour, label=text)
        if x == "cpu":
            low, high = step.points["wall_low"][best], step.points["wall_high"][best]
            middle = step.points["wall"][best]
            spread = cost[best] / middle
            axes.errorbar(cost[best], shown, xerr=[(middle - low) * spread, (high - middle) * spread], fmt="none", ecolor=colour, lw=0.8)
    if floor > LEAST:
        axes.axhline(floor, color="#777777", lw=0.9, ls=":")
        axes.annotate("error of the reference", (0.99, floor), xycoords=("axes fraction", "data"), xytext=(0, 2), fontsize=7.5,
                      textcoords="offset points", ha="right", color="#555555")  # fmt: skip
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel({"cpu": "CPU time (s)", "n_unknowns": "unknowns", "n_steps": "steps", "memory": "memory (bytes)"}.get(x, x))
    names = ", ".join(map(label, step.meta["quantities"]))
    axes.set_ylabel(f"relative error of {names}" if len(names) < 40 else "largest relative error")
    return handles


def draw_distances(axes: Any, step: Step, title: str) -> None:
    """Draw Dist(n) of each chain on logarithmic axes with its order."""
    for (name, (n, distance, order)), colour, mark in zip(distances(step).items(), COLOURS, MARKS, strict=False):
        text = f"{name}: p = {order:.2f}" if np.isfinite(order) else name
        axes.plot(n, distance, f"-{mark}", ms=3.5, color=colour, label=text)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("N")
    axes.set_ylabel("Dist(N)")
    axes.set_title(title, fontsize=9.5)
    axes.legend(fontsize=8)


def draw_family(axes: Any, step: Step, x: str, y: str) -> None:
    """Draw the orbits of all chains, faint to full with n, and the delay equation's dashed over them."""
    i, j = (list(step.meta["states"]).index(name) for name in (x, y))
    chains = [k for k in range(len(step)) if step.points["n"][k] > 0 and np.isfinite(step.points["error"][k])]
    for shade, k in zip(np.linspace(0.15, 0.7, max(len(chains), 1)), sorted(chains, key=lambda k: step.points["n"][k]), strict=False):
        _closed(axes, step, k, i, j, color=COLOURS[0], alpha=float(shade), lw=0.8)
    reference = [k for k in range(len(step)) if family(step, k) == REFERENCE]
    for k in reference:
        _closed(axes, step, k, i, j, color=COLOURS[1], ls="--", lw=1.2)
    axes.set_xlabel(axis_label(step, x))
    axes.set_ylabel(axis_label(step, y))


def draw_enlarged(axes: Any, step: Step, x: str, y: str) -> None:
    """Draw the same near the first end of a segment of the delay equation's orbit."""
    draw_family(axes, step, x, y)
    states = step.orbit(0)["states"]
    i, j = (list(step.meta["states"]).index(name) for name in (x, y))
    end = step.meta["ends"][0]
    axes.plot(*np.array(step.meta["ends"])[:, [i, j]].T, "o", ms=4, color=COLOURS[1])
    for limits, k in ((axes.set_xlim, i), (axes.set_ylim, j)):
        half = ENLARGED * float(np.ptp(states[:, k]))
        limits(end[k] - half, end[k] + half)
    axes.set_title("enlarged, with the events", fontsize=9.5)


def _closed(axes: Any, step: Step, row: int, i: int, j: int, **style: Any) -> None:
    states = step.orbit(row)["states"]
    axes.plot(np.append(states[:, i], states[0, i]), np.append(states[:, j], states[0, j]), **style)


def varied(step: Step) -> Sequence[str]:
    """Return what errors can be drawn against: time, and unknowns of orbits or steps of simulations."""
    return ("cpu", "n_steps") if np.any(step.points["n_steps"] > 0) else ("cpu", "n_unknowns")
