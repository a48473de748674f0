"""Attractors of sweep and basin steps as tables: who they are, their returns, who goes where."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.results.reader import Step

Row = dict[str, Any]
Z95 = 1.959963984540054


def class_of(step: Step, i: int) -> str:
    """Return in words what kind of motion a row is."""
    if not step.labels[i]:
        return "none"
    return motion_class(int(step.points["period"][i]), step.points["n_segments"][i], step.meta["segments"])


def motion_class(period: int, counts: Sequence[int] | NDArray[np.int64], segments: Sequence[str]) -> str:
    """Return in words what kind a motion is: its period in returns and how often each segment comes in one period."""
    if not period:
        return "no period"
    return ", ".join([f"period {period}", *(f"{n} {name}" for n, name in zip(counts, segments, strict=True) if n)])


def attractor_rows(step: Step) -> list[Row]:
    """Return one row an attractor (and one a motion that failed), in the order of the parameters."""
    is_basin = step.kind == "basin"
    shares = basin_shares(step) if is_basin else {}
    rows = []
    for i in found(step):
        p = step.points
        row: Row = {"index": int(i), "label": step.labels[i]}
        row |= {name: float(v) for name, v in zip(step.meta["parameters"], p["parameters"][i], strict=True)}
        row |= {"period": int(p["period"][i]) or None, "turn": float(p["turn"][i])}
        row |= {f"n_{name}": int(n) for name, n in zip(step.meta["segments"], p["n_segments"][i], strict=True)}
        if is_basin:
            row |= dict(zip(("share", "share_low", "share_high"), shares[int(i)], strict=True))
        else:
            row |= {"direction": ("down", "", "up")[int(p["direction"][i]) + 1], "share": float(p["share"][i])}
        row |= {"lyapunov": float(p["lyapunov"][i]), "lyapunov_error": float(p["lyapunov_error"][i]),
                "note": p["note"][i].decode(errors="replace")}  # fmt: skip
        rows.append(row)
    return rows


def return_rows(step: Step) -> list[Row]:
    """Return one row a return to the section: the attractor's label, its parameters, the states."""
    rows = []
    for i in found(step):
        named = {name: float(v) for name, v in zip(step.meta["parameters"], step.points["parameters"][i], strict=True)}
        for t, z in zip(step.orbit(int(i))["return_time"], step.orbit(int(i))["returns"], strict=True):
            rows.append({"index": int(i), "label": step.labels[i], **named, "t": float(t),
                         **dict(zip(step.meta["states"], map(float, z), strict=True))})  # fmt: skip
    return rows


def cell_rows(step: Step) -> list[Row]:
    """Return one row an initial state of a basin: the attractor's label (empty: none) and the time after which it was recognised."""
    (x, y), names = step.meta["over"], label_names(step)
    xs, ys = step.meta["x"], step.meta["y"]
    settling = settling_times(step)
    return [{x: xs[i], y: ys[j], "label": names[k], "settling": float(settling[j, i])}
            for j, line in enumerate(label_map(step)) for i, k in enumerate(line)]  # fmt: skip


def found(step: Step) -> NDArray[np.intp]:
    """Return the rows that are attractors or motions that failed, in the order of the parameter points."""
    if step.kind == "basin":
        return np.flatnonzero(step.points["line"] < 0)
    return np.argsort(step.points["cell"], kind="stable")


def label_map(step: Step) -> NDArray[np.int64]:
    """Return the number of the attractor of each initial state of a basin, shape (n_lines, n_columns): numbers of :func:`found`."""
    return step.orbits["label"].reshape(-1, len(step.meta["x"])).astype(np.int64)


def settling_times(step: Step) -> NDArray[np.float64]:
    """Return the time after which each motion of a basin was recognised, shape (n_lines, n_columns)."""
    return step.orbits["settling"].reshape(-1, len(step.meta["x"]))


def label_names(step: Step) -> list[str]:
    """Return the label of each number in :func:`label_map`."""
    return [step.labels[i] for i in found(step)]


def basin_shares(step: Step) -> dict[int, tuple[float, float, float]]:
    """Return for each row of an attractor the share of the initial states that lead to it, and its 95 % confidence interval.

    The interval is Wilson's (J. Am. Stat. Assoc. 22, 1927), with each initial state as a sample of the rectangle.
    """
    rows = found(step)
    counts = np.bincount(label_map(step).ravel(), minlength=len(rows))
    total = max(1, int(counts.sum()))
    return {int(row): (int(n) / total, *wilson(int(n), total)) for row, n in zip(rows, counts, strict=True)}


def wilson(count: int, total: int) -> tuple[float, float]:
    """Return the 95 % confidence interval of a share."""
    share, spread = count / total, Z95**2 / total
    middle = (share + spread / 2) / (1 + spread)
    half = Z95 / (1 + spread) * np.sqrt(share * (1 - share) / total + spread / (4 * total))
    return float(max(0.0, middle - half)), float(min(1.0, middle + half))
