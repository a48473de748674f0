"""Tables of a report."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

from pddecont.results.reader import Step
from pddecont.results.summary import WORDS
from pddecont.results.tables import table

Row = Mapping[str, Any]
# Rows beyond these are left to 'pddecont export'.
MAX_ROWS = 200
SPECIAL = {"orbit": "points", "continue": "special", "sweep": "points", "basin": "points", "precision": "precision"}


def special_tables(step: Step) -> Iterator[tuple[str, list[Row]]]:
    """Return each table of a step with its title: special points, attractors or settings; parameters that do not vary by themselves."""
    if not len(step):
        return
    if step.kind not in SPECIAL:
        names, values = step.meta["parameters"], step.points["parameters"][0]
        yield "Parameters", [dict(zip(names, map(float, values), strict=True))]
        return
    rows = [dict(row) for row in table(step, SPECIAL[step.kind])]
    if not rows:
        return
    fixed = {name: rows[0][name] for name in step.meta["parameters"] if name in rows[0] and _same([row[name] for row in rows])}
    for row in rows:
        for name in fixed:
            del row[name]
        if "kind" in row:
            row["kind"] = WORDS.get(row["kind"], row["kind"])
    empty = {key for key in rows[0] if all(row[key] in (None, "") for row in rows)}
    title = {"special": "Special points", "precision": "Settings compared"}.get(SPECIAL[step.kind], "Points")
    yield title, [{k: v for k, v in row.items() if k not in empty} for row in rows]
    if fixed:
        yield "Other parameters", [fixed]


def _same(values: Sequence[float]) -> bool:
    return bool(np.ptp(values) <= 1e-12 * max(map(abs, values)))


def html_table(rows: Sequence[Row], links: Mapping[str, str] | None = None) -> str:
    """Return rows as an HTML table; a text of ``links`` in the first column leads to its place."""
    if not rows:
        return ""
    lines = ["<table>", "<tr>" + "".join(f"<th>{escape(str(name))}</th>" for name in rows[0]) + "</tr>"]
    for row in rows[:MAX_ROWS]:
        cells = [_cell(value) for value in row.values()]
        first = str(next(iter(row.values())))
        if links and first in links:
            cells[0] = f'<td><a href="{escape(links[first])}">{escape(first)}</a></td>'
        lines.append(f"<tr>{''.join(cells)}</tr>")
    lines.append("</table>")
    if len(rows) > MAX_ROWS:
        lines.append(f"<p>{len(rows) - MAX_ROWS} more rows: see 'pddecont export'.</p>")
    return "\n".join(lines)


def _cell(value: Any) -> str:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return f'<td class="number">{written(value)}</td>' if number else f"<td>{written(value)}</td>"


def written(value: Any) -> str:
    """Return a value as escaped text: numbers to eight digits, what is not known as nothing."""
    if value is None or (isinstance(value, float) and np.isnan(value)):
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return escape(f"{value:.8g}")
    if isinstance(value, dict):
        return "; ".join(f"{escape(str(k))} {written(v)}" for k, v in value.items())
    if isinstance(value, list | tuple):
        return ", ".join(map(written, value))
    return escape(str(value)).replace("\n", "<br>")


def listed(values: Row) -> str:
    """Return names and values as a description list."""
    shown = {name.replace("_", " "): text for name, value in values.items() if (text := written(value))}
    items = "".join(f"<dt>{escape(name)}</dt><dd>{text}</dd>" for name, text in shown.items())
    return f"<dl>{items}</dl>" if items else ""
