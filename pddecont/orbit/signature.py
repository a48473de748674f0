"""The ordered segments of a periodic orbit, and what follows from them alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.delay import DiscontinuitySources, find_discontinuity_sources
from pddecont.errors import SignatureError
from pddecont.model import IDENTITY, Segment

Array = NDArray[np.float64]


@dataclass(frozen=True)
class WatchedEvent:
    """An event function that ends a mode where it crosses zero in ``direction``.

    ``terminal`` says whether it is the one that ends the segment in question.
    """

    event: str
    direction: str
    terminal: bool


@dataclass(frozen=True)
class DelayedEventLink:
    """Segment ``segment`` ends by a delayed event that the end of ``source`` started, ``wraps`` periods before."""

    segment: int
    source: int
    wraps: int


@dataclass(frozen=True, eq=False)
class Signature:
    """The segments of an orbit in order; an orbit without events is one segment that leads to itself."""

    numeric: NumericModel
    segments: tuple[Segment, ...]
    _watched: dict[int, tuple[WatchedEvent, ...]] = field(default_factory=dict, init=False, repr=False)

    def __len__(self) -> int:
        return len(self.segments)

    @cached_property
    def names(self) -> list[str]:
        """Names of the segments."""
        return [segment.name for segment in self.segments]

    @cached_property
    def has_events(self) -> bool:
        """Whether segments end at events."""
        return bool(self.segments[0].event)

    @cached_property
    def needs_phase_reference(self) -> bool:
        """Whether nothing fixes where the orbit begins: no event, no forcing."""
        return not self.has_events and not self.numeric.model.forced

    @cached_property
    def discontinuity_sources(self) -> DiscontinuitySources:
        """What decides where derivatives of the orbit jump."""
        return find_discontinuity_sources(self.numeric.model, self.segments)

    def list_watched_events(self, s: int) -> tuple[WatchedEvent, ...]:
        """Return the events with a function that segment ``s`` watches, each direction once."""
        if s not in self._watched:
            self._watched[s] = self._find_watched(s)
        return self._watched[s]

    def _find_watched(self, s: int) -> tuple[WatchedEvent, ...]:
        model, here = self.numeric.model, self.segments[s]
        keys = dict.fromkeys(
            (other.event, other.direction)
            for other in model.segments.values()
            if other.mode == here.mode and model.events[other.event].function is not None
        )
        return tuple(WatchedEvent(*key, terminal=key == (here.event, here.direction)) for key in keys)


def make_eventless(mode: str) -> Segment:
    """Return the only segment of an orbit that meets no event in ``mode``."""
    return Segment(f"({mode})", mode, "", "any", IDENTITY, mode)


def is_rotation(a: Sequence[str], b: Sequence[str]) -> bool:
    """Return whether two signatures are the same up to where they begin."""
    return len(a) == len(b) and any(list(a) == [*b[i:], *b[:i]] for i in range(max(len(b), 1)))


def link_delayed_events(signature: Signature, p: Array, durations: Array) -> tuple[DelayedEventLink, ...]:
    """Return what started the delayed event at the end of each segment that ends by one.

    The end of the segment lies at the end of its source plus the event's delay minus whole periods.

    Raises
    ------
    SignatureError
        If no segment ends at the event that starts a delayed one.
    """
    numeric, segments = signature.numeric, signature.segments
    ends, period = np.cumsum(durations), float(np.sum(durations))
    links = []
    for s, segment in enumerate(segments):
        event = numeric.model.events.get(segment.event)
        if event is None or event.after is None:
            continue
        delay = float(numeric.event_delay(event.name).value(p)[0])
        sources = [a for a, other in enumerate(segments) if other.event == event.after]
        if not sources:
            raise SignatureError(
                f"segment '{segment.name}' ends at '{event.name}', which comes after '{event.after}', but no segment "
                f"of this orbit ends at '{event.after}'"
            )
        turns = [(ends[a] + delay - ends[s]) / period for a in sources]
        best = min(range(len(sources)), key=lambda i: abs(turns[i] - round(turns[i])))
        links.append(DelayedEventLink(s, sources[best], round(turns[best])))
    return tuple(links)
