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


def see(monkeypatch, columns):
    """Return a terminal of so many columns in place of standard error."""
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", str(columns))
    return terminal


def test_a_branch_says_how_much_of_its_range_it_has_covered(monkeypatch):
    terminal = see(monkeypatch, 120)
    progress = Progress(False, n_steps=3)
    progress.step("in_gain", "continue")
    progress.progress("7 points, K = 0.25", 0.34)
    progress.stop()
    assert "in_gain: 7 points, K = 0.25" in terminal.getvalue() and "34%" in terminal.getvalue()


def test_a_narrow_terminal_cuts_no_words(monkeypatch):
    terminal = see(monkeypatch, 40)
    progress = Progress(False)
    progress.step("in_the_gain_of_feedback", "continue")
    progress.progress("1234 points, tau = 0.12345678, K = 0.87654321", 0.5)
    progress.stop()
    text = terminal.getvalue()
    assert "…" not in text
    assert all(word in text for word in ("in_the_gain_of_feedback:", "0.12345678,", "0.87654321", "50%"))


def test_names_are_no_marks_of_a_terminal(monkeypatch):
    terminal = see(monkeypatch, 100)
    progress = Progress(False)
    progress.step("a", "orbit")
    progress.note("[red]through the signature [flight][/red]\x1b]0;title\x07")
    progress.progress("[bold]x[/bold]")
    progress.stop()
    assert "[red]through the signature [flight][/red]" in terminal.getvalue()
    assert "[bold]x[/bold]" in terminal.getvalue()
    assert "\x1b]0;title" not in terminal.getvalue()


def test_a_log_hears_now_and_then_how_far_a_step_is(monkeypatch):
    stream = io.StringIO()
    monkeypatch.setattr(sys, "stderr", stream)
    progress = Progress(False, n_steps=2, every=0.0)
    progress.step("diagram", "sweep")
    progress.advance(1, 8, "parameter points")
    progress.step("branch", "continue")
    progress.progress("3 points, K = 2", 0.125)
    progress.progress("looking for attractors")
    progress.step("more", "orbit")
    assert stream.getvalue().splitlines() == [
        "diagram: sweep (1 of 2) ...",
        "diagram: 1 of 8 parameter points",
        "branch: continue (2 of 2) ...",
        "branch: 3 points, K = 2 (12 %)",
        "branch: looking for attractors",
        "more: orbit ...",
    ]
    quiet = Progress(True, every=0.0)
    quiet.step("a", "sweep")
    quiet.advance(1, 2, "points")
    assert "a:" not in stream.getvalue()


def test_what_is_no_terminal_gets_whole_lines_only(monkeypatch):
    stream = io.StringIO()
    monkeypatch.setattr(sys, "stderr", stream)
    progress = Progress(False)
    progress.step("diagram", "sweep")
    progress.advance(1, 8, "parameter points")
    progress.progress("t = 3", 0.5)
    progress.done("done")
    assert stream.getvalue() == "diagram: sweep ...\ndiagram: done\n"
