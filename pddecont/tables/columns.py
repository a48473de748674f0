"""Points of any kind of step, column by column: for kinds that nobody made tables for."""

from __future__ import annotations

from typing import Any

from pddecont.results import Axis, Step
from pddecont.tables.words import describe_reason

Row = dict[str, Any]


def list_columns(step: Step) -> list[Row]:
    """Return one row a point with its label, its numbers and its note; arrays are columns of their own."""
    rows = []
    for i in step.order:
        row: Row = {"index": int(i), "label": step.labels[i]}
        for name, column in step.format.points.items():
            if name in step.points:
                row |= _flatten(step, name, column.axes, step.points[name][i])
        rows.append({**row, "note": describe_reason(step.reason(int(i)))})
    return rows


def _flatten(step: Step, name: str, axes: tuple[Axis, ...], value: Any) -> Row:
    """Return a value by the names of what it has one of, or by numbers."""
    if not axes:
        return {name: value.decode(errors="replace") if isinstance(value, bytes) else value.item()}
    if len(axes) == 1 and isinstance(axes[0], str):
        names = step.meta[axes[0]]
        prefix = "" if axes[0] in ("parameters", "monitors") else f"{name}_"
        return {f"{prefix}{n}": v.item() for n, v in zip(names, value, strict=True)}
    return {f"{name}_{k}": v.item() for k, v in enumerate(value.ravel())}
