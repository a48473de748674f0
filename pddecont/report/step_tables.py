"""Tables of a report, and how it writes values."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from pddecont.results import Step
from pddecont.tables import find_main_table, make_table, name_kind

Row = Mapping[str, Any]
# The tables of a kind of step that a report shows, and their titles, where that is not the main one alone. Of
# simulations, whose main table is long, it shows the parameters.
SHOWN_TABLES = {
    "continue": [("special", "Special points")],
    "equilibria": [("special", "Special points")],
    "equilibrium": [("points", "Equilibria"), ("roots", "Characteristic roots")],
    "explore": [("branches", "Branches"), ("unexplained", "Motions that lie on no branch")],
    "precision": [("precision", "Settings compared")],
}
WITHOUT_TABLE = ("simulate",)
# Values of a parameter that differ by less than this share of it are one.
ROUNDING = 1e-12


def build_tables(step: Step) -> Iterator[tuple[str, list[Row]]]:
    """Yield each table of a step with its title: special points, attractors or settings, then parameters that stay."""
    if not len(step):
        return
    if step.kind in WITHOUT_TABLE:
        names, values = step.meta["parameters"], step.points["parameters"][0]
        yield "Parameters", [dict(zip(names, map(float, values), strict=True))]
        return
    for name, title in SHOWN_TABLES.get(step.kind, [(find_main_table(step.kind), "Points")]):
        yield from _build_table(step, title, make_table(step, name))


def _build_table(step: Step, title: str, rows: Sequence[Row]) -> Iterator[tuple[str, list[Row]]]:
    if not rows:
        return
    fixed = {key: rows[0][key] for key in step.meta.get("parameters", ()) if key in rows[0] and _stays(rows, key)}
    left_out = {key for key in rows[0] if key in fixed or not any(format_value(row[key]) for row in rows)}
    yield title, [{key: _describe(step, key, v) for key, v in row.items() if key not in left_out} for row in rows]
    if fixed:
        yield "Other parameters", [fixed]


def format_value(value: Any) -> str:
    """Return a value as text: numbers to eight digits, what is not known as nothing."""
    if value is None or (isinstance(value, float) and np.isnan(value)):
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.8g}"
    if isinstance(value, dict):
        return "; ".join(f"{key} {format_value(item)}" for key, item in value.items())
    if isinstance(value, list | tuple):
        return ", ".join(map(format_value, value))
    return str(value)


def is_number(value: Any) -> bool:
    """Return whether a value is aligned with others below it."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def _stays(rows: Sequence[Row], name: str) -> bool:
    values = [row[name] for row in rows]
    return bool(np.ptp(values) <= ROUNDING * max(map(abs, values)))


def _describe(step: Step, name: str, value: Any) -> Any:
    """Return a value as it is, but a kind of special point in words."""
    return name_kind(step, value) if name == "kind" else value
