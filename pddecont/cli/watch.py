"""A page on the results of a run, written anew while it goes on."""

from __future__ import annotations

import time
from pathlib import Path

from pddecont.api import check_report, write_report
from pddecont.errors import PddecontError
from pddecont.results import read_results
from pddecont.steps import Reporter

# Seconds between pages, and so many times what one takes: the run goes on nearly as fast as without.
EVERY, SHARE = 3.0, 10.0


class Watch:
    """Passes on what is heard of a run, and writes the page now and then.

    A page that cannot be written is said to be so, once; the run goes on without.
    """

    def __init__(self, reporter: Reporter, results: Path, page: Path):
        check_report(page)
        self.reporter, self.results, self.page = reporter, results, page
        self.has_begun, self.can_write = False, True
        self.next_at, self.every = time.monotonic(), EVERY

    def step(self, name: str, kind: str) -> None:
        """Hear that a step begins."""
        self.has_begun = True
        self.reporter.step(name, kind)
        self._write_sometimes()

    def progress(self, text: str, fraction: float | None = None) -> None:
        """Hear how far a step is."""
        self.reporter.progress(text, fraction)
        self._write_sometimes()

    def advance(self, done: int, total: int, what: str) -> None:
        """Hear how many of a number of like things are done."""
        self.reporter.advance(done, total, what)
        self._write_sometimes()

    def note(self, text: str) -> None:
        """Hear something that a person would want to know while waiting."""
        self.reporter.note(text)

    def done(self, text: str) -> None:
        """Hear how a step ended."""
        self.reporter.done(text)
        self._write_sometimes()

    def close(self) -> None:
        """Write the page of a run that has begun for the last time: it is not read anew any more."""
        if self.has_begun:
            self._write(0.0)

    def _write_sometimes(self) -> None:
        if time.monotonic() >= self.next_at:
            begun = time.monotonic()
            self._write(self.every)
            now = time.monotonic()
            self.every = max(EVERY, SHARE * (now - begun))
            self.next_at = now + self.every

    def _write(self, every: float) -> None:
        if not self.can_write:
            return
        try:
            write_report([read_results(self.results)], self.page, every)
        except PddecontError as exc:
            self.can_write = False
            self.reporter.note(f"the page is not written any more: {exc}")
