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
    from pddecont.output import check_replaceable, replace_whole
    from pddecont.report import is_page, render_page
    from pddecont.results import read_results

    path = output or Path(Path(file).stem + ".html")
    if path.suffix.lower() not in (".html", ".htm"):
        raise ResultsError(f"{path}: a report is .html; found '{path.suffix or 'no suffix'}'")
    results = read_results(file)
    check_replaceable(path, is_page, "a report of pddecont")
    text = render_page(results)
    with replace_whole(path) as part:
        part.write_text(text, encoding="utf-8")
    say(f"report: {path}")
