"""``pddecont export``."""

from __future__ import annotations

import csv
import io
from typing import Any

import click

from pddecont.cli.console import plain, print_json

# A spreadsheet takes text that begins so for a formula and works it out; after an apostrophe it does not.
FORMULA_SIGNS = ("=", "+", "-", "@", "\t", "\r")


class TableName(click.Choice[str]):
    """The names of the tables that there are, which are loaded when they are asked for and not before."""

    def __init__(self) -> None:
        self.case_sensitive = True

    @property
    def choices(self) -> tuple[str, ...]:  # type: ignore[override]
        """The names."""
        from pddecont.tables import list_all_tables

        return tuple(list_all_tables())


@click.command("export")
@click.argument("file", type=click.Path())
@click.option("--step", metavar="STEP", help="Step to read  [default: the last that has the table]")
@click.option("--table", "name", type=TableName(), default="points", show_default=True)
@click.option("--label", metavar="LABEL", help="Point whose orbit, multipliers or roots are wanted, such as GR1.")
@click.option("--index", type=click.IntRange(0), help="The same point by its index.")
@click.option("--format", "form", type=click.Choice(["csv", "json"]), default="csv", show_default=True)
def command(file: str, step: str | None, name: str, label: str | None, index: int | None, form: str) -> None:
    """Write a table of results file FILE to standard output."""
    from pddecont.errors import ResultsError
    from pddecont.results import read_results
    from pddecont.tables import has_multipliers, list_tables, make_table

    if label is not None and index is not None:
        raise click.UsageError("--label and --index exclude each other")
    results = read_results(file)
    if step is None:
        candidates = [s for s in results.steps.values() if name in list_tables(s.kind)]
        if not candidates:
            raise ResultsError(
                f"{file} has no step with a table '{name}' (steps: {', '.join(results.steps) or 'none'})"
            )
        if name == "multipliers":
            candidates = [s for s in candidates if has_multipliers(s)] or candidates
        step = candidates[-1].name
    chosen = results.step(step)
    rows = make_table(chosen, name, chosen.row(label) if label else index)
    if form == "json":
        print_json(rows)
    else:
        click.echo(to_csv(rows), nl=False)


def to_csv(rows: list[dict[str, Any]]) -> str:
    """Return rows as CSV with a header; numbers keep all their digits, a complex number is two columns, re and im.

    Text that a spreadsheet would take for a formula gets an apostrophe before it.
    """
    if not rows:
        return ""
    rows = [_real(row) for row in rows]
    out = io.StringIO()
    writer = csv.DictWriter(out, fieldnames=list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows([{k: _cell(v) for k, v in row.items()} for row in rows])
    return out.getvalue()


def _real(row: dict[str, Any]) -> dict[str, Any]:
    result: dict[str, Any] = {}
    for key, value in row.items():
        if isinstance(value, complex):
            # A parameter may be called re, after Reynolds.
            names = (f"{key}_re", f"{key}_im") if {"re", "im"} & set(row) else ("re", "im")
            result |= dict(zip(names, (value.real, value.imag), strict=True))
        else:
            result[key] = value
    return result


def _cell(value: Any) -> Any:
    if isinstance(value, bool):
        return str(value).lower()
    value = plain(value)
    if isinstance(value, str) and value.startswith(FORMULA_SIGNS):
        return f"'{value}"
    return repr(value) if isinstance(value, float) else "" if value is None else value
