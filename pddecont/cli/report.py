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
    path = output or Path(Path(files[-1]).stem + ".html")
    write_page(files, path)
    say(f"report: {path}")


def write_page(files: Sequence[str], path: Path) -> None:
    """Write the page on results files to ``path``; what is there already must be such a page."""
    from pddecont.api import write_report
    from pddecont.results import read_results

    write_report([read_results(file) for file in files], path)
