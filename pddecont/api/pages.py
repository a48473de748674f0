"""The page on results, which a browser shows."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pddecont.errors import ResultsError
from pddecont.output import check_replaceable, replace_whole
from pddecont.report import is_page, render_page
from pddecont.results import Results

SUFFIXES = (".html", ".htm")


def write_report(results: Sequence[Results], path: Path) -> None:
    """Write the page on one or several results files to ``path``.

    Raises
    ------
    ResultsError
        If the name of ``path`` does not end like a page's, what is there already is no such page, or it cannot be
        written.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise ResultsError(f"{path}: a report is .html; found '{path.suffix or 'no suffix'}'")
    check_replaceable(path, is_page, "a report of pddecont")
    text = render_page(*results)
    with replace_whole(path) as part:
        part.write_text(text, encoding="utf-8")
