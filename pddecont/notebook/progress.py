"""How a notebook hears of a run: a bar under the cell while it goes on, a folded list of its steps when it has ended.

A display that is shown anew by its identifier does so in every notebook; bars made of widgets need ``ipywidgets``, and
are lost where a notebook is turned into a page.
"""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Iterator
from html import escape
from typing import TYPE_CHECKING, Any

from pddecont.steps import Silent

if TYPE_CHECKING:
    from pddecont.steps import Reporter

# Seconds between two updates of the display.
SECONDS_BETWEEN = 0.2
# Steps that the list names; of more it names the last.
MAX_LINES = 50


class NotebookProgress:
    """Tells below a notebook's cell how a run goes."""

    def __init__(self, every: float = SECONDS_BETWEEN):
        self.every, self.last_shown = every, 0.0
        self.lines: list[str] = []
        self.name, self.text = "", ""
        self.share: float | None = None
        self.n_done = 0
        self.handle: Any = None

    def step(self, name: str, kind: str) -> None:
        """Hear that a step begins."""
        self.name, self.text, self.share = name, kind, None
        self._show()

    def progress(self, text: str, fraction: float | None = None) -> None:
        """Hear how far a step is."""
        self.text, self.share = text, fraction
        self._show()

    def advance(self, done: int, total: int, what: str) -> None:
        """Hear how many of a number of like things are done."""
        self.progress(f"{done} of {total} {what}", done / total if total else None)

    def note(self, text: str) -> None:
        """Hear something that a person would want to know while waiting."""
        self.lines.append(text)

    def done(self, text: str) -> None:
        """Hear how a step ended."""
        self.lines.append(f"{self.name}: {text}")
        self.n_done += 1

    def close(self, ended: bool) -> None:
        """Leave the list of what was done in place of the bar; ``ended``: the run came to its end."""
        if self.handle is None:
            return
        left_out = len(self.lines) - MAX_LINES
        lines = [*([f"{left_out} lines before"] if left_out > 0 else []), *self.lines[-MAX_LINES:]]
        steps = f"{self.n_done} step{'s'[: self.n_done - 1]}"
        title = f"{steps} done" if ended else f"{steps} done, then broken off in '{self.name}'"
        items = "".join(f"<li>{escape(line)}</li>" for line in lines)
        self._update(f"<details><summary>{escape(title)}</summary><ul>{items}</ul></details>", title)

    def _show(self) -> None:
        if self.handle is not None and time.monotonic() - self.last_shown < self.every:
            return
        self.last_shown = time.monotonic()
        value = "" if self.share is None else f' value="{min(max(self.share, 0.0), 1.0):.4f}"'
        text = f"{self.name}: {self.text}"
        self._update(f'<progress max="1"{value}></progress> {escape(text)}', text)

    def _update(self, html: str, text: str) -> None:
        from IPython.display import display

        bundle = {"text/html": html, "text/plain": text}
        if self.handle is None:
            self.handle = display(bundle, raw=True, display_id=True)
        else:
            self.handle.update(bundle, raw=True)


@contextlib.contextmanager
def choose_reporter(reporter: Reporter | None) -> Iterator[Reporter]:
    """Give the reporter that is given; without one a bar in a notebook, and nobody elsewhere."""
    if reporter is not None or not is_in_notebook():
        yield reporter or Silent()
        return
    progress = NotebookProgress()
    ended = False
    try:
        yield progress
        ended = True
    finally:
        progress.close(ended)


def is_in_notebook() -> bool:
    """Return whether this process is the kernel of a notebook; a shell of IPython in a terminal is none."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return getattr(shell, "kernel", None) is not None
