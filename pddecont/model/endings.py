"""What ends a mode of equations with switches, and where motions may go on: worked out mode by mode.

A mode ends where a switch's function crosses its surface, where the digit that keeps a motion on a surface reaches its
bound, and at the jumps of the model.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import product

import sympy

from pddecont.memo import cached_property
from pddecont.model.contacts import is_held
from pddecont.model.expression import TIME
from pddecont.model.parts import IDENTITY, Event, Form, Segment
from pddecont.model.rest import find_resting, make_resting
from pddecont.model.sliding import FIXED, Surfaces, put_in
from pddecont.model.switches import ABOVE, BELOW, ON, OPEN, Digits, Jump, find_bits, name_digits
from pddecont.model.vanishing import vanishes, vanishes_where
from pddecont.model.ways import Decision, Undecided, WayFinder, list_options

# The words for leaving a surface to a side.
OFF, OFF_CONTACT = {ABOVE: "off_up", BELOW: "off_down"}, "off"


@dataclass(frozen=True)
class Crossing:
    """What a segment does with a switch: it meets its surface, or leaves it where it slid along it; up or down."""

    switch: int
    up: bool
    leaves: bool


@dataclass(frozen=True)
class Ending:
    """How a mode ends: its segment, whatever it leads to, and what decides the digits that follow.

    ``after`` are the digits behind the event, of which ``undecided`` are those that the ``decisions`` choose.
    """

    segment: Segment
    after: Digits
    decisions: tuple[Decision, ...] = ()
    undecided: Mapping[int, Undecided] = field(default_factory=dict)
    crossing: Crossing | None = None
    # What the segment is where its event accumulates and the motion rests, with the digits that hold it.
    rests: tuple[tuple[Segment, Digits], ...] = ()

    @property
    def n_ways(self) -> int:
        """How many sets of digits may follow, or more."""
        return math.prod(len(decision.options) for decision in self.decisions)

    def list_digits(self) -> Iterator[Digits]:
        """Yield the digits that may follow, some of which may exclude each other."""
        for chosen in product(*(decision.options for decision in self.decisions)):
            digits = list(self.after)
            for decision, option in zip(self.decisions, chosen, strict=True):
                for k, digit in zip(decision.numbers, option, strict=True):
                    digits[k] = digit
            yield tuple(digits)

    def may_lead_to(self, digits: Digits) -> bool:
        """Return whether some digits of a mode may follow."""
        fixed = set(range(len(digits))).difference(*(d.numbers for d in self.decisions))
        chosen = (d.is_open or tuple(digits[k] for k in d.numbers) in d.options for d in self.decisions)
        return all(digits[k] == self.after[k] for k in fixed) and all(chosen)


@dataclass
class ModeEndings:
    """All that ends one mode, with the events and resets that it names."""

    endings: list[Ending] = field(default_factory=list)
    events: dict[str, Event] = field(default_factory=dict)
    resets: dict[str, Form] = field(default_factory=dict)


@dataclass
class EndingFinder:
    """Finds what ends a mode; what all modes share is worked out once."""

    surfaces: Surfaces

    def __post_init__(self) -> None:
        self.equations = self.surfaces.equations
        self.finder = WayFinder(self.surfaces)

    def find(self, digits: Digits) -> ModeEndings:
        """Return what ends the mode with some digits."""
        found = ModeEndings()
        tied = {self._find_tied(jump, digits) for jump in self.equations.jumps if self.equations.allows(jump, digits)}
        for jump in self.equations.jumps:
            if self.equations.allows(jump, digits) and not is_held(self.equations, jump, digits):
                self._jump(jump, digits, found)
        for number, digit in enumerate(digits):
            if digit == ON:
                self._leave(number, digits, found)
            elif number not in tied and self.equations.switches[number].contact is None:
                self._cross(number, digits, found)
        return found

    def name_surface(self, number: int, digits: Digits) -> Event:
        """Return the event at which a switch's function is zero."""
        switch = self.equations.switches[number]
        return self._make_event(switch.name, switch.argument, number, digits, switch.name)

    def name_exit(self, number: int, digits: Digits, side: int) -> Event:
        """Return the event at which a motion leaves a surface to a side."""
        switch, rate = self.equations.switches[number], self.surfaces.rates[number]
        assert rate is not None, "no motion slides along a surface whose rate is not known"
        word = OFF[side] if switch.contact is None else OFF_CONTACT
        event = self._make_event(f"{switch.name}_{word}", rate, number, digits, "")
        bound = FIXED[switch.free] if switch.contact is not None else switch.bounds[side == ABOVE]
        assert event.form is not None
        form = Form(tuple(put_in(e, {switch.digit: bound}) for e in event.form.exprs), event.form.bits)
        return Event(event.name, self.surfaces.find_rate(number, digits, bound), form=form)

    def list_held(self, digits: Digits) -> Iterator[Event]:
        """Yield the events whose functions are zero along a motion: those of surfaces; places and speeds at rest."""
        for k, digit in enumerate(digits):
            switch = self.equations.switches[k]
            if digit == ON and switch.contact is not None:
                yield self._make_event(switch.name, switch.contact, -1, digits, "")
                yield self._make_event(f"{switch.name}_speed", switch.argument, -1, digits, "")
            elif digit == ON:
                yield self.name_surface(k, digits)

    def _find_tied(self, jump: Jump, digits: Digits) -> int | None:
        """Return the switch of time alone that a jump passes as it comes, such as the edge of a wave at each dose."""
        for k, switch in enumerate(self.equations.switches):
            passes = {BELOW: "rising", ABOVE: "falling"}.get(digits[k]) == jump.direction
            if passes and switch.argument == jump.function and not switch.remembers:
                return None if switch.argument.free_symbols & set(self.equations.states) else k
        return None

    def _cross(self, number: int, digits: Digits, found: ModeEndings) -> None:
        """Add what follows where a switch's function crosses its surface."""
        switch, rises = self.equations.switches[number], digits[number] == BELOW
        event = self.name_surface(number, digits)
        if switch.remembers:
            level = switch.high if rises else switch.low
            assert event.function is not None and event.form is not None
            form = Form((event.form.exprs[0] - level,), event.form.bits)
            name = f"{event.name}_{'high' if rises else 'low'}"
            event = Event(name, event.function - level, source=switch.name, form=form)
        found.events.setdefault(event.name, event)
        after = (*digits[:number], ABOVE if rises else BELOW, *digits[number + 1 :])
        if not self.surfaces.agree(after):
            # A parallel surface lies between.
            return
        undecided: dict[int, Undecided] = {}
        if self.surfaces.slides[number]:
            undecided[number] = Undecided((after[number], ON), on_surface=True)
        undecided |= self._find_disturbed(number, after)
        written = self._name_segment(f"{switch.name}_{'up' if rises else 'down'}", number, digits)
        segment = Segment(written, "", event.name, "rising" if rises else "falling", IDENTITY, "")
        self._end(found, segment, digits, after, undecided, Crossing(number, rises, leaves=False))

    def _leave(self, number: int, digits: Digits, found: ModeEndings) -> None:
        """Add what follows where a motion ceases to slide along a surface."""
        switch = self.equations.switches[number]
        for event in self.list_held(digits):
            found.events.setdefault(event.name, event)
        for digit, direction in ((ABOVE, "rising"), (BELOW, "falling")):
            if digit not in self.surfaces.list_digits(number):
                continue
            event = self.name_exit(number, digits, digit)
            found.events.setdefault(event.name, event)
            after = (*digits[:number], digit, *digits[number + 1 :])
            is_contact = switch.contact is not None
            written = self._name_segment(f"{switch.name}_{OFF_CONTACT if is_contact else OFF[digit]}", number, digits)
            crossing = None if is_contact else Crossing(number, digit == ABOVE, leaves=True)
            # The digit goes on where it comes to 0 or 1; torn off from farther apart it jumps.
            undecided = {} if switch.grip == 1 else self._find_disturbed(number, after)
            segment = Segment(written, "", event.name, direction, IDENTITY, "")
            self._end(found, segment, digits, after, undecided, crossing)

    def _jump(self, jump: Jump, digits: Digits, found: ModeEndings) -> None:
        """Add what follows a jump: each digit is read from the states after it."""
        equations = self.equations
        if jump.function is None:
            event = Event(jump.name, None, jump.after, jump.delay, source=jump.name)
        else:
            event = self._make_event(jump.name, jump.function, -1, digits, jump.name)
        found.events.setdefault(event.name, event)
        reset, form = self._find_form(jump.name, jump.reset, -1, digits)
        found.resets.setdefault(reset, form)
        values = self.surfaces.find_values(digits)
        body = tuple(put_in(g, values) for g in jump.reset)
        changed = {x: g for x, g in zip(equations.states, body, strict=True) if g != x}
        undecided: dict[int, Undecided] = {}
        for k, switch in enumerate(equations.switches):
            u = put_in(switch.argument, values)
            if switch.contact is not None and digits[k] != ON:
                continue
            if digits[k] == ON and not u.free_symbols & set(changed):
                undecided[k] = list_options(self.surfaces, k, on_surface=True)
            elif u.free_symbols & set(changed):
                zero = not switch.remembers and self._is_zero(u.xreplace(changed))
                undecided[k] = list_options(self.surfaces, k, on_surface=zero)
        undecided |= self._find_hanging(digits, undecided)
        tied, after = self._find_tied(jump, digits), digits
        if tied is not None:
            after = (*digits[:tied], ABOVE if digits[tied] == BELOW else BELOW, *digits[tied + 1 :])
            undecided = self._find_disturbed(tied, after) | undecided
        written = self._name_segment(jump.name, -1, digits)
        self._end(found, Segment(written, "", event.name, jump.direction, reset, ""), digits, after, undecided)
        self._rest(jump, digits, form, found)

    def _find_hanging(self, digits: Digits, undecided: Mapping[int, Undecided]) -> dict[int, Undecided]:
        """Return the other switches whose functions hold digits that are read anew, or hang on such ones.

        What these digits were says nothing of such a function where others have jumped.
        """
        switches, found = self.equations.switches, dict(undecided)
        while True:
            values = self.surfaces.find_values(tuple(OPEN if k in found else d for k, d in enumerate(digits)))
            anew = {switches[k].digit for k in found}
            hanging = [
                k
                for k, switch in enumerate(switches)
                if k not in found
                and (switch.contact is None or digits[k] == ON)
                and put_in(switch.argument, values).free_symbols & anew
            ]
            if not hanging:
                return {k: u for k, u in found.items() if k not in undecided}
            found |= {k: list_options(self.surfaces, k, on_surface=False) for k in hanging}

    def _rest(self, jump: Jump, digits: Digits, reset: Form, found: ModeEndings) -> None:
        """Add what a jump is where it is the last of those that accumulate: the motion rests."""
        for k, switch in enumerate(self.equations.switches):
            held = (*digits[:k], ON, *digits[k + 1 :])
            if switch.contact is not None and switch.name == jump.name and self.surfaces.may_slide(held):
                ending = found.endings[-1]
                resting = make_resting(ending.segment, ending.segment.name, self.equations.name_mode(held))
                found.endings[-1] = replace(ending, rests=((resting, held),))
                key = switch.argument, reset.exprs
                if key not in self._resting:
                    self._resting[key] = find_resting(self.equations.states, *key)
                found.resets[resting.reset] = Form(self._resting[key], reset.bits)

    def _find_disturbed(self, number: int, digits: Digits) -> dict[int, Undecided]:
        """Return the other switches whose digits have to be read anew when one has changed."""
        found = {k: list_options(self.surfaces, k, on_surface=False) for k in self._shifted[number]}
        found |= self._find_hanging(digits, found)
        pushed = (k for k in self._pushed[number] if digits[k] == ON and k not in found)
        return found | {k: list_options(self.surfaces, k, on_surface=True) for k in pushed}

    def _is_zero(self, expr: sympy.Expr) -> bool:
        """Return whether an expression is zero throughout; modes ask for the same ones again and again."""
        if expr not in self._zero:
            self._zero[expr] = vanishes(sympy.expand(expr))
        return self._zero[expr]

    @cached_property
    def _resting(self) -> dict[tuple[sympy.Expr, tuple[sympy.Expr, ...]], tuple[sympy.Expr, ...]]:
        return {}

    @cached_property
    def _zero(self) -> dict[sympy.Expr, bool]:
        return {}

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

    def _end(
        self,
        found: ModeEndings,
        segment: Segment,
        digits: Digits,
        after: Digits,
        undecided: Mapping[int, Undecided],
        crossing: Crossing | None = None,
    ) -> None:
        """Add an ending with what decides where it leads."""
        if not self.surfaces.may_slide(after):
            # What held the motion on a surface is gone.
            held = {k: list_options(self.surfaces, k, on_surface=True) for k, d in enumerate(after) if d == ON}
            undecided = held | dict(undecided)
        mode = self.equations.name_mode(digits)
        slides = self.surfaces.slides
        anew = tuple(k for k, u in undecided.items() if slides[k] and {ABOVE, BELOW} <= set(u.options))
        own = replace(segment, mode=mode, anew=anew)
        decisions = self.finder.list_decisions(after, undecided)
        found.endings.append(Ending(own, after, decisions, undecided, crossing))

    def _name_segment(self, word: str, number: int, digits: Digits) -> str:
        """Return the name of a segment: the digits of the other switches, then what happens."""
        others = name_digits(self.equations.switches, digits, number)
        return f"{others}_{word}" if others else word

    def _make_event(self, word: str, expr: sympy.Expr, number: int, digits: Digits, source: str) -> Event:
        name, form = self._find_form(word, (expr,), number, digits)
        return Event(name, self._put_in(expr, number, digits), source=source, form=form)

    def _find_form(self, word: str, exprs: tuple[sympy.Expr, ...], number: int, digits: Digits) -> tuple[str, Form]:
        """Return the name of expressions, with the digits on which they depend, and their form that modes share."""
        switches = self.equations.switches
        symbols = set().union(*(e.free_symbols for e in exprs))
        read = {k for k, s in enumerate(switches) if k != number and s.digit in symbols}
        if not read:
            return word, Form(exprs)
        if any(digits[k] == ON for k in read):
            read = {k for k in range(len(switches)) if k != number}
        on = tuple(k for k, d in enumerate(digits) if d == ON and k != number)
        values = self.surfaces.solve(on)
        own = tuple(put_in(e, values) for e in exprs)
        if number >= 0 and digits[number] != ON and any(switches[number].digit in e.free_symbols for e in own):
            # What holds the motion on another surface depends on the side of this one.
            read.add(number)
        words = filter(None, (switches[k].word(digits[k]) for k in sorted(read)))
        held = set().union(*(e.free_symbols for e in own))
        bits = find_bits(tuple(d if s.digit in held else BELOW for s, d in zip(switches, digits, strict=True)))
        return "_".join([word, *words]), Form(own, bits)

    def _put_in(self, expr: sympy.Expr, number: int, digits: Digits) -> sympy.Expr:
        """Return an expression with the digits of a mode, but for that of a switch along which a motion slides."""
        free = number if number >= 0 and digits[number] == ON else -1
        return put_in(expr, self.surfaces.find_values(digits, free))
