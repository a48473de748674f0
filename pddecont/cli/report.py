"""``pddecont report``."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

import click

from pddecont.cli.console import say


@click.command("report")
@click.argument("files", type=click.Path(), nargs=-1, required=True, metavar="FILE...")
@click.option(
    "-o",
    "--output",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Page  [default: the last FILE's name, .html]",
)
def command(files: tuple[str, ...], output: Path | None) -> None:
    """Write one HTML page on results files: diagrams to explore, orbits, special points, settings, texts and versions.

    The page holds all that it shows and loads nothing; an older page is replaced.
    """
    from pddecont.errors import ResultsError

    path = output or Path(Path(files[-1]).stem + ".html")
    if path.suffix.lower() not in (".html", ".htm"):
        raise ResultsError(f"{path}: a report is .html; found '{path.suffix or 'no suffix'}'")
    write_page(files, path)
    say(f"report: {path}")


def check_page(path: Path) -> None:
    """Raise ResultsError unless a page may be written to ``path``: what is there already must be such a page."""
    from pddecont.output import check_replaceable
    from pddecont.report import is_page

    check_replaceable(path, is_page, "a report of pddecont")


def write_page(files: Sequence[str], path: Path, every: float = 0.0) -> None:
    """Write the page on results files to ``path``; it reads itself anew ``every`` so many seconds, where not 0."""
    from pddecont.output import replace_whole
    from pddecont.report import Live, render_page
    from pddecont.results import read_results

    results = [read_results(file) for file in files]
    check_page(path)
    text = render_page(*results, live=Live(round(1000 * time.time()), round(1000 * every)) if every else None)
    with replace_whole(path) as part:
        part.write_text(text, encoding="utf-8")
