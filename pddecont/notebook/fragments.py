"""Results as pieces of HTML, as notebooks show them: titles, tables and pictures.

All text comes from files, which may come from anybody: the template escapes it, and pictures are images, in which
nothing runs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from jinja2 import Environment

from pddecont.plot import ViewRequest, list_views
from pddecont.report import Picture, draw_picture, format_value, make_environment
from pddecont.results import Results, Step
from pddecont.tables import describe_endings, find_main_table, find_unit, make_table, summarise_step

Row = Mapping[str, Any]
# Rows beyond these are counted.
MAX_ROWS = 12
# Tables that say most of a kind of step in few rows, where that is not its main one.
SHORT_TABLES = {"continue": "special", "equilibria": "special"}


def render_results(results: Results, title: str) -> str:
    """Return the steps of a results file as a table, with the picture that suits the file where there is one."""
    rows = [_list_contents(step) for step in results.steps.values()]
    return _render(title, rows=rows, picture=_draw(results, ViewRequest(), title))


def render_step(results: Results, step: Step, title: str) -> str:
    """Return how a step ended, its most telling table, and its picture."""
    name = SHORT_TABLES.get(step.kind, find_main_table(step.kind))
    found = make_table(step, name, 0 if step.kind == "simulate" else None) if len(step) else []
    rows = _leave_out_fixed(step, found)
    picture = _draw(results, ViewRequest(steps=(step.name,)), step.name) if list_views(step) else None
    return _render(title, describe_endings(step), rows, _find_units(step, name, rows), picture)


def render_rows(step: Step, name: str, rows: Sequence[Row], title: str) -> str:
    """Return rows of a table of ``step``."""
    return _render(title, rows=rows, units=_find_units(step, name, rows))


def render_facts(
    results: Results, step: Step, facts: Row, title: str, note: str = "", request: ViewRequest | None = None
) -> str:
    """Return one row of a step with its picture, where ``request`` asks for one that can be drawn."""
    picture = _draw(results, request, title) if request is not None else None
    return _render(title, [note] if note else [], [facts], _find_units(step, "points", [facts]), picture)


def _render(
    title: str,
    lines: Sequence[str] = (),
    rows: Sequence[Row] = (),
    units: Mapping[str, str] | None = None,
    picture: Picture | None = None,
) -> str:
    return (
        _load_environment()
        .get_template("fragment.html")
        .render(
            title=title, lines=lines, rows=_leave_out_empty(rows), units=units or {}, picture=picture, max_rows=MAX_ROWS
        )
    )


@cache
def _load_environment() -> Environment:
    return make_environment("pddecont.notebook")


def _list_contents(step: Step) -> Row:
    return {
        "step": step.name,
        "kind": step.kind,
        "points": len(step),
        "special points": ", ".join(summarise_step(step)["special"]),
        "ended": "; ".join(describe_endings(step)) or "not finished",
    }


def _leave_out_empty(rows: Sequence[Row]) -> list[Row]:
    """Return rows without the columns in which nothing is known."""
    kept = [name for name in (rows[0] if rows else ()) if any(format_value(row[name]) for row in rows)]
    return [{name: row[name] for name in kept} for row in rows]


def _leave_out_fixed(step: Step, rows: Sequence[Row]) -> list[Row]:
    """Return rows without parameters that have one value in all of them, if there are several rows."""
    names = [name for name in step.meta.get("parameters", ()) if len(rows) > 1 and name in rows[0]]
    fixed = {name for name in names if len({row[name] for row in rows}) == 1}
    return [{name: value for name, value in row.items() if name not in fixed} for row in rows]


def _find_units(step: Step, table: str, rows: Sequence[Row]) -> dict[str, str]:
    return {name: find_unit(step, table, name) for name in (rows[0] if rows else ())}


def _draw(results: Results, request: ViewRequest, caption: str) -> Picture | None:
    """Return a picture, or None where there is nothing to draw so: the table is there all the same."""
    found = draw_picture(results, request, caption)
    return None if found.problem else found
