"""What can happen in a mode: the one place that says so.

A mode ends at the surfaces of event functions and at delayed events; an event starts the clocks of delayed ones; the
jump that a reset makes comes back through a delay and may carry an event function over its zero; and at a surface that
the next mode meets from its other side both vector fields may point at it. Simulations take their tables from here,
signatures what their segments watch and link, admissibility and the changes of signatures what may come in, whether or
not a signature lists it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import sympy
from sympy.logic.boolalg import Boolean

from pddecont.memo import cached_property
from pddecont.model.endings import Ending
from pddecont.model.mode_surfaces import list_surfaces
from pddecont.model.parts import IDENTITY, Form, Segment
from pddecont.model.repulsion import write_repulsion
from pddecont.model.switches import Digits
from pddecont.model.system import Model
from pddecont.model.ways import Decision

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
    segments = model.list_segments(mode)
    crossings = tuple(s for s in segments if model.events[s.event].function is not None)
    return Transitions(segments, crossings, tuple(s for s in segments if s not in crossings))


def list_endings(model: Model, mode: str) -> list[Ending]:
    """Return what ends a mode, each once, with what decides where it leads.

    Of a model by hand the modes that a segment may lead to are its options, by number.
    """
    if model.derived is not None:
        return model.derived.list_endings(mode)
    found = []
    for leader in list_leaders(model.list_segments(mode)):
        ways = list_alternatives(model, leader)
        options = tuple((number,) for number in range(len(ways)))
        decision = Decision((0,), options, tuple(way.guard for way in ways))
        found.append(Ending(leader, (0,), (decision,) if len(ways) > 1 else ()))
    return found


def list_way_digits(model: Model, ending: Ending) -> Iterator[Digits]:
    """Yield what tells the segments of an ending apart: the digits after each; of a model by hand a number."""
    return ending.list_digits() if model.derived is None else model.derived.list_way_digits(ending)


def find_way(model: Model, ending: Ending, digits: Digits) -> Segment:
    """Return the segment of an ending after which these digits hold; of a model by hand its number there."""
    if model.derived is None:
        return list_alternatives(model, ending.segment)[digits[0]]
    return model.derived.make_segment(ending, digits)


def find_field_form(model: Model, mode: str) -> Form:
    """Return the vector field of a mode in the form that modes share."""
    return Form(model.modes[mode]) if model.derived is None else model.derived.find_field_form(mode)


def find_event_form(model: Model, event: str) -> Form:
    """Return the function of an event in the form that modes share; 1 for a delayed event."""
    found = model.events[event]
    if found.form is not None:
        return found.form
    return Form((sympy.S.One if found.function is None else found.function,))


def find_reset_form(model: Model, reset: str) -> Form:
    """Return a reset in the form that modes share."""
    return Form(model.resets[reset]) if model.derived is None else model.derived.find_form(reset)


def list_shared_forms(model: Model, mode: str) -> tuple[list[Form], list[Form], list[Boolean]]:
    """Return the functions of events, the resets, and the conditions that modes like one have too."""
    derived = model.derived
    if derived is None:
        return [], [], []
    alike = derived.list_alike(mode)
    events = [event.form for ends in alike for event in ends.events.values() if event.form is not None]
    resets = [form for ends in alike for form in ends.resets.values()]
    endings = [ending for ends in alike for ending in ends.endings]
    rules = [rule for ending in endings for decision in ending.decisions for rule in decision.rules]
    first = (derived.make_unlisted(ending, next(derived.list_way_digits(ending))) for ending in endings)
    return events, resets, [*rules, *(write_repulsion(model, segment) for segment in first)]


def list_held(model: Model, mode: str) -> tuple[str, ...]:
    """Return the events on whose surfaces a motion slides in a mode."""
    return () if model.derived is None else list_surfaces(model.derived, mode)


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
    return tuple(way for way in model.list_ways(segment) if not way.rests)


def find_rest(model: Model, segment: Segment, mode: str | None = None) -> Segment | None:
    """Return what a segment is where it ends with the last of impacts that accumulate; None where no mode is said.

    ``mode`` is preferred to others in which the motion may rest.
    """
    ways = [way for way in model.list_rests(segment) if way.mode == segment.mode]
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
