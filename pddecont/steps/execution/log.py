"""What a step does that others see: rows and endings for the results file, words for who listens, in order.

A step that is done in another process keeps a log of it, which is written and told when its turn comes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Self, TypeAlias

from numpy.typing import NDArray

from pddecont.reasons import NO_REASON, Reason
from pddecont.results import Row, RowWriter, Step, make_step
from pddecont.steps.reporter import Reporter


@dataclass(frozen=True)
class Message:
    """What a reporter hears: the name of its method, and what that is given."""

    method: str
    values: tuple[Any, ...]

    def tell(self, reporter: Reporter) -> None:
        """Tell it to another."""
        getattr(reporter, self.method)(*self.values)


@dataclass(frozen=True, eq=False)
class Opened:
    """A step was opened: its kind, what it says of itself, and further options of its writer."""

    kind: str
    meta: Mapping[str, Any]
    options: Mapping[str, Any]


@dataclass(frozen=True)
class More:
    """A list of names that columns belong to got more."""

    key: str
    names: tuple[str, ...]


@dataclass(frozen=True)
class Ending:
    """How the step, or one of its directions, ended."""

    reason: Reason
    place: int


@dataclass(frozen=True)
class Closed:
    """The step was closed."""


Entry: TypeAlias = Message | Opened | Row | More | Ending | Closed


@dataclass(frozen=True)
class Listener:
    """A reporter that notes in a log what it hears."""

    log: list[Entry]

    def step(self, name: str, kind: str) -> None:
        """Note that a step begins."""
        self.log.append(Message("step", (name, kind)))

    def progress(self, text: str, fraction: float | None = None) -> None:
        """Note how far a step is."""
        self.log.append(Message("progress", (text, fraction)))

    def advance(self, done: int, total: int, what: str) -> None:
        """Note how many of a number of like things are done."""
        self.log.append(Message("advance", (done, total, what)))

    def note(self, text: str) -> None:
        """Note something that a person would want to know."""
        self.log.append(Message("note", (text,)))

    def done(self, text: str) -> None:
        """Note how a step ended."""
        self.log.append(Message("done", (text,)))


@dataclass(eq=False)
class RowsInMemory:
    """A writer that notes in a log what it is given; ``meta`` is the step's."""

    meta: dict[str, Any]
    log: list[Entry] = field(default_factory=list)
    closed: Callable[[], None] = lambda: None
    n: int = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            self.log.append(Closed())
            self.closed()

    def append(
        self, points: Mapping[str, Any], orbits: Mapping[str, NDArray[Any]] | None = None, reason: Reason | None = None
    ) -> None:
        """Keep one point."""
        self.log.append(Row(points, orbits or {}, reason or NO_REASON))
        self.n += 1

    def list_more(self, key: str, names: Iterable[str]) -> list[str]:
        """Return a list of names that columns belong to, with those of ``names`` that it lacked."""
        new = [name for name in names if name not in self.meta[key]]
        if new:
            self.meta[key] = [*self.meta[key], *new]
            self.log.append(More(key, tuple(new)))
        return list(self.meta[key])

    def terminate(self, ending: Reason, place: int = 0) -> None:
        """Keep how the step, or one of its directions, ended."""
        self.log.append(Ending(ending, place))


def write_entry(writer: RowWriter, entry: Row | More | Ending) -> None:
    """Give a writer what another was given."""
    match entry:
        case Row():
            writer.append(entry.points, entry.orbits, entry.reason)
        case More():
            writer.list_more(entry.key, entry.names)
        case Ending():
            writer.terminate(entry.reason, entry.place)


def step_from_log(name: str, log: Sequence[Entry]) -> Step | None:
    """Return what the results file will hold of a step; None if it was not closed."""
    opened = next((entry for entry in log if isinstance(entry, Opened)), None)
    if opened is None or not any(isinstance(entry, Closed) for entry in log):
        return None
    meta = dict(opened.meta)
    for entry in log:
        if isinstance(entry, More):
            meta[entry.key] = [*meta[entry.key], *entry.names]
    endings = {entry.place: entry.reason for entry in log if isinstance(entry, Ending)}
    return make_step(name, opened.kind, meta, [entry for entry in log if isinstance(entry, Row)], endings)
