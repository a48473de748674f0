"""The ordered segments of a periodic orbit, and what follows from them alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import NumericModel, ParameterFunction
from pddecont.delay import DiscontinuitySources, find_discontinuity_sources
from pddecont.errors import SignatureError
from pddecont.memo import cached_property
from pddecont.model import Model, Segment, find_return, list_carriers, list_transitions

Array = NDArray[np.float64]
# An event so near, in periods, to where a jump of what its function reads comes back is made by the jump.
AT_JUMP = 1e-9


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
    """Segment ``segment`` ends at a time that the end of ``source`` set, ``wraps`` periods before.

    It ends by a delayed event that the source started, or where the jump that the source's reset made comes back
    through ``lag``, the number of a delay, and carries an event function over its zero.
    """

    segment: int
    source: int
    wraps: int
    lag: int | None = None

    def find_varying(self, model: Model) -> int | None:
        """Return the number, among the delays that vary, of the one that the jump comes back through, if it is one."""
        return None if self.lag is None or self.lag < len(model.delays) else self.lag - len(model.delays)

    def make_delay(self, signature: Signature) -> ParameterFunction:
        """Return the time between the two as a function of the parameters; it does not vary."""
        if self.lag is not None:
            return signature.numeric.single_delay(self.lag)
        return signature.numeric.event_delay(signature.segments[self.segment].event)


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

    @cached_property
    def trailing(self) -> dict[int, int]:
        """The segments between impacts that accumulate, each with the one that ends with the first of these.

        However short they are and however slow their impacts, they last as long as the first one lets them.
        """
        found: dict[int, int] = {}
        for last in (s for s, segment in enumerate(self.segments) if segment.rests):
            impact = self.segments[last]
            first = last
            while first > last - len(self) + 1:
                before = self.segments[first - 1]
                if before.rests or (before.mode, before.written or before.name) != (impact.mode, impact.written):
                    break
                first -= 1
            found |= {s % len(self): first % len(self) for s in range(first + 1, last + 1)}
        return found

    def list_watched_events(self, s: int) -> tuple[WatchedEvent, ...]:
        """Return the events with a function that segment ``s`` watches, each direction once."""
        if s not in self._watched:
            self._watched[s] = self._find_watched(s)
        return self._watched[s]

    def _find_watched(self, s: int) -> tuple[WatchedEvent, ...]:
        here = self.segments[s]
        surfaces = list_transitions(self.numeric.model, here.mode).surfaces
        return tuple(WatchedEvent(*key, terminal=key == (here.event, here.direction)) for key in surfaces)


def make_eventless(model: Model, mode: str) -> Segment:
    """Return the only segment of an orbit that meets no event in ``mode``.

    One that slides all along is put on its surface at its end: the flow alone keeps any distance from it.
    """
    return Segment(f"({mode})", mode, "", "any", find_return(model, mode), mode)


def is_rotation(a: Sequence[str], b: Sequence[str]) -> bool:
    """Return whether two signatures are the same up to where they begin."""
    return len(a) == len(b) and any(list(a) == [*b[i:], *b[:i]] for i in range(max(len(b), 1)))


def link_delayed_events(signature: Signature, p: Array, durations: Array) -> tuple[DelayedEventLink, ...]:
    """Return what set the time of each segment's end that is a delayed event, or made by a jump that comes back.

    The end of the segment lies at the end of its source plus the delay minus whole periods.

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
        if event is None:
            continue
        if event.after is None:
            links += _link_jump(signature, p, s, ends)
            continue
        delay = float(numeric.event_delay(event.name).value(p)[0])
        events = numeric.model.events
        sources = [a for a, other in enumerate(segments) if other.event and events[other.event].starts(event)]
        if not sources:
            raise SignatureError(
                f"segment '{segment.name}' ends at '{event.name}', which comes after '{event.after}', but no segment "
                f"of this orbit ends at '{event.after}'"
            )
        turns = [(ends[a] + delay - ends[s]) / period for a in sources]
        best = min(range(len(sources)), key=lambda i: abs(turns[i] - round(turns[i])))
        links.append(DelayedEventLink(s, sources[best], round(turns[best])))
    return tuple(links)


def _link_jump(signature: Signature, p: Array, s: int, ends: Array) -> list[DelayedEventLink]:
    """Return the link of a segment that ends where a delayed value jumps and carries its event function over zero.

    The function has no zero there, so that an equation cannot ask for one.
    """
    model, period = signature.numeric.model, float(ends[-1])
    tau = signature.numeric.delays.value(p)
    for a, other in enumerate(signature.segments):
        carriers = list_carriers(model, signature.segments[s].event, other.reset)
        for lag in (lag for lag in carriers if lag < len(tau)):
            turns = (ends[a] + float(tau[lag]) - ends[s]) / period
            if tau[lag] > 0.0 and abs(turns - round(turns)) < AT_JUMP:
                return [DelayedEventLink(s, a, round(turns), lag)]
    return []
