"""Tidy tables of a results file: lists of rows, each a mapping from column to value."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ResultsError, suggest
from pddecont.results.attractors import attractor_rows, cell_rows, return_rows
from pddecont.results.precision import precision_rows
from pddecont.results.reader import Step

Row = dict[str, Any]
ORBITS, ATTRACTORS = ("orbit", "continue"), ("sweep", "basin")
# The steps that have each table.
TABLES = {"points": (*ORBITS, *ATTRACTORS), "special": ORBITS, "orbit": ORBITS, "multipliers": ORBITS, "trajectory": ("simulate",),
          "events": ("simulate",), "precision": ("precision",), "returns": ATTRACTORS, "cells": ("basin",)}  # fmt: skip


def table(step: Step, name: str, row: int | None = None) -> list[Row]:
    """Return a table of ``step``; ``row`` is the point whose orbit, or whose multipliers, are wanted.

    Raises
    ------
    ResultsError
        If there is no such table, or none of this kind of step, or the step no such point, or its multipliers were not computed.
    """
    if step.kind not in TABLES.get(name, ()):
        has = [t for t, kinds in TABLES.items() if step.kind in kinds]
        raise ResultsError(f"step '{step.name}' is a {step.kind} step and has no table '{name}'{suggest(str(name), has)} "
                           f"(it has: {', '.join(has)})")  # fmt: skip
    if step.kind in ATTRACTORS:
        return {"points": attractor_rows, "returns": return_rows, "cells": cell_rows}[name](step)
    if name in ("points", "special"):
        rows = point_rows(step)
        return [r for r in rows if r["label"]] if name == "special" else rows
    if name == "multipliers":
        return multiplier_rows(step, row)
    if name == "precision":
        return precision_rows(step)
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
        row |= {"error_estimate": float(p["error_estimate"][i]), "n_unstable": _count(step, i), "note": note(step, i)}
        row |= {"n_unknowns": int(p["n_unknowns"][i])}
        rows.append(row)
    return rows


def orbit_rows(step: Step, i: int) -> list[Row]:
    """Return one row a time of the orbit of point ``i``."""
    _check(step, i)
    orbit = step.orbit(i)
    names = step.meta["states"]
    return [{"t": float(t), "segment": int(s) + 1, **dict(zip(names, map(float, z), strict=True))}
            for t, s, z in zip(orbit["time"], orbit["segment"], orbit["states"], strict=True)]  # fmt: skip


def multiplier_rows(step: Step, row: int | None = None) -> list[Row]:
    """Return one row a Floquet multiplier, by falling modulus: of all points in order along the branch, or of one."""
    if row is not None:
        _check(step, row)
    if not has_multipliers(step):
        raise ResultsError(f"step '{step.name}' has no multipliers; run it with 'stability: true'")
    free = [(name, list(step.meta["parameters"]).index(name)) for name in step.meta.get("free") or []]
    rows = []
    for i in step.order if row is None else [row]:
        values = {name: float(step.points["parameters"][i, k]) for name, k in free}
        for number, value in enumerate(multipliers(step, int(i)), 1):
            rows.append({"index": int(i), "label": step.labels[i], **values, "number": number, "multiplier": complex(value),
                         "modulus": float(abs(value))})  # fmt: skip
    return rows


def has_multipliers(step: Step) -> bool:
    """Return whether multipliers were computed for any point."""
    return len(step.orbits.get("multipliers", ())) > 0


def multipliers(step: Step, i: int) -> NDArray[np.complex128]:
    """Return the multipliers of point ``i``, by falling modulus; shape (0,) if they were not computed."""
    if "multipliers" not in step.orbits:
        return np.empty(0, dtype=complex)
    pairs = step.orbit(i)["multipliers"]
    return pairs[:, 0] + 1j * pairs[:, 1]


def note(step: Step, i: int) -> str:
    """Return what the note of point ``i`` says; empty if it has none."""
    return step.points["note"][i].decode(errors="replace") if "note" in step.points else ""


def trajectory_rows(step: Step, i: int) -> list[Row]:
    """Return one row a time of a trajectory."""
    rows = step.orbit(i)
    names, modes = [*step.meta["states"], *step.meta.get("signals", [])], step.meta["modes"]
    values = np.hstack([rows["states"], rows["signals"]]) if "signals" in rows else rows["states"]
    return [{"t": float(t), "mode": modes[m], **dict(zip(names, map(float, z), strict=True))}
            for t, m, z in zip(rows["time"], rows["mode"], values, strict=True)]  # fmt: skip


def event_rows(step: Step, i: int) -> list[Row]:
    """Return one row an event of a trajectory: states before the reset, and after it as ``NAME_after``."""
    rows = step.orbit(i)
    names, segments = step.meta["states"], step.meta["segments"]
    return [{"t": float(t), "segment": segments[s], **dict(zip(names, map(float, a), strict=True)),
             **{f"{name}_after": float(v) for name, v in zip(names, b, strict=True)}}
            for t, s, a, b in zip(rows["event_time"], rows["event_segment"], rows["before"], rows["after"], strict=True)]  # fmt: skip


def _check(step: Step, i: int) -> None:
    if not 0 <= i < len(step):
        raise ResultsError(f"step '{step.name}' has {len(step)} points, no index {i}")


def _count(step: Step, i: int) -> int | None:
    value = int(step.points["n_unstable"][i]) if "n_unstable" in step.points else -1
    return None if value < 0 else value


def _truth(value: np.int8) -> bool | None:
    return None if value < 0 else bool(value)
