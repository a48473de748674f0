"""``pddecont report``."""

from __future__ import annotations

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


def write_page(files: Sequence[str], path: Path) -> None:
    """Write the page on results files to ``path``; what is there already must be such a page."""
    from pddecont.output import check_replaceable, replace_whole
    from pddecont.report import is_page, render_page
    from pddecont.results import read_results

    results = [read_results(file) for file in files]
    check_replaceable(path, is_page, "a report of pddecont")
    text = render_page(*results)
    with replace_whole(path) as part:
        part.write_text(text, encoding="utf-8")
