"""``pddecont export``."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any

import click

from pddecont.cli.completers import complete_label, complete_step
from pddecont.cli.console import plain, say, to_json

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
@click.option(
    "-o",
    "--output",
    type=click.Path(dir_okay=False, path_type=Path),
    help="File to write; one that exists is replaced only if it holds such a table  [default: standard output]",
)
@click.option(
    "--step", metavar="STEP", help="Step to read  [default: the last that has the table]", shell_complete=complete_step
)
@click.option("--table", "name", type=TableName(), default="points", show_default=True)
@click.option(
    "--label",
    metavar="LABEL",
    help="Point whose orbit, multipliers or roots are wanted, such as GR1.",
    shell_complete=complete_label,
)
@click.option("--index", type=click.IntRange(0), help="The same point by its index.")
@click.option(
    "--format",
    "form",
    type=click.Choice(["csv", "json"]),
    help="[default: that of the output's suffix, .csv or .json, else csv]",
)
def command(
    file: str, output: Path | None, step: str | None, name: str, label: str | None, index: int | None, form: str | None
) -> None:
    """Write a table of results file FILE to standard output, or to a file."""
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
    is_json = form == "json" or (form is None and output is not None and output.suffix.lower() == ".json")
    text = f"{to_json(rows)}\n" if is_json else to_csv(rows)
    if output is None:
        click.echo(text, nl=False)
        return
    write_table(output, text)
    say(f"table: {output}")


def write_table(path: Path, text: str) -> None:
    """Write a table to a file; one that is there is replaced only where it begins as this table does.

    A table in CSV begins with the names of its columns, one in JSON with the name of the first.

    Raises
    ------
    ResultsError
        If something else is there, or it cannot be written.
    """
    from pddecont.output import check_replaceable, replace_whole

    beginning = text.partition(":" if text.startswith("[") else "\n")[0].encode()
    check_replaceable(path, lambda head: bool(beginning) and head.startswith(beginning), "such a table")
    with replace_whole(path) as part:
        part.write_text(text, encoding="utf-8")


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
