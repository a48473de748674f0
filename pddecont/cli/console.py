"""Messages, exit codes and progress."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable
from enum import IntEnum
from typing import Any

import click

from pddecont.errors import ConvergenceError, InputError, PddecontError, SignatureError


class Exit(IntEnum):
    """Exit codes (design section 1)."""

    DONE = 0
    WRONG_INPUT = 1
    WRONG_USAGE = 2
    NOT_CONVERGED = 3
    INTERRUPTED = 130


def guarded(work: Callable[[], Any]) -> None:
    """Do ``work`` and exit with the code that its outcome calls for."""
    try:
        result = work()
    except click.exceptions.Exit as exc:
        sys.exit(exc.exit_code)
    except click.Abort:
        say("interrupted; what was computed before is kept")
        sys.exit(Exit.INTERRUPTED)
    except click.ClickException as exc:
        exc.show()
        sys.exit(Exit.WRONG_USAGE)
    except KeyboardInterrupt:
        say("interrupted; what was computed before is kept, and --resume goes on from there")
        sys.exit(Exit.INTERRUPTED)
    except BrokenPipeError:
        # The reader of our output has gone; there is nobody left to tell.
        sys.stderr.close()
        sys.exit(Exit.DONE)
    except InputError as exc:
        for problem in exc.problems:
            say(str(problem))
        sys.exit(Exit.WRONG_INPUT)
    except (ConvergenceError, SignatureError) as exc:
        say(f"pddecont: {exc}")
        sys.exit(Exit.NOT_CONVERGED)
    except PddecontError as exc:
        say(f"pddecont: {exc}")
        sys.exit(Exit.WRONG_INPUT)
    sys.exit(result if isinstance(result, int) else Exit.DONE)


def say(text: str) -> None:
    """Write a line to standard error."""
    click.echo(text, err=True)


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


def print_json(value: Any) -> None:
    """Write one JSON document to standard output."""
    click.echo(json.dumps(plain(value), indent=2, ensure_ascii=False))


class Progress:
    """Tells how a run goes on standard error; a terminal gets a line that moves."""

    def __init__(self, quiet: bool):
        self.quiet = quiet
        self.moving = not quiet and sys.stderr.isatty()
        self.console: Any = None
        self.status: Any = None
        self.name = ""
        if self.moving:
            from rich.console import Console

            self.console = Console(stderr=True)

    def step(self, name: str, kind: str) -> None:
        """Hear that a step begins."""
        self.name = name
        if self.quiet:
            return
        if self.moving:
            self.status = self.console.status(f"{name}: {kind}")
            self.status.start()
        else:
            say(f"{name}: {kind} ...")

    def progress(self, text: str, fraction: float | None = None) -> None:
        """Hear how far a step is."""
        if self.status is not None:
            share = "" if fraction is None else f" ({100 * fraction:.0f} %)"
            self.status.update(f"{self.name}: {text}{share}")

    def done(self, text: str) -> None:
        """Hear how a step ended."""
        if self.quiet:
            return
        self.stop()
        say(f"{self.name}: {text}")

    def stop(self) -> None:
        """Clear the moving line."""
        if self.status is not None:
            self.status.stop()
            self.status = None
