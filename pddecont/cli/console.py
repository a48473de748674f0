"""Messages, exit codes and progress."""

from __future__ import annotations

import contextlib
import io
import json
import math
import sys
import time
from collections.abc import Callable
from enum import IntEnum
from typing import Any

import click

from pddecont.cli.interrupt import Received
from pddecont.errors import ConvergenceError, InputError, PddecontError, SignatureError, printable

# What is no terminal hears how far a run is so often.
SECONDS_BETWEEN_LINES = 30.0
# Columns of a terminal below which there is no room for a bar, and the bar's.
NARROW, BAR_WIDTH = 80, 20


class Exit(IntEnum):
    """Exit codes (``docs/reference/commands.md``)."""

    DONE = 0
    WRONG_INPUT = 1
    WRONG_USAGE = 2
    NOT_CONVERGED = 3
    INTERRUPTED = 130


def run_and_exit(work: Callable[[], Any], received: Received) -> None:
    """Do ``work`` and exit with the code that its outcome calls for."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # Names of files and models may hold letters that the terminal has not.
            stream.reconfigure(errors="backslashreplace")
    sys.exit(_outcome(work, received))


def _interruptible(work: Callable[[], Any], received: Received) -> Any:
    try:
        result = work()
        sys.stdout.flush()
    except click.Abort as exc:
        raise KeyboardInterrupt from exc
    except Exception as exc:
        # What is interrupted while it is loaded, called back, or closing a file may make another error of it.
        if received.number:
            raise KeyboardInterrupt from exc
        raise
    return result


def _outcome(work: Callable[[], Any], received: Received) -> int:
    try:
        result = _interruptible(work, received)
    except click.exceptions.Exit as exc:
        return exc.exit_code
    except click.ClickException as exc:
        exc.show()
        return Exit.WRONG_USAGE
    except BrokenPipeError:
        # The reader of our output has gone; there is nobody left to tell.
        sys.stderr.close()
        return Exit.DONE
    except InputError as exc:
        for problem in exc.problems:
            say(str(problem))
        return Exit.WRONG_INPUT
    except (ConvergenceError, SignatureError) as exc:
        say(f"pddecont: {exc}")
        return Exit.NOT_CONVERGED
    except PddecontError as exc:
        say(f"pddecont: {exc}")
        return Exit.WRONG_INPUT
    except OSError as exc:
        # What works with files names them; what is left is where our output goes.
        say(f"pddecont: {exc.filename or 'standard output'} cannot be written: {exc.strerror}")
        with contextlib.suppress(OSError):
            sys.stdout.close()
        return Exit.WRONG_INPUT
    except MemoryError:
        say("pddecont: there is not enough memory for what the file asks; what was finished is kept")
        return Exit.NOT_CONVERGED
    return result if isinstance(result, int) else Exit.DONE


def say(text: str) -> None:
    """Write a line to standard error."""
    click.echo(printable(text), err=True)


def plain(value: Any) -> Any:
    """Return ``value`` as JSON can hold it: complex numbers as [re, im], what is not finite as null."""
    if isinstance(value, dict):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    if isinstance(value, complex):
        return [plain(value.real), plain(value.imag)]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def to_json(value: Any) -> str:
    """Return one JSON document."""
    return json.dumps(plain(value), indent=2, ensure_ascii=False)


def print_json(value: Any) -> None:
    """Write one JSON document to standard output."""
    click.echo(to_json(value))


class Progress:
    """Tells how a run of ``n_steps`` goes on standard error.

    A terminal gets a line that moves, anything else a line now and then, for whoever reads the log of a long run.
    """

    def __init__(self, quiet: bool, n_steps: int = 1, every: float = SECONDS_BETWEEN_LINES):
        self.quiet = quiet
        self.moving = not quiet and sys.stderr.isatty()
        self.n_steps, self.n_begun = n_steps, 0
        self.every, self.last_said = every, 0.0
        self.console: Any = None
        self.bar: Any = None
        self.task: Any = None
        self.name = ""
        if self.moving:
            from rich.console import Console

            self.console = Console(stderr=True)

    def step(self, name: str, kind: str) -> None:
        """Hear that a step begins."""
        self.name, self.last_said = name, time.monotonic()
        self.n_begun += 1
        if self.quiet:
            return
        # A step that explores begins more steps than were planned.
        count = f" ({self.n_begun} of {self.n_steps})" if 1 < self.n_steps >= self.n_begun else ""
        if not self.moving:
            say(f"{name}: {kind}{count} ...")
            return
        from rich.progress import Progress

        self.bar = Progress(*_list_columns(self.console.width), console=self.console, transient=True)
        self.task = self.bar.add_task(escape(f"{name}: {kind}{count}"), total=None, rate="")
        self.bar.start()

    def progress(self, text: str, fraction: float | None = None) -> None:
        """Hear how far a step is."""
        if self.bar is not None:
            share = {} if fraction is None else {"completed": 100 * fraction, "total": 100}
            self.bar.update(self.task, description=escape(f"{self.name}: {text}"), **share)
        else:
            self._say_sometimes(f"{text}{'' if fraction is None else f' ({100 * fraction:.0f} %)'}")

    def advance(self, done: int, total: int, what: str) -> None:
        """Hear how many of a number of like things are done."""
        text = f"{done} of {total} {what}"
        if self.bar is not None:
            elapsed = self.bar.tasks[0].elapsed or 0.0
            rate = f"{done / elapsed:.3g} a second" if elapsed else ""
            self.bar.update(
                self.task, description=escape(f"{self.name}: {text}"), completed=done, total=total, rate=rate
            )
        else:
            self._say_sometimes(text)

    def note(self, text: str) -> None:
        """Hear something that a person would want to know while waiting."""
        if self.quiet:
            return
        if self.bar is not None:
            self.console.print(printable(text), markup=False, highlight=False)
        else:
            say(text)

    def done(self, text: str) -> None:
        """Hear how a step ended."""
        if self.quiet:
            return
        self.stop()
        say(f"{self.name}: {text}")

    def stop(self) -> None:
        """Clear the moving line."""
        if self.bar is not None:
            self.bar.stop()
            self.bar = None

    def _say_sometimes(self, text: str) -> None:
        if not self.quiet and time.monotonic() - self.last_said >= self.every:
            self.last_said = time.monotonic()
            say(f"{self.name}: {text}")


def _list_columns(width: int) -> list[Any]:
    """Return what stands in the moving line of a terminal; in a narrow one words go on below instead of being cut."""
    from rich.progress import BarColumn, SpinnerColumn, TaskProgressColumn, TextColumn, TimeRemainingColumn
    from rich.table import Column

    words = TextColumn("{task.description}", table_column=Column(no_wrap=False))
    if width < NARROW:
        return [SpinnerColumn(), words, TaskProgressColumn()]
    return [
        SpinnerColumn(),
        words,
        BarColumn(BAR_WIDTH),
        TaskProgressColumn(),
        TextColumn("{task.fields[rate]}"),
        TimeRemainingColumn(),
    ]


def escape(text: str) -> str:
    """Return ``text`` as a terminal may show it, without what rich would take for its own marks."""
    from rich.markup import escape as escape_marks

    return escape_marks(printable(text))
