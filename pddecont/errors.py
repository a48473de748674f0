"""The errors a user can meet, each with the place, what was found, what was expected and what to do next."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Sequence
from dataclasses import dataclass

# A file may be wrong in a thousand places, or hold a name as long as a book.
MAX_PROBLEMS = 100
MAX_MESSAGE = 1000
MAX_NAME = 60
MAX_KNOWN = 500


@dataclass(frozen=True, order=True)
class Problem:
    """One thing wrong in a text file; ``line`` and ``column`` count from 1 (0: the file as a whole)."""

    path: str
    line: int
    column: int
    message: str

    def __str__(self) -> str:
        place = f"{self.path}:{self.line}:{self.column}" if self.line else self.path
        return f"{place}: {shorten_message(self.message)}"


class PddecontError(Exception):
    """Base of all errors this program raises on purpose."""


class InputError(PddecontError):
    """A text file is wrong; ``problems`` holds everything found in it, in the file's order."""

    def __init__(self, problems: Sequence[Problem]):
        found = sorted(problems)
        if len(found) > MAX_PROBLEMS:
            left = len(found) - MAX_PROBLEMS
            found = [
                *found[:MAX_PROBLEMS],
                Problem(found[-1].path, 0, 0, f"and {left} more problems, which are not listed"),
            ]
        self.problems = tuple(found)
        super().__init__("\n".join(map(str, self.problems)))

    def __reduce__(self) -> tuple[type[InputError], tuple[tuple[Problem, ...]]]:
        """Return what makes the error anew in another process."""
        return type(self), (self.problems,)

    @classmethod
    def at(cls, path: str, line: int, column: int, message: str) -> InputError:
        """Return the error for a single problem at ``path:line:column``."""
        return cls([Problem(path, line, column, message)])


class ModelError(InputError):
    """The model file is wrong."""


class RunError(InputError):
    """The run file, or an option that overrides it, is wrong."""


class SignatureError(PddecontError):
    """The segments of a signature do not follow one another, or a trajectory has no signature."""


class ConvergenceError(PddecontError):
    """A computation did not converge; ``history`` holds the residual norms of its iterations."""

    def __init__(self, message: str, history: Sequence[float] = ()):
        self.history = tuple(history)
        super().__init__(message)


class ResultsError(PddecontError):
    """A results file is missing, damaged, of another version, or must not be overwritten."""


def suggest(name: str, known: Collection[str]) -> str:
    """Return "; did you mean 'x'?" for the known name closest to ``name``, or an empty text."""
    if len(name) > MAX_NAME or len(known) > MAX_KNOWN:
        return ""
    close = difflib.get_close_matches(name, [k for k in known if len(k) <= MAX_NAME], n=1)
    return f"; did you mean '{close[0]}'?" if close else ""


def shorten_message(message: str) -> str:
    """Return a message with its middle left out where it is too long to be read."""
    if len(message) <= MAX_MESSAGE:
        return message
    half = MAX_MESSAGE // 2
    return f"{message[:half]} ... {message[-half:]}"


def printable(text: str) -> str:
    """Return ``text`` with what could move a terminal's cursor or change its colours written out."""
    return "".join(c if c.isprintable() or c == "\n" else repr(c)[1:-1] for c in text)
