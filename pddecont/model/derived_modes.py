"""Modes, events, resets and segments made of equations with switches, as they are reached.

A mode is a set of digits. What ends it is worked out when something asks for it: a motion that comes to it, a signature
that names it. A model with few modes has them all built at once.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import Any

import sympy

from pddecont.errors import PddecontError
from pddecont.memo import cached_property
from pddecont.model.built_parts import BuiltParts
from pddecont.model.contacts import add_contacts
from pddecont.model.ending_names import list_event_digits, list_written_digits
from pddecont.model.endings import Crossing, Ending, EndingFinder, ModeEndings
from pddecont.model.parts import IDENTITY, Event, Form, Segment
from pddecont.model.rest import find_rate_along, find_resting, make_resting
from pddecont.model.sliding import Surfaces, find_surfaces, make_return, put_in
from pddecont.model.switches import ABOVE, BELOW, ON, Digits, Equations, find_bits, name_digits
from pddecont.model.validation import ALTERNATIVE
from pddecont.model.ways import choose_digits

# A model with no more modes than this, and no more segments from one event, has all of them built at once, so that
# lists of them are complete; of larger ones they hold what was reached.
FEW_MODES, FEW_WAYS = 32, 32

# Digits are bits of a number that says, too, which of a page's functions is meant.
MAX_SWITCHES = 48

Exprs = tuple[sympy.Expr, ...]
# How the names of resets begin that put states on the surfaces of a mode.
RETURN = "onto_"


class TooManySwitchesError(PddecontError):
    """A model has more switches than can be handled."""


class DerivedModes:
    """What is made of a model's equations: fields, events, resets and segments by name."""

    def __init__(
        self,
        surfaces: Surfaces,
        sticks: tuple[tuple[str, str], ...] = (),
        delayed: frozenset[sympy.Symbol] = frozenset(),
    ) -> None:
        self._sticks, self._delayed = sticks, delayed
        self.surfaces, self.equations = surfaces, surfaces.equations
        self.finder = EndingFinder(surfaces)
        self._modes: dict[str, Digits] = {}
        self._endings: dict[Digits, ModeEndings] = {}
        self._fields: dict[str, Exprs] = {}
        self._events: dict[str, Event] = {}
        self._resets: dict[str, Exprs] = {IDENTITY: self.equations.states}
        self._forms: dict[str, Form] = {IDENTITY: Form(self.equations.states)}
        self._segments: dict[str, Segment] = {}
        self._slid: dict[tuple[int, ...], Exprs] = {}
        self._lock = threading.RLock()
        for jump in () if self.builds_all else self.equations.jumps:
            if jump.function is None:
                # Its clock runs in modes in which it does not happen too.
                self._events[jump.name] = Event(jump.name, None, jump.after, jump.delay, source=jump.name)

    def __eq__(self, other: object) -> bool:
        """Return whether the same is made of both, whatever was reached."""
        return isinstance(other, DerivedModes) and (self.surfaces, self._sticks) == (other.surfaces, other._sticks)

    __hash__ = None  # type: ignore[assignment]

    def __getstate__(self) -> dict[str, Any]:
        """Return what is sent to another process: locks are made anew there."""
        return {name: value for name, value in self.__dict__.items() if name not in ("_lock", "modes", "parts")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Take what was sent."""
        self.__dict__.update(state)
        self._lock = threading.RLock()

    @cached_property
    def modes(self) -> Mapping[str, Exprs]:
        """The vector fields of modes by name."""
        return BuiltParts(self._modes, self._find_field)

    @cached_property
    def parts(self) -> dict[str, Any]:
        """Modes, events, resets and segments, by their names as fields of a model."""
        return {
            "modes": self.modes,
            "events": BuiltParts(self._events, self._find_event),
            "resets": BuiltParts(self._resets, self._find_reset),
            "segments": BuiltParts(self._segments, self._find_segment),
        }

    @cached_property
    def n_modes(self) -> int:
        """How many modes there may be."""
        return math.prod(len(self.surfaces.list_digits(k)) for k in range(len(self.surfaces.slides)))

    @property
    def builds_all(self) -> bool:
        """Whether the model has so few modes that all of them are built."""
        return self.n_modes <= FEW_MODES

    def build_all(self) -> None:
        """Build all modes, if they are few."""
        for digits in self._list_every() if self.builds_all else ():
            self.build(digits)

    def _list_every(self) -> Iterator[Digits]:
        options = (sorted(self.surfaces.list_digits(k)) for k in range(len(self.surfaces.slides)))
        return (digits for digits in product(*options) if self.surfaces.may_be(digits))

    def build_every(self, most: int) -> bool:
        """Build all modes with all their segments; return whether there are no more than ``most``."""
        if self.n_modes > most:
            return False
        for digits in self._list_every():
            for ending in self.list_endings(self.build(digits)):
                for after in self.list_way_digits(ending):
                    self.make_segment(ending, after)
                self.list_rests(ending)
        return True

    def build(self, digits: Digits) -> str:
        """Build the mode with some digits and what ends it, unless that is done; return its name."""
        name = self.equations.name_mode(digits)
        with self._lock:
            if name not in self._modes:
                ends = self.find_ends(digits)
                self._modes[name] = digits
                for event in ends.events.values():
                    self._events.setdefault(event.name, event)
                for reset, form in ends.resets.items():
                    self._forms.setdefault(reset, form)
                    self._resets.setdefault(reset, self._put_in(form, digits))
                if self.builds_all:
                    self.list_segments(name)
        return name

    def find_mode(self, digits: Digits) -> str:
        """Return the name of a mode; where a motion cannot slide it is above."""
        return self.build(
            tuple(ABOVE if d == ON and not s else d for d, s in zip(digits, self.surfaces.slides, strict=True))
        )

    def find_digits(self, mode: str) -> Digits:
        """Return the digits of a mode."""
        return self.look_up(mode) or ()

    def look_up(self, mode: str) -> Digits | None:
        """Return the digits of a mode by its name; None if there is no such mode."""
        known = self._modes.get(mode)
        if known is not None:
            return known
        digits = self.equations.find_digits(mode)
        if digits is None or any(d not in self.surfaces.list_digits(k) for k, d in enumerate(digits)):
            return None
        return digits if self.surfaces.may_be(digits) else None

    def add_rests(self, sticks: Sequence[tuple[str, str]], delayed: Collection[sympy.Symbol]) -> DerivedModes:
        """Return the same where impacts that accumulate at events come to rest in modes: pairs (event, mode)."""
        if set(sticks) <= set(self._sticks):
            return self
        return make_modes_of(self.surfaces, (*self._sticks, *sticks), frozenset(delayed))

    def find_ends(self, digits: Digits) -> ModeEndings:
        """Return what ends the mode with some digits, which is not listed for that."""
        with self._lock:
            if digits not in self._endings:
                ends = self.finder.find(digits)
                ends.endings = [self._let_rest(ending, ends) for ending in ends.endings]
                self._endings[digits] = ends
            return self._endings[digits]

    def _let_rest(self, ending: Ending, ends: ModeEndings) -> Ending:
        """Return an ending with the modes in which its motions rest that are named apart from the equations."""
        own, rests = ending.segment, list(ending.rests)
        for event, mode in self._sticks:
            held = self.look_up(mode) if event == own.event else None
            resting = make_resting(own, own.name, mode)
            if held is not None and all(resting.name != known.name for known, _ in rests):
                rests.append((resting, held))
                reset, function = ends.resets.get(own.reset), ends.events[own.event].function
                rate = find_rate_along(function or sympy.S.Zero, self.equations.states, self.modes[own.mode])
                before = self.equations.states if reset is None else self._put_in(reset, self.find_digits(own.mode))
                read = rate.free_symbols | (function or sympy.S.Zero).free_symbols
                known = function is not None and not read & self._delayed
                after = find_resting(self.equations.states, rate, before) if known else before
                ends.resets[resting.reset] = Form(after)
        return replace(ending, rests=tuple(rests))

    def list_endings(self, mode: str) -> list[Ending]:
        """Return what ends a mode, which is built if it was not."""
        digits = self.look_up(mode)
        if digits is None:
            return []
        self.build(digits)
        return self.find_ends(digits).endings

    def list_segments(self, mode: str) -> list[Segment]:
        """Return the segments that run in a mode; of an ending that may lead to many modes the first one."""
        found = []
        for ending in self.list_endings(mode):
            every = self.list_way_digits(ending)
            few = every if ending.n_ways <= FEW_WAYS else [next(every)]
            found += [self.make_segment(ending, digits) for digits in few]
            found += self.list_rests(ending)
        return found

    def list_way_digits(self, ending: Ending) -> Iterator[Digits]:
        """Yield the digits of the modes that an ending may lead to."""
        return (digits for digits in ending.list_digits() if self.surfaces.may_be(digits))

    def list_rests(self, ending: Ending) -> list[Segment]:
        """Return what the segment of an ending is where the motion comes to rest."""
        with self._lock:
            return [self._segments.setdefault(resting.name, resting) for resting, _ in ending.rests]

    def make_segment(self, ending: Ending, digits: Digits) -> Segment:
        """Return the segment of an ending that leads to the mode with some digits."""
        name = self._name_way(ending, digits)
        with self._lock:
            if name not in self._segments:
                self._segments[name] = self.make_unlisted(ending, digits)
            return self._segments[name]

    def make_unlisted(self, ending: Ending, digits: Digits) -> Segment:
        """Return the same, which is not listed for that."""
        made = replace(ending.segment, name=self._name_way(ending, digits), to=self.equations.name_mode(digits))
        if ending.n_ways == 1:
            return made
        guard = self.finder.finder.find_guard(ending.decisions, digits)
        return replace(made, written=ending.segment.name, guard=guard)

    def _name_way(self, ending: Ending, digits: Digits) -> str:
        if ending.n_ways == 1:
            return ending.segment.name
        return f"{ending.segment.name}{ALTERNATIVE}{self.equations.name_mode(digits)}"

    def choose(self, ending: Ending, numbers: Mapping[sympy.Symbol, float]) -> Digits:
        """Return the digits that follow an ending where symbols have these ``numbers``."""
        return choose_digits(self.surfaces, ending.after, ending.undecided, numbers)

    def find_ending(self, segment: Segment) -> Ending:
        """Return the ending that a segment is of."""
        written = segment.written or segment.name
        return next(e for e in self.list_endings(segment.mode) if e.segment.name == written)

    def list_ways(self, segment: Segment) -> tuple[Segment, ...]:
        """Return the segments that one may be; of one with many ways those asked for so far."""
        written, ending = segment.written or segment.name, self.find_ending(segment)
        if ending.n_ways <= FEW_WAYS:
            ways = [self.make_segment(ending, digits) for digits in self.list_way_digits(ending)]
        else:
            ways = [s for s in list(self._segments.values()) if s.written == written and not s.rests]
        return (*ways, *self.list_rests(ending))

    def find_form(self, reset: str) -> Form:
        """Return a reset in the digits of the switches."""
        return self._forms[reset]

    def find_field_form(self, mode: str) -> Form:
        """Return the vector field of a mode in the digits of the switches along which it does not slide."""
        digits = self.find_digits(mode)
        on = tuple(k for k, d in enumerate(digits) if d == ON)
        if on not in self._slid:
            values = self.surfaces.solve(on)
            self._slid[on] = tuple(put_in(f, values) for f in self.equations.field)
        return Form(self._slid[on], find_bits(digits))

    def list_alike(self, mode: str) -> list[ModeEndings]:
        """Return what ends the modes that slide along the same surfaces, below and above all others.

        Between them they have the conditions and functions that such modes have.
        """
        own, switches = self.find_digits(mode), self.equations.switches
        digits = dict.fromkeys(tuple(d if d == ON else side for d in own) for side in (BELOW, ABOVE))
        free = [
            tuple(d if s.contact is None or d == ON else s.free for d, s in zip(alike, switches, strict=True))
            for alike in digits
        ]
        return [self.find_ends(d) for d in dict.fromkeys(free) if self.surfaces.may_be(d)]

    def keep_states(self, kept: Sequence[int]) -> DerivedModes:
        """Return the same with these states alone; nothing that is left reads the others."""
        surfaces = replace(self.surfaces, equations=self.equations.keep_states(kept))
        return make_modes_of(surfaces, self._sticks, self._delayed)

    def name_briefly(self, ending: Ending) -> str:
        """Return the name of an ending's segment without the digits of other switches."""
        digits = self.find_digits(ending.segment.mode)
        number = -1 if ending.crossing is None else ending.crossing.switch
        return ending.segment.name.removeprefix(name_digits(self.equations.switches, digits, number)).removeprefix("_")

    def has_ending(self, written: str) -> bool:
        """Return whether a segment has this name, whatever it leads to."""
        modes = (self.equations.name_mode(digits) for digits in list_written_digits(self.equations, written))
        return any(ending.segment.name == written for mode in modes for ending in self.list_endings(mode))

    def find_crossing(self, segment: Segment) -> Crossing | None:
        """Return what a segment does with a switch; None for jumps."""
        return self.find_ending(segment).crossing if segment.event else None

    def find_return(self, mode: str) -> str:
        """Return the reset that puts states on the surfaces that a motion slides along in a mode."""
        return RETURN + mode if ON in self.find_digits(mode) else IDENTITY

    def _put_in(self, form: Form, digits: Digits) -> Exprs:
        values = self.surfaces.find_values(digits)
        return tuple(put_in(e, values) for e in form.exprs)

    def _find_field(self, mode: str) -> Exprs | None:
        if mode not in self._fields:
            digits = self.look_up(mode)
            if digits is None:
                return None
            values = self.surfaces.find_values(digits)
            self._fields[mode] = tuple(put_in(f, values) for f in self.equations.field)
        return self._fields[mode]

    def _find_event(self, name: str) -> Event | None:
        if name not in self._events:
            for digits in list_event_digits(self.equations, name):
                found = self.surfaces.may_slide(digits) and self.find_ends(digits).events.get(name)
                if found:
                    self._events.setdefault(name, found)
                    break
        return self._events.get(name)

    def _find_reset(self, name: str) -> Exprs | None:
        if name not in self._resets and name.startswith(RETURN):
            digits = self.find_digits(name.removeprefix(RETURN))
            if ON in digits:
                held = (event.function for event in self.finder.list_held(digits))
                self._resets[name] = make_return(self.equations.states, [h for h in held if h is not None])
        elif name not in self._resets and ALTERNATIVE in name:
            # Those of motions that come to rest are called as their segments.
            self._find_segment(name)
        return self._resets.get(name)

    def _find_segment(self, name: str) -> Segment | None:
        written, _, to = name.partition(ALTERNATIVE)
        if name not in self._segments:
            for digits in list_written_digits(self.equations, written):
                endings = self.list_endings(self.equations.name_mode(digits))
                after = self.look_up(to) if to else None
                for ending in endings:
                    if ending.segment.name == written and any(s.name == name for s in self.list_rests(ending)):
                        break
                    if ending.segment.name != written or (ending.n_ways > 1) != bool(to):
                        continue
                    if after is None and not to:
                        return self.make_segment(ending, next(self.list_way_digits(ending)))
                    if after is not None and ending.may_lead_to(after):
                        return self.make_segment(ending, after)
        return self._segments.get(name)


def make_modes(equations: Equations) -> DerivedModes:
    """Return what is made of equations.

    Raises
    ------
    UndecidedSlidingError
        If the surfaces along which a motion slides do not determine how.
    TooManySwitchesError
        If there are more switches than can be handled.
    """
    pushed = add_contacts(equations)
    n = len(pushed.switches)
    if n > MAX_SWITCHES:
        raise TooManySwitchesError(f"these equations have {n} switches; at most {MAX_SWITCHES} can be handled")
    return make_modes_of(find_surfaces(pushed))


def make_modes_of(
    surfaces: Surfaces, sticks: tuple[tuple[str, str], ...] = (), delayed: frozenset[sympy.Symbol] = frozenset()
) -> DerivedModes:
    """Return what is made of equations whose surfaces are known; motions rest in the modes that ``sticks`` name."""
    made = DerivedModes(surfaces, sticks, delayed)
    made.build_all()
    return made
