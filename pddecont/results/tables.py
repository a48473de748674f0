"""Tidy tables of a results file: lists of rows, each a mapping from column to value."""

from __future__ import annotations

from typing import Any

import numpy as np

from pddecont.errors import ResultsError
from pddecont.results.reader import Step

Row = dict[str, Any]
TABLES = ("points", "special", "orbit", "trajectory", "events")


def table(step: Step, name: str, row: int | None = None) -> list[Row]:
    """Return a table of ``step``; ``row`` is the point whose orbit is wanted.

    Raises
    ------
    ResultsError
        If this kind of step has no such table.
    """
    kinds = {"points": ("orbit", "continue"), "special": ("orbit", "continue"), "orbit": ("orbit", "continue"),
             "trajectory": ("simulate",), "events": ("simulate",)}  # fmt: skip
    if step.kind not in kinds[name]:
        has = ", ".join(t for t in TABLES if step.kind in kinds[t])
        raise ResultsError(f"step '{step.name}' is a {step.kind} step and has no table '{name}' (it has: {has})")
    if name in ("points", "special"):
        rows = point_rows(step)
        return [r for r in rows if r["label"]] if name == "special" else rows
    return {"orbit": orbit_rows, "trajectory": trajectory_rows, "events": event_rows}[name](step, row or 0)


def point_rows(step: Step) -> list[Row]:
    """Return one row a point, in order along the branch."""
    rows = []
    p = step.points
    for i in step.order:
        row: Row = {"index": int(i), "label": step.labels[i], "kind": p["kind"][i].decode()}
        row |= {name: float(v) for name, v in zip(step.meta["parameters"], p["parameters"][i], strict=True)}
        row |= {"period": float(p["period"][i]), "stable": _truth(p["stable"][i]), "admissible": _truth(p["admissible"][i])}
        row |= {name: float(v) for name, v in zip(step.meta["monitors"], p["monitors"][i], strict=True)}
        row |= {"error_estimate": float(p["error_estimate"][i]), "n_unknowns": int(p["n_unknowns"][i])}
        rows.append(row)
    return rows


def orbit_rows(step: Step, i: int) -> list[Row]:
    """Return one row a time of the orbit of point ``i``."""
    if i >= len(step):
        raise ResultsError(f"step '{step.name}' has {len(step)} points, no index {i}")
    orbit = step.orbit(i)
    names = step.meta["states"]
    return [{"t": float(t), "segment": int(s) + 1, **dict(zip(names, map(float, z), strict=True))}
            for t, s, z in zip(orbit["time"], orbit["segment"], orbit["states"], strict=True)]  # fmt: skip


def trajectory_rows(step: Step, i: int) -> list[Row]:
    """Return one row a time of a trajectory."""
    rows = step.orbit(i)
    names, modes = step.meta["states"], step.meta["modes"]
    return [{"t": float(t), "mode": modes[m], **dict(zip(names, map(float, z), strict=True))}
            for t, m, z in zip(rows["time"], rows["mode"], rows["states"], strict=True)]  # fmt: skip


def event_rows(step: Step, i: int) -> list[Row]:
    """Return one row an event of a trajectory: states before the reset, and after it as ``NAME_after``."""
    rows = step.orbit(i)
    names, segments = step.meta["states"], step.meta["segments"]
    return [{"t": float(t), "segment": segments[s], **dict(zip(names, map(float, a), strict=True)),
             **{f"{name}_after": float(v) for name, v in zip(names, b, strict=True)}}
            for t, s, a, b in zip(rows["event_time"], rows["event_segment"], rows["before"], rows["after"], strict=True)]  # fmt: skip


def _truth(value: np.int8) -> bool | None:
    return None if value < 0 else bool(value)
