"""What a terminal shows while a run goes on."""

import io
import sys
import time

from pddecont.cli.console import Progress


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_a_terminal_sees_how_fast_it_goes_and_how_long_it_takes(monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "120")
    progress = Progress(False)
    progress.step("diagram", "sweep")
    for done in range(1, 5):
        progress.advance(done, 8, "parameter points")
        time.sleep(0.15)
    progress.note("by the way")
    progress.done("4 parameter points")
    text = terminal.getvalue()
    assert "of 8 parameter points" in text
    assert "a second" in text
    assert "0:00:0" in text
    assert "by the way" in text
    assert text.rstrip().endswith("diagram: 4 parameter points")


def test_what_is_no_terminal_gets_whole_lines_only(monkeypatch):
    stream = io.StringIO()
    monkeypatch.setattr(sys, "stderr", stream)
    progress = Progress(False)
    progress.step("diagram", "sweep")
    progress.advance(1, 8, "parameter points")
    progress.progress("t = 3", 0.5)
    progress.done("done")
    assert stream.getvalue() == "diagram: sweep ...\ndiagram: done\n"
