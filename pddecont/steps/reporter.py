"""Who hears how a run goes."""

from __future__ import annotations

from typing import Protocol


class Reporter(Protocol):
    """Someone who wants to know how a run goes."""

    def step(self, name: str, kind: str) -> None:
        """Hear that a step begins."""
        ...

    def progress(self, text: str, fraction: float | None = None) -> None:
        """Hear how far a step is."""
        ...

    def advance(self, done: int, total: int, what: str) -> None:
        """Hear how many of a number of like things are done."""
        ...

    def note(self, text: str) -> None:
        """Hear something that a person would want to know while waiting."""
        ...

    def done(self, text: str) -> None:
        """Hear how a step ended."""
        ...


class Silent:
    """A reporter that listens and says nothing."""

    def step(self, name: str, kind: str) -> None:
        """Hear that a step begins."""

    def progress(self, text: str, fraction: float | None = None) -> None:
        """Hear how far a step is."""

    def advance(self, done: int, total: int, what: str) -> None:
        """Hear how many of a number of like things are done."""

    def note(self, text: str) -> None:
        """Hear something that a person would want to know while waiting."""

    def done(self, text: str) -> None:
        """Hear how a step ended."""
