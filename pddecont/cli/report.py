"""``pddecont report``."""

from __future__ import annotations

from pathlib import Path

import click

from pddecont.cli.console import say


@click.command("report")
@click.argument("file", type=click.Path())
@click.option(
    "-o", "--output", type=click.Path(dir_okay=False, path_type=Path), help="Page  [default: FILE's name, .html]"
)
def command(file: str, output: Path | None) -> None:
    """Write one HTML page on results file FILE: pictures, special points, settings, texts and versions.

    The page holds all that it shows and loads nothing; an older page is replaced.
    """
    from pddecont.errors import ResultsError
    from pddecont.report import render_page
    from pddecont.results import read_results

    path = output or Path(Path(file).stem + ".html")
    if path.suffix.lower() not in (".html", ".htm"):
        raise ResultsError(f"{path}: a report is .html; found '{path.suffix or 'no suffix'}'")
    text = render_page(read_results(file))
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as exc:
        raise ResultsError(f"{path} cannot be written: {exc.strerror}") from exc
    say(f"report: {path}")
