"""Attractors of sweep and basin steps as tables: who they are, their returns, who goes where."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.results import Step
from pddecont.tables.words import describe_reason

Row = dict[str, Any]
CONFIDENCE = 0.95
# Names of the values of ``direction``, which counts from -1.
DIRECTIONS = ("down", "", "up")


def name_motion(step: Step, row: int) -> str:
    """Return in words what kind of motion a row is: its period in returns, and each segment's number in one period."""
    if not step.labels[row]:
        return "none"
    return describe_motion(
        int(step.points["period"][row]), step.points["n_segments"][row].tolist(), step.meta["segments"]
    )


def describe_motion(period: int, counts: Sequence[int], segments: Sequence[str]) -> str:
    """Return in words what kind of motion has a period in returns and so many of each segment in one period."""
    if not period:
        return "no period"
    return ", ".join([f"period {period}", *(f"{n} {name}" for n, name in zip(counts, segments, strict=True) if n)])


def list_attractors(step: Step) -> list[Row]:
    """Return one row an attractor (and one a motion that failed), in the order of the parameters."""
    is_basin = step.kind == "basin"
    shares = estimate_shares(step) if is_basin else {}
    rows = []
    for i in find_attractors(step):
        p = step.points
        row: Row = {"index": int(i), "label": step.labels[i]}
        row |= {name: float(v) for name, v in zip(step.meta["parameters"], p["parameters"][i], strict=True)}
        row |= {"period": int(p["period"][i]) or None, "turn": float(p["turn"][i])}
        row |= {f"n_{name}": int(n) for name, n in zip(step.meta["segments"], p["n_segments"][i], strict=True)}
        if is_basin:
            row |= dict(zip(("share", "share_low", "share_high"), shares[int(i)], strict=True))
        else:
            row |= {"direction": DIRECTIONS[int(p["direction"][i]) + 1], "share": float(p["share"][i])}
        row |= {
            "lyapunov": float(p["lyapunov"][i]),
            "lyapunov_error": float(p["lyapunov_error"][i]),
            "note": describe_reason(step.reason(int(i))),
        }
        rows.append(row)
    return rows


def list_returns(step: Step) -> list[Row]:
    """Return one row a return to the section: the attractor's label, its parameters, the states."""
    rows = []
    for i in find_attractors(step):
        values = {n: float(v) for n, v in zip(step.meta["parameters"], step.points["parameters"][i], strict=True)}
        orbit = step.orbit(int(i))
        for t, z in zip(orbit["return_time"], orbit["returns"], strict=True):
            states = dict(zip(step.meta["states"], map(float, z), strict=True))
            rows.append({"index": int(i), "label": step.labels[i], **values, "t": float(t), **states})
    return rows


def list_cells(step: Step) -> list[Row]:
    """Return one row an initial state of a basin: its attractor's label, and the time after which that was detected.

    The label is empty where the motion came to none.
    """
    (x, y), names = step.meta["over"], name_attractors(step)
    xs, ys = step.meta["x"], step.meta["y"]
    settling = read_settling_times(step)
    return [
        {x: xs[i], y: ys[j], "label": names[k], "settling": float(settling[j, i])}
        for j, line in enumerate(read_label_map(step))
        for i, k in enumerate(line)
    ]


def find_attractors(step: Step) -> NDArray[np.intp]:
    """Return the rows that are attractors or motions that failed, in the order of the parameter points."""
    if step.kind == "basin":
        return np.flatnonzero(step.points["line"] < 0)
    return np.argsort(step.points["cell"], kind="stable")


def read_label_map(step: Step) -> NDArray[np.int64]:
    """Return the attractor of each initial state of a basin, shape (n_lines, n_columns).

    Numbers count the rows that :func:`find_attractors` returns.
    """
    return np.asarray(step.orbits["label"].reshape(-1, len(step.meta["x"])).astype(np.int64))


def read_settling_times(step: Step) -> NDArray[np.float64]:
    """Return the time after which each motion of a basin was known, shape (n_lines, n_columns)."""
    return np.asarray(step.orbits["settling"].reshape(-1, len(step.meta["x"])))


def name_attractors(step: Step) -> list[str]:
    """Return the label of each number in :func:`read_label_map`."""
    return [step.labels[i] for i in find_attractors(step)]


def estimate_shares(step: Step) -> dict[int, tuple[float, float, float]]:
    """Return for each row of an attractor the share of the initial states that lead to it, with a confidence interval.

    The interval is Wilson's for 95 % (J. Am. Stat. Assoc. 22, 1927, 209), each initial state being a sample of the
    rectangle.
    """
    rows = find_attractors(step)
    counts = np.bincount(read_label_map(step).ravel(), minlength=len(rows))
    total = max(1, int(counts.sum()))
    return {int(row): _estimate_share(int(n), total) for row, n in zip(rows, counts, strict=True)}


def _estimate_share(count: int, total: int) -> tuple[float, float, float]:
    # Loading it takes a third of a second, which tables of anything else need not wait for.
    from scipy.stats import binomtest

    interval = binomtest(count, total).proportion_ci(CONFIDENCE, method="wilson")
    return count / total, float(interval.low), float(interval.high)
