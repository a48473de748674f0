"""What a ``precision`` step measured: tables, the cheapest settings, slopes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pddecont.results import Step
from pddecont.tables.words import describe_reason

Array = NDArray[np.float64]
Row = dict[str, Any]
LEVELS = (1e-3, 1e-6, 1e-9)
REFERENCE = "reference"
# Errors nearer to the reference's own than this say nothing.
BEYOND = 3.0


def list_settings(step: Step) -> list[Row]:
    """Return one row a setting, the reference first."""
    p, names = step.points, step.meta["quantities"]
    plain = ("degree", "intervals", "n", "n_intervals", "n_unknowns", "n_iterations", "n_steps", "memory")
    rows = []
    for i in range(len(step)):
        row: Row = {"index": i, "method": name_method(step, i), "setting": describe_setting(step, i)}
        row |= {name: int(p[name][i]) for name in plain}
        row |= {"tolerance": float(p["tolerance"][i])}
        row |= {name: float(v) for name, v in zip(names, p["values"][i], strict=True)}
        row |= {f"{name}_error": float(v) for name, v in zip(names, p["errors"][i], strict=True)}
        row |= {name: float(p[name][i]) for name in ("error", "distance", "wall", "wall_low", "wall_high", "cpu")}
        rows.append({**row, "note": describe_reason(step.reason(i))})
    return rows


def name_method(step: Step, i: int) -> str:
    """Return the method of a row in words."""
    p = step.points
    method, order = str(p["method"][i].decode()), int(p["order"][i])
    name = f"chain of order {order}" if method == "chain" else method
    if method == "direct" and not p["tracked"][i]:
        return f"{name}, not tracked"
    return f"{name}, explicit states" if p["explicit"][i] else name


def describe_setting(step: Step, i: int) -> str:
    """Return a row's setting in words: method, number of stages, degree, mesh; or the integrator's tolerance."""
    p, method = step.points, name_method(step, i)
    degree, tolerance, n = int(p["degree"][i]), float(p["tolerance"][i]), int(p["n"][i])
    if method == REFERENCE:
        return f"{REFERENCE}: direct, degree {degree}" if degree else f"{REFERENCE}, tolerance {tolerance:g}"
    if not degree:
        return f"{method}, tolerance {tolerance:g}"
    mesh = f"{p['intervals'][i]} intervals" if p["intervals"][i] else f"tolerance {tolerance:g}"
    return f"{method}{f' with n = {n}' if n else ''}, degree {degree}, {mesh}"


def list_methods(step: Step) -> list[str]:
    """Return the methods compared, in order."""
    names = dict.fromkeys(name_method(step, i) for i in range(len(step)))
    return [name for name in names if name != REFERENCE]


def find_rows(step: Step, method: str) -> NDArray[np.intp]:
    """Return the rows of one method that have an error."""
    with_error = np.flatnonzero(np.isfinite(step.points["error"]))
    return np.array([i for i in with_error if name_method(step, int(i)) == method], dtype=np.intp)


def read_reference_error(step: Step) -> float:
    """Return the error of the reference itself: smaller errors cannot be measured."""
    return float(step.points["error"][0])


def describe_reference(step: Step) -> str:
    """Return in words where the reference comes from and how good it is."""
    names, errors = list(step.meta["quantities"]), step.points["errors"][0]
    closed = np.array([name in step.meta["closed"] for name in names], dtype=bool)

    def describe_worst(which: NDArray[np.bool_]) -> str:
        listed = ", ".join(name for name, chosen in zip(names, which, strict=True) if chosen)
        return f"{listed}: {np.max(errors[which]):.1e}"

    parts = [f"closed forms (the finest solution differs by {describe_worst(closed)})"] if np.any(closed) else []
    if not np.all(closed):
        parts.append(f"the finest solution (two meshes differ by {describe_worst(~closed)})")
    return " and ".join(parts)


def find_cheapest(step: Step, level: float) -> int | None:
    """Return the row that reaches an error of ``level`` in the least CPU time (None: none does)."""
    rows = [i for i in range(1, len(step)) if step.points["error"][i] <= level]
    return min(rows, key=lambda i: float(step.points["cpu"][i]), default=None)


def describe_cheapest(step: Step) -> list[str]:
    """Return for each of the usual levels the cheapest setting that reaches it, in words."""
    lines = []
    for level in LEVELS:
        i = find_cheapest(step, level)
        if read_reference_error(step) > level:
            lines.append(f"{level:.0e}: the reference itself is known to {read_reference_error(step):.1e} only")
        elif i is None:
            lines.append(f"{level:.0e}: reached by none")
        else:
            lines.append(
                f"{level:.0e}: {describe_setting(step, i)}, {1e3 * step.points['cpu'][i]:.3g} ms of CPU time "
                f"(error {step.points['error'][i]:.1e})"
            )
    return lines


def find_envelope(x: Array, errors: Array) -> NDArray[np.intp]:
    """Return the points, in order of ``x``, whose error no point with a smaller ``x`` reaches."""
    best, kept = np.inf, []
    for i in np.lexsort((errors, x)):
        if errors[i] < best:
            best = float(errors[i])
            kept.append(int(i))
    return np.array(kept, dtype=np.intp)


def fit_slope(x: ArrayLike, errors: ArrayLike, floor: float) -> float:
    """Return the slope of log error against log ``x`` by least squares, of points whose error lies above ``floor``.

    It is NaN if there are fewer than three.
    """
    at, values = np.asarray(x, dtype=float), np.asarray(errors, dtype=float)
    clear = values > BEYOND * floor
    if np.sum(clear) < 3 or np.ptp(at[clear]) == 0.0:
        return float("nan")
    return float(np.polyfit(np.log(at[clear]), np.log(values[clear]), 1)[0])


def measure_distances(step: Step) -> dict[str, tuple[Array, Array, float]]:
    """Return (n, Dist(n), order) of each chain whose n varies, on its finest mesh (the paper's eq. (4.1)).

    The order is that of the upper half of the n on a logarithmic scale, three at least: for small n it is not yet what
    it comes to.
    """
    found = {}
    p = step.points
    for name in list_methods(step):
        rows = find_rows(step, name)
        rows = rows[(p["n"][rows] > 0) & np.isfinite(p["distance"][rows])]
        if len(np.unique(p["n"][rows])) < 3:
            continue
        n = np.unique(p["n"][rows])
        finest = np.array([max(rows[p["n"][rows] == k], key=lambda i: (p["degree"][i], p["n_unknowns"][i])) for k in n])
        distance = p["distance"][finest]
        upper = n >= min(np.sqrt(n[0] * n[-1]), n[-3])
        found[name] = (n.astype(float), distance, -fit_slope(n[upper], distance[upper], 0.0))
    return found
