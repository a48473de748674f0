"""The page on results, which a browser shows."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

from pddecont.errors import ResultsError
from pddecont.output import check_replaceable, replace_whole
from pddecont.report import Live, is_page, render_page
from pddecont.results import Results

SUFFIXES = (".html", ".htm")


def check_report(path: Path) -> None:
    """Raise ResultsError unless a page may be written to ``path``: what is there already must be such a page."""
    if path.suffix.lower() not in SUFFIXES:
        raise ResultsError(f"{path}: a report is .html; found '{path.suffix or 'no suffix'}'")
    check_replaceable(path, is_page, "a report of pddecont")


def write_report(results: Sequence[Results], path: Path, every: float = 0.0) -> None:
    """Write the page on one or several results files to ``path``.

    Where ``every`` is not 0 the page reads itself anew in the browser, so many seconds apart.

    Raises
    ------
    ResultsError
        If the name of ``path`` does not end like a page's, what is there already is no such page, or it cannot be
        written.
    """
    check_report(path)
    text = render_page(*results, live=Live(round(1000 * time.time()), round(1000 * every)) if every else None)
    with replace_whole(path) as part:
        part.write_text(text, encoding="utf-8")
