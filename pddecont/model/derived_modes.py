"""Modes, events, resets and segments made of equations with switches.

A mode is a set of digits. It ends where a switch's function crosses its surface, where the digit that keeps a motion on
a surface reaches its bound, and at the jumps of the model. All modes are named at once; what fields and conditions have
in common is worked out once.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from typing import Any

import sympy

from pddecont.errors import PddecontError
from pddecont.model.contacts import add_contacts, is_held
from pddecont.model.expression import TIME
from pddecont.model.parts import IDENTITY, Event, Segment
from pddecont.model.rest import find_resting, make_resting
from pddecont.model.sliding import Surfaces, find_surfaces, put_in
from pddecont.model.switches import ABOVE, BELOW, ON, Digits, Equations, Jump, name_digits
from pddecont.model.validation import ALTERNATIVE
from pddecont.model.vanishing import vanishes, vanishes_where
from pddecont.model.ways import Undecided, WayFinder, list_options

# All modes are named, with what ends them, before a motion starts.
MAX_MODES = 5000

Exprs = tuple[sympy.Expr, ...]
# How the names of resets begin that put states on the surfaces of a mode.
RETURN = "onto_"
# The words for leaving a surface to a side.
OFF = {ABOVE: "off_up", BELOW: "off_down"}


@dataclass(frozen=True)
class Crossing:
    """What a segment does with a switch: it meets its surface, or leaves it where it slid along it; up or down."""

    switch: int
    up: bool
    leaves: bool


class TooManyModesError(PddecontError):
    """A model has more modes than can be handled."""


class Fields(Mapping[str, Exprs]):
    """The vector fields of modes by name; each is worked out when it is asked for."""

    def __init__(self, surfaces: Surfaces) -> None:
        self.surfaces = surfaces
        self._digits: dict[str, Digits] = {}
        self._known: dict[str, Exprs] = {}

    def add(self, name: str, digits: Digits) -> None:
        """Add a mode."""
        self._digits[name] = digits

    def __getitem__(self, name: str) -> Exprs:
        """Return the field of a mode, one expression a state."""
        if name not in self._known:
            values = self.surfaces.find_values(self._digits[name])
            self._known[name] = tuple(put_in(f, values) for f in self.surfaces.equations.field)
        return self._known[name]

    def __iter__(self) -> Iterator[str]:
        """Return the names of the modes."""
        return iter(self._digits)

    def __len__(self) -> int:
        """Return the number of modes."""
        return len(self._digits)


@dataclass
class DerivedModes:
    """What is made of a model's equations: fields, events, resets and segments by name."""

    surfaces: Surfaces
    events: dict[str, Event] = field(default_factory=dict)
    resets: dict[str, Exprs] = field(default_factory=dict)
    segments: dict[str, Segment] = field(default_factory=dict)
    # What the segments that pass switches do, by their names as written.
    crossings: dict[str, Crossing] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.equations = self.surfaces.equations
        self.modes = Fields(self.surfaces)
        self.finder = WayFinder(self.surfaces)
        self.resets[IDENTITY] = self.equations.states

    def find_mode(self, digits: Digits) -> str:
        """Return the name of a mode; where a motion cannot slide it is above."""
        return self.build(
            tuple(ABOVE if d == ON and not s else d for d, s in zip(digits, self.surfaces.slides, strict=True))
        )

    def keep_states(self, kept: Sequence[int]) -> DerivedModes:
        """Return the same with these states alone; nothing that is left reads the others."""
        equations = self.equations.keep_states(kept)
        made = DerivedModes(replace(self.surfaces, equations=equations))
        made.build_all()
        return made

    @property
    def parts(self) -> dict[str, Any]:
        """Modes, events, resets and segments, by their names as fields of a model."""
        return {"modes": self.modes, "events": self.events, "resets": self.resets, "segments": self.segments}

    def find_crossing(self, segment: Segment) -> Crossing | None:
        """Return what a segment does with a switch; None for jumps."""
        return self.crossings.get(segment.written or segment.name)

    def find_jump_of_rate(self, switch: int, mode: str) -> sympy.Expr:
        """Return by how much du/dt of a switch grows across its surface: motions slide where it is negative."""
        low, high = self.surfaces.find_bounds(switch, self.find_digits(mode))
        return high - low

    def find_digits(self, mode: str) -> Digits:
        """Return the digits of a mode."""
        return self.equations.find_digits(mode) or ()

    def find_digit(self, mode: str, switch: int) -> int:
        """Return the digit of a switch in a mode."""
        return self.find_digits(mode)[switch]

    def list_exits(self, mode: str) -> list[tuple[str, Crossing]]:
        """Return the events at which motions cease to slide in a mode, and what they do."""
        digits = self.find_digits(mode)
        found = []
        for k, digit in enumerate(digits):
            for side in (ABOVE, BELOW) if digit == ON and self.equations.switches[k].contact is None else ():
                name = self._name_exit(k, digits, side)
                found.append((name, Crossing(k, side == ABOVE, leaves=True)))
        return found

    def find_surface(self, mode: str, event: str) -> int | None:
        """Return the switch whose surface an event is in a mode beside it; None for other events."""
        digits = self.find_digits(mode)
        switches = self.equations.switches
        beside = (
            k for k, d in enumerate(digits) if d != ON and not switches[k].remembers and switches[k].contact is None
        )
        return next((k for k in beside if self._name_surface(k, digits)[0] == event), None)

    def _name_exit(self, number: int, digits: Digits, side: int) -> str:
        """Return the name of the event at which a motion leaves a surface to a side."""
        switch, rate = self.equations.switches[number], self.surfaces.rates[number]
        assert rate is not None, "no motion slides along a surface whose rate is not known"
        word = OFF[side] if switch.contact is None else "off"
        return self._name_event(f"{switch.name}_{word}", rate, number, digits)[0]

    def list_surfaces(self, mode: str) -> tuple[str, ...]:
        """Return the events whose functions are the surfaces that a motion slides along in a mode."""
        digits = self.find_digits(mode)
        return tuple(name for name, _ in self._find_held(digits))

    def find_return(self, mode: str) -> str:
        """Return the reset that puts states on the surfaces that a motion slides along in a mode."""
        return RETURN + mode if RETURN + mode in self.resets else IDENTITY

    def _add_return(self, mode: str, digits: Digits) -> None:
        """Add the reset to the nearest states at which the functions of the surfaces of a mode are zero."""
        functions = [function for _, function in self._find_held(digits)]
        if functions:
            x, u = sympy.Matrix(self.equations.states), sympy.Matrix(functions)
            slopes = u.jacobian(x)
            square = slopes * slopes.T
            change = slopes.T * (square.adjugate() * u) / square.det(method="berkowitz")
            self.resets[RETURN + mode] = tuple(x - change)

    def _find_held(self, digits: Digits) -> Iterator[tuple[str, sympy.Expr]]:
        """Yield the functions that are zero along a motion, with their events: those of surfaces; places and speeds."""
        for k, digit in enumerate(digits):
            switch = self.equations.switches[k]
            if digit == ON and switch.contact is not None:
                yield self._name_event(switch.name, switch.contact, -1, digits)
                yield self._name_event(f"{switch.name}_speed", switch.argument, -1, digits)
            elif digit == ON:
                yield self._name_surface(k, digits)

    def _name_surface(self, number: int, digits: Digits) -> tuple[str, sympy.Expr]:
        """Return the name of the event at which a switch's function is zero, and the function."""
        switch = self.equations.switches[number]
        return self._name_event(switch.name, switch.argument, number, digits)

    def slide(self, on: tuple[int, ...]) -> Exprs:
        """Return the field along the surfaces of the switches ``on``, in terms of the digits of the others."""
        values = self.surfaces.solve(on)
        return tuple(put_in(f, values) for f in self.equations.field)

    def build_all(self) -> None:
        """Make every mode that there can be."""
        options = [self.surfaces.list_digits(k) for k in range(len(self.equations.switches))]
        number = math.prod(map(len, options))
        if number > MAX_MODES:
            raise TooManyModesError(
                f"the switches of these equations make {number} modes; at most {MAX_MODES} can be handled"
            )
        for digits in product(*(sorted(own) for own in options)):
            if self.surfaces.may_be(digits):
                self.build(digits)

    def build(self, digits: Digits) -> str:
        """Make a mode and what ends it, unless that is done; return its name."""
        name = self.equations.name_mode(digits)
        if name not in self.modes:
            self.modes.add(name, digits)
            self._add_return(name, digits)
            for segment in self._list_segments(digits):
                self.segments[segment.name] = segment
        return name

    def _list_segments(self, digits: Digits) -> Iterator[Segment]:
        tied = {self._find_tied(jump, digits) for jump in self.equations.jumps if self.equations.allows(jump, digits)}
        for jump in self.equations.jumps:
            yield from self._jump(jump, digits)
        for number, digit in enumerate(digits):
            if digit == ON:
                yield from self._leave(number, digits)
            elif number not in tied and self.equations.switches[number].contact is None:
                yield from self._cross(number, digits)

    def _find_tied(self, jump: Jump, digits: Digits) -> int | None:
        """Return the switch of time alone that a jump passes as it comes, such as the edge of a wave at each dose."""
        for k, switch in enumerate(self.equations.switches):
            passes = {BELOW: "rising", ABOVE: "falling"}.get(digits[k]) == jump.direction
            if passes and switch.argument == jump.function and not switch.remembers:
                return None if switch.argument.free_symbols & set(self.equations.states) else k
        return None

    def _cross(self, number: int, digits: Digits) -> Iterator[Segment]:
        """Yield what follows where a switch's function crosses its surface."""
        switch, rises = self.equations.switches[number], digits[number] == BELOW
        level = switch.high if rises else switch.low
        name, function = self._name_surface(number, digits)
        if switch.remembers:
            name = f"{name}_{'high' if rises else 'low'}"
        self._add_event(Event(name, function - level, source=switch.name))
        after = (*digits[:number], ABOVE if rises else BELOW, *digits[number + 1 :])
        if not self.surfaces.agree(after):
            # A parallel surface lies between.
            return
        undecided: dict[int, Undecided] = {}
        if self.surfaces.slides[number]:
            undecided[number] = Undecided((after[number], ON), on_surface=True)
        undecided |= self._find_disturbed(number, after)
        written = self._name_segment(f"{switch.name}_{'up' if rises else 'down'}", number, digits)
        direction = "rising" if rises else "falling"
        self.crossings[written] = Crossing(number, rises, leaves=False)
        yield from self._branch(Segment(written, "", name, direction, IDENTITY, ""), digits, after, undecided)

    def _leave(self, number: int, digits: Digits) -> Iterator[Segment]:
        """Yield what follows where a motion ceases to slide along a surface."""
        switch = self.equations.switches[number]
        lower, upper = self.surfaces.find_bounds(number, digits)
        for name, function in self._find_held(digits):
            self._add_event(Event(name, function, source=switch.name if switch.contact is None else ""))
        for digit, function, direction in ((ABOVE, upper, "rising"), (BELOW, lower, "falling")):
            if digit not in self.surfaces.list_digits(number):
                continue
            word = f"{switch.name}_{OFF[digit] if switch.contact is None else 'off'}"
            event = self._name_exit(number, digits, digit)
            self._add_event(Event(event, function))
            after = (*digits[:number], digit, *digits[number + 1 :])
            written = self._name_segment(word, number, digits)
            if switch.contact is None:
                self.crossings[written] = Crossing(number, digit == ABOVE, leaves=True)
            # The digit goes on where it comes to 0 or 1; torn off from farther apart it jumps.
            undecided = {} if switch.grip == 1 else self._find_disturbed(number, after)
            yield from self._branch(Segment(written, "", event, direction, IDENTITY, ""), digits, after, undecided)

    def _jump(self, jump: Jump, digits: Digits) -> Iterator[Segment]:
        """Yield what follows a jump: each digit is read from the states after it."""
        equations = self.equations
        if not equations.allows(jump, digits) or is_held(equations, jump, digits):
            return
        values = self.surfaces.find_values(digits)
        name = jump.name
        if jump.function is None:
            self._add_event(Event(name, None, jump.after, jump.delay, source=name))
        else:
            name, function = self._name_event(jump.name, jump.function, -1, digits)
            self._add_event(Event(name, function, source=jump.name))
        reset, body = self._name_reset(jump, digits)
        self.resets.setdefault(reset, body)
        changed = {x: g for x, g in zip(equations.states, body, strict=True) if g != x}
        undecided: dict[int, Undecided] = {}
        for k, switch in enumerate(equations.switches):
            u = put_in(switch.argument, values)
            if switch.contact is not None and digits[k] != ON:
                continue
            if digits[k] == ON and not u.free_symbols & set(changed):
                undecided[k] = list_options(self.surfaces, k, on_surface=True)
            elif u.free_symbols & set(changed):
                zero = not switch.remembers and vanishes(sympy.expand(u.xreplace(changed)))
                undecided[k] = list_options(self.surfaces, k, on_surface=zero)
        tied, after = self._find_tied(jump, digits), digits
        if tied is not None:
            after = (*digits[:tied], ABOVE if digits[tied] == BELOW else BELOW, *digits[tied + 1 :])
            undecided = self._find_disturbed(tied, after) | undecided
        written = self._name_segment(jump.name, -1, digits)
        segment = Segment(written, "", name, jump.direction, reset, "")
        yield from self._branch(segment, digits, after, undecided)
        yield from self._rest(segment, jump, digits)

    def _rest(self, segment: Segment, jump: Jump, digits: Digits) -> Iterator[Segment]:
        """Yield what a jump is where it is the last of those that accumulate: the motion rests."""
        for k, switch in enumerate(self.equations.switches):
            held = (*digits[:k], ON, *digits[k + 1 :])
            if switch.contact is not None and switch.name == jump.name and self.surfaces.may_slide(held):
                mode, to = self.equations.name_mode(digits), self.equations.name_mode(held)
                resting = make_resting(replace(segment, mode=mode), segment.name, to)
                self.resets[resting.reset] = find_resting(
                    self.equations.states, switch.argument, self.resets[segment.reset]
                )
                yield resting

    def _find_disturbed(self, number: int, digits: Digits) -> dict[int, Undecided]:
        """Return the other switches whose digits have to be read anew when one has changed."""
        found = {k: list_options(self.surfaces, k, on_surface=False) for k in self._shifted[number]}
        pushed = (k for k in self._pushed[number] if digits[k] == ON and k not in found)
        return found | {k: list_options(self.surfaces, k, on_surface=True) for k in pushed}

    @cached_property
    def _shifted(self) -> list[list[int]]:
        """The switches whose function jumps where the digit of each one changes."""
        return self._find_jumping([s.argument for s in self.equations.switches])

    @cached_property
    def _pushed(self) -> list[list[int]]:
        """The switches whose rate jumps where the digit of each one changes: a motion along them may be moved off."""
        return self._find_jumping([sympy.S.Zero if rate is None else rate for rate in self.surfaces.rates])

    def _find_jumping(self, exprs: list[sympy.Expr]) -> list[list[int]]:
        """Return for each switch the numbers of the expressions of others that jump at its surface."""
        moving, found = {*self.equations.states, TIME}, []
        for number, own in enumerate(self.equations.switches):
            reading = (k for k, e in enumerate(exprs) if k != number and own.digit in e.free_symbols)
            found.append([k for k in reading if not vanishes_where(exprs[k].diff(own.digit), own.argument, moving)])
        return found

    def _branch(
        self, segment: Segment, digits: Digits, after: Digits, undecided: dict[int, Undecided]
    ) -> Iterator[Segment]:
        """Yield a segment once for each way on."""
        mode, written = self.equations.name_mode(digits), segment.name
        if not self.surfaces.may_slide(after):
            # What held the motion on a surface is gone.
            held = {k: list_options(self.surfaces, k, on_surface=True) for k, d in enumerate(after) if d == ON}
            undecided = held | undecided
        ways = self.finder.list_ways(after, undecided)
        anew = tuple(k for k, u in undecided.items() if self.surfaces.slides[k] and {ABOVE, BELOW} <= set(u.options))
        for way in ways:
            to = self.equations.name_mode(way.digits)
            if len(ways) == 1:
                yield replace(segment, mode=mode, to=to, anew=anew)
            else:
                name = f"{written}{ALTERNATIVE}{to}"
                segment = replace(segment, written=written, anew=anew)
                yield replace(segment, name=name, mode=mode, to=to, guard=way.guard, rule=way.rule)

    def _name_segment(self, word: str, number: int, digits: Digits) -> str:
        """Return the name of a segment: the digits of the other switches, then what happens."""
        others = name_digits(self.equations.switches, digits, number)
        return f"{others}_{word}" if others else word

    def _name_event(self, word: str, expr: sympy.Expr, number: int, digits: Digits) -> tuple[str, sympy.Expr]:
        """Return the name of an event, with the digits on which its function depends, and the function."""
        switches = self.equations.switches
        read = {k for k, s in enumerate(switches) if k != number and s.digit in expr.free_symbols}
        if any(digits[k] == ON for k in read):
            read = {k for k in range(len(switches)) if k != number}
        if not read:
            return word, expr
        slides = number >= 0 and digits[number] == ON
        function = put_in(expr, self.surfaces.find_values(digits, number))
        if number >= 0 and not slides and switches[number].digit in function.free_symbols:
            # What holds the motion on another surface depends on the side of this one.
            read.add(number)
            function = put_in(function, self.surfaces.find_values(digits))
        words = (switches[k].word(digits[k]) for k in sorted(read))
        return "_".join(filter(None, [word, *words])), function

    def _name_reset(self, jump: Jump, digits: Digits) -> tuple[str, Exprs]:
        whole = sympy.Tuple(*jump.reset)
        name, body = self._name_event(jump.name, whole, -1, digits)
        return name, tuple(body)

    def _add_event(self, event: Event) -> None:
        self.events.setdefault(event.name, event)


def make_modes(equations: Equations) -> DerivedModes:
    """Return what is made of equations.

    Raises
    ------
    UndecidedSlidingError
        If the surfaces along which a motion slides do not determine how.
    """
    made = DerivedModes(find_surfaces(add_contacts(equations)))
    made.build_all()
    return made
