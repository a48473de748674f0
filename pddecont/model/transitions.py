"""What can happen in a mode: the one place that says so.

A mode ends at the surfaces of event functions and at delayed events; an event starts the clocks of delayed ones; the
jump that a reset makes comes back through a delay and may carry an event function over its zero; and at a surface that
the next mode meets from its other side both vector fields may point at it. Simulations take their tables from here,
signatures what their segments watch and link, admissibility and the changes of signatures what may come in, whether or
not a signature lists it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

from pddecont.model.derived_modes import Crossing
from pddecont.model.parts import IDENTITY, Segment
from pddecont.model.system import Model

# The ways in which an event function passes zero that a direction stands for.
WAYS = {"rising": {"rising"}, "falling": {"falling"}, "any": {"rising", "falling"}}
OPPOSITE = {"rising": "falling", "falling": "rising"}


@dataclass(frozen=True)
class Transitions:
    """What can end a mode, in declared order: of what comes at one moment the first counts.

    Attributes
    ----------
    segments
        The segments that run in the mode.
    crossings
        Those that end where an event function crosses zero.
    expiries
        Those that end at a delayed event.
    """

    segments: tuple[Segment, ...]
    crossings: tuple[Segment, ...]
    expiries: tuple[Segment, ...]

    @cached_property
    def surfaces(self) -> dict[tuple[str, str], Segment]:
        """The segment that ends at each (event, direction)."""
        found: dict[tuple[str, str], Segment] = {}
        for segment in self.crossings:
            found.setdefault((segment.event, segment.direction), segment)
        return found

    @property
    def delayed_events(self) -> set[str]:
        """The delayed events that end the mode."""
        return {segment.event for segment in self.expiries}


def list_transitions(model: Model, mode: str) -> Transitions:
    """Return what can end a mode."""
    segments = model.segments_by_mode.get(mode, ())
    crossings = tuple(s for s in segments if model.events[s.event].function is not None)
    return Transitions(segments, crossings, tuple(s for s in segments if s not in crossings))


def list_opposite(model: Model) -> list[str | None]:
    """Return for each segment that leaves a surface the first one that leaves it to the other side; None for others."""
    found: dict[tuple[str, int, bool], str] = {}
    leaving: list[tuple[str, Crossing] | None] = []
    for segment in model.segments.values():
        crossing = None if model.derived is None else model.derived.find_crossing(segment)
        leaves = crossing is not None and crossing.leaves
        leaving.append((segment.mode, crossing) if crossing is not None and leaves else None)
        if crossing is not None and leaves:
            found.setdefault((segment.mode, crossing.switch, crossing.up), segment.name)
    return [None if own is None else found[own[0], own[1].switch, not own[1].up] for own in leaving]


def list_held(model: Model, mode: str) -> tuple[str, ...]:
    """Return the events on whose surfaces a motion slides in a mode."""
    return () if model.derived is None else model.derived.list_surfaces(mode)


def find_return(model: Model, mode: str) -> str:
    """Return the reset that puts states on the surfaces that a motion slides along in a mode; else identity."""
    return IDENTITY if model.derived is None else model.derived.find_return(mode)


def list_leaders(segments: Iterable[Segment]) -> tuple[Segment, ...]:
    """Return the first of each segment's alternatives: what ends is the same for all of them."""
    found: dict[str, Segment] = {}
    for segment in segments:
        found.setdefault(segment.written or segment.name, segment)
    return tuple(found.values())


def list_alternatives(model: Model, segment: Segment) -> tuple[Segment, ...]:
    """Return the segments that one may be, as the states after its reset decide; itself alone without a condition."""
    if not segment.written:
        return (segment,)
    return tuple(way for way in model.ways[segment.written] if not way.rests)


def find_rest(model: Model, segment: Segment, mode: str | None = None) -> Segment | None:
    """Return what a segment is where it ends with the last of impacts that accumulate; None where no mode is said.

    ``mode`` is preferred to others in which the motion may rest.
    """
    ways = [way for way in model.ways[segment.written or segment.name] if way.rests and way.mode == segment.mode]
    return next((way for way in ways if way.to == mode), next(iter(ways), None))


def list_clocks(model: Model, event: str) -> tuple[str, ...]:
    """Return the delayed events whose clocks an event starts."""
    return tuple(other.name for other in model.events.values() if model.events[event].starts(other))


def list_carriers(model: Model, event: str, reset: str) -> tuple[int, ...]:
    """Return the numbers of the delays through which the jump that a reset makes comes back to an event function."""
    function = model.events[event].function
    if function is None:
        return ()
    expressions = model.resets[reset]
    reads = zip(model.delayed, model.delayed_symbols, strict=True)
    found = (
        read.delay
        for read, symbol in reads
        if symbol in function.free_symbols and expressions[read.state] != model.state_symbols[read.state]
    )
    return tuple(dict.fromkeys(found))


def may_slide(model: Model, segment: Segment) -> bool:
    """Return whether both vector fields may point at the surface that a segment ends at.

    The mode that it leads to, another one, ends there too when the surface is met from its other side.
    """
    if segment.to == segment.mode:
        return False
    back = {OPPOSITE[way] for way in WAYS[segment.direction]}
    return any(
        s.event == segment.event and WAYS[s.direction] & back for s in list_transitions(model, segment.to).crossings
    )
