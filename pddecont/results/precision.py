"""What a ``precision`` step measured: tables, the cheapest settings, slopes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.results.reader import Step

Array = NDArray[np.float64]
LEVELS = (1e-3, 1e-6, 1e-9)
REFERENCE = "reference"
# Errors nearer to the reference's own than this say nothing.
BEYOND = 3.0


def precision_rows(step: Step) -> list[dict[str, Any]]:
    """Return one row a setting, the reference first."""
    p, names = step.points, step.meta["quantities"]
    plain = ("degree", "intervals", "n", "n_intervals", "n_unknowns", "n_iterations", "n_steps", "memory")
    rows = []
    for i in range(len(step)):
        row: dict[str, Any] = {"index": i, "method": family(step, i), "setting": setting(step, i)}
        row |= {name: int(p[name][i]) for name in plain}
        row |= {"tolerance": float(p["tolerance"][i])}
        row |= {name: float(v) for name, v in zip(names, p["values"][i], strict=True)}
        row |= {f"{name}_error": float(v) for name, v in zip(names, p["errors"][i], strict=True)}
        row |= {name: float(p[name][i]) for name in ("error", "distance", "wall", "wall_low", "wall_high", "cpu")}
        rows.append({**row, "note": p["note"][i].decode(errors="replace")})
    return rows


def family(step: Step, i: int) -> str:
    """Return the method of a row."""
    return step.points["family"][i].decode()


def setting(step: Step, i: int) -> str:
    """Return a row's setting in words."""
    return step.points["setting"][i].decode()


def families(step: Step) -> list[str]:
    """Return the methods compared, in order."""
    return [f for f in dict.fromkeys(family(step, i) for i in range(len(step))) if f != REFERENCE]


def rows_of(step: Step, name: str) -> NDArray[np.intp]:
    """Return the rows of one method that have an error."""
    return np.array([i for i in range(len(step)) if family(step, i) == name and np.isfinite(step.points["error"][i])], dtype=np.intp)


def reference_error(step: Step) -> float:
    """Return the error of the reference itself: no smaller error can be told."""
    return float(step.points["error"][0])


def cheapest(step: Step, level: float) -> int | None:
    """Return the row that reaches an error of ``level`` in the least CPU time (None: none does)."""
    rows = [i for i in range(1, len(step)) if step.points["error"][i] <= level]
    return min(rows, key=lambda i: float(step.points["cpu"][i]), default=None)


def cheapest_lines(step: Step) -> list[str]:
    """Return for each of the usual levels the cheapest setting that reaches it, in words."""
    lines = []
    for level in LEVELS:
        i = cheapest(step, level)
        if reference_error(step) > level:
            lines.append(f"{level:.0e}: the reference itself is known to {reference_error(step):.1e} only")
        elif i is None:
            lines.append(f"{level:.0e}: reached by none")
        else:
            lines.append(f"{level:.0e}: {setting(step, i)}, {1e3 * step.points['cpu'][i]:.3g} ms of CPU time "
                         f"(error {step.points['error'][i]:.1e})")  # fmt: skip
    return lines


def cheapest_text(step: Step) -> str:
    """Return the cheapest setting for the middle level, in words."""
    return f"cheapest for {cheapest_lines(step)[1]}"


def envelope(x: Array, errors: Array) -> NDArray[np.intp]:
    """Return the points, in order of ``x``, whose error no point with a smaller ``x`` reaches."""
    best, kept = np.inf, []
    for i in np.lexsort((errors, x)):
        if errors[i] < best:
            best = float(errors[i])
            kept.append(int(i))
    return np.array(kept, dtype=np.intp)


def slope(x: Sequence[float] | Array, errors: Sequence[float] | Array, floor: float) -> float:
    """Return the slope of log error against log ``x`` by least squares, of points whose error lies above ``floor``; NaN if under three."""
    x, errors = np.asarray(x, dtype=float), np.asarray(errors, dtype=float)
    clear = errors > BEYOND * floor
    if np.sum(clear) < 3 or np.ptp(x[clear]) == 0.0:
        return float("nan")
    return float(np.polyfit(np.log(x[clear]), np.log(errors[clear]), 1)[0])


def distances(step: Step) -> dict[str, tuple[Array, Array, float]]:
    """Return (n, Dist(n), order) of each chain whose n varies, on its finest mesh (the paper's eq. (4.1)).

    The order is that of the upper half of the n on a logarithmic scale, three at least: for small n it is not yet what it comes to.
    """
    found = {}
    p = step.points
    for name in families(step):
        rows = rows_of(step, name)
        rows = rows[(p["n"][rows] > 0) & np.isfinite(p["distance"][rows])]
        if len(np.unique(p["n"][rows])) < 3:
            continue
        n = np.unique(p["n"][rows])
        finest = np.array([max(rows[p["n"][rows] == k], key=lambda i: (p["degree"][i], p["n_unknowns"][i])) for k in n])
        distance = p["distance"][finest]
        upper = n >= min(np.sqrt(n[0] * n[-1]), n[-3])
        found[name] = (n.astype(float), distance, -slope(n[upper], distance[upper], 0.0))
    return found
