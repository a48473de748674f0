"""Equations with switches: what a file with nonsmooth functions says, before modes are made of it.

Each argument of a nonsmooth function is a switch. Its digit is 0 below the surface where the argument is zero and 1
above it; between the two values a motion slides along the surface, and the digit is the weight of the two sides.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import sympy

# What the digit of a switch says, and the words for it in names of modes.
BELOW, ABOVE, ON = 0, 1, 2
# Instead of a digit: it is not put in, and its symbol stands.
OPEN = -1
WORDS = ("below", "above", "on")
# The word for a contact that holds a motion.
RESTING = "rest"
# One digit for each switch.
Digits: TypeAlias = tuple[int, ...]


@dataclass(frozen=True)
class Switch:
    """An argument on whose sign a law depends.

    Attributes
    ----------
    name
        Its name in the file, or one made of the states it reads.
    digit
        The symbol for its digit in expressions.
    argument
        The switching function u; it may hold digits of other switches.
    low, high
        The digit falls to 0 where u falls through ``low`` and rises to 1 where it rises through ``high``. Where the two
        are not the same the digit between them is the last one: a relay with memory.
    grip
        How much more than the jump of the law holds a motion that has come to slide: static by kinetic friction.
    """

    name: str
    digit: sympy.Symbol
    argument: sympy.Expr
    low: sympy.Expr = sympy.S.Zero
    high: sympy.Expr = sympy.S.Zero
    grip: sympy.Expr = sympy.S.One
    # How fast the delayed values in u change it; None where that is not known.
    drift: sympy.Expr | None = sympy.S.Zero
    # Of a contact: the function whose rate u is, and the digit of motions that are free; the digit is the force.
    contact: sympy.Expr | None = None
    free: int = BELOW

    @property
    def remembers(self) -> bool:
        """Whether the digit depends on the past."""
        return bool(self.low != self.high)

    def word(self, digit: int) -> str:
        """Return a digit with the switch's name, as names of modes have it; a contact is named where it holds."""
        if self.contact is None:
            return f"{self.name}_{WORDS[digit]}"
        return f"{self.name}_{RESTING}" if digit == ON else ""

    @property
    def bounds(self) -> tuple[sympy.Expr, sympy.Expr]:
        """The digits between which a motion slides: 0 and 1, or farther apart by the grip."""
        return (1 - self.grip) / 2, (1 + self.grip) / 2


@dataclass(frozen=True)
class Jump:
    """An event that changes states: where ``function`` is zero, or ``delay`` after the event ``after``.

    ``reset`` holds one expression a state. It happens where ``when``, an expression in digits, is 1.
    """

    name: str
    function: sympy.Expr | None
    direction: str
    after: str | None
    delay: sympy.Expr | None
    reset: tuple[sympy.Expr, ...]
    when: sympy.Expr = sympy.S.One
    # Whether a motion rests at the zero of ``function`` after impacts that accumulate.
    rests: bool = False


@dataclass(frozen=True)
class Equations:
    """Vector field, switches and jumps; expressions hold the switches' digits."""

    states: tuple[sympy.Symbol, ...]
    field: tuple[sympy.Expr, ...]
    switches: tuple[Switch, ...]
    jumps: tuple[Jump, ...]

    def __post_init__(self) -> None:
        assert len(self.field) == len(self.states)

    def change(self, put_in: Callable[[sympy.Expr], sympy.Expr], dropped: Collection[str]) -> Equations:
        """Return the equations with every expression changed, without the jumps ``dropped`` and those after them.

        Switches that decide nothing any more are gone; one whose argument is zero throughout has sign 0. Contacts are
        gone too: they are made anew of what is left.
        """
        if any(s.contact is not None for s in self.switches):
            return self.leave_out_contacts().change(put_in, dropped)
        kept = [j for j in self.jumps if j.name not in dropped]
        while any(j.after is not None and not self._happens(j.after, kept) for j in kept):
            kept = [j for j in kept if j.after is None or self._happens(j.after, kept)]
        jumps = [
            replace(
                j,
                function=None if j.function is None else put_in(j.function),
                delay=None if j.delay is None else put_in(j.delay),
                reset=tuple(map(put_in, j.reset)),
                when=put_in(j.when),
            )
            for j in kept
        ]
        switches = [
            replace(
                s,
                argument=put_in(s.argument),
                low=put_in(s.low),
                high=put_in(s.high),
                grip=put_in(s.grip),
                drift=None if s.drift is None else put_in(s.drift),
            )
            for s in self.switches
        ]
        zero = {s.digit: sympy.Rational(1, 2) for s in switches if s.argument == 0 and not s.remembers}
        changed = Equations(
            self.states,
            tuple(put_in(f).xreplace(zero) for f in self.field),
            tuple(replace(s, argument=s.argument.xreplace(zero)) for s in switches),
            tuple(jumps),
        )
        return changed.leave_out_idle()

    def leave_out_contacts(self) -> Equations:
        """Return the equations without the forces of contacts."""
        free = {s.digit: sympy.Integer(s.free) for s in self.switches if s.contact is not None}
        switches = tuple(s for s in self.switches if s.contact is None)
        return replace(self, field=tuple(f.xreplace(free) for f in self.field), switches=switches)

    def add_states(self, states: tuple[sympy.Symbol, ...], field: tuple[sympy.Expr, ...]) -> Equations:
        """Return the equations with more states, which no jump changes."""
        return replace(
            self,
            states=(*self.states, *states),
            field=(*self.field, *field),
            jumps=tuple(replace(j, reset=(*j.reset, *states)) for j in self.jumps),
        )

    def keep_states(self, kept: Sequence[int]) -> Equations:
        """Return the equations of some states, which read no others."""
        return replace(
            self,
            states=tuple(self.states[i] for i in kept),
            field=tuple(self.field[i] for i in kept),
            jumps=tuple(replace(j, reset=tuple(j.reset[i] for i in kept)) for j in self.jumps),
        )

    def _happens(self, event: str, jumps: Collection[Jump]) -> bool:
        return any(event == s.name for s in self.switches) or any(event == j.name for j in jumps)

    def leave_out_idle(self) -> Equations:
        """Return the equations without the switches whose digit nothing reads and that start no clock."""
        clocks = {j.after for j in self.jumps}
        switches = list(self.switches)
        while True:
            exprs = [*self.field, *(s.argument for s in switches)]
            exprs += [e for j in self.jumps for e in (*j.reset, j.when, j.function) if e is not None]
            read = set().union(*(e.free_symbols for e in exprs))
            left = [s for s in switches if s.digit in read or s.name in clocks]
            if len(left) == len(switches):
                return replace(self, switches=tuple(left))
            switches = left

    def name_mode(self, digits: Digits) -> str:
        """Return the name of the mode with these digits."""
        return name_digits(self.switches, digits) or "smooth"

    def allows(self, jump: Jump, digits: Digits) -> bool:
        """Return whether a jump happens with these digits; a motion that slides is on neither side."""
        sides = (sympy.Rational(1, 2) if d == ON else sympy.Integer(d) for d in digits)
        values = dict(zip((s.digit for s in self.switches), sides, strict=True))
        return bool(sympy.expand(jump.when.xreplace(values)) == 1)

    def find_digits(self, mode: str) -> Digits | None:
        """Return the digits of the mode with a name; None if there is no such mode."""
        digits, rest = [], mode
        if mode == "smooth":
            return tuple(s.free for s in self.switches) if all(s.contact is not None for s in self.switches) else None
        for switch in self.switches:
            for number in (ON, BELOW, ABOVE):
                start = switch.word(number)
                if start and (rest == start or rest.startswith(start + "_")):
                    digits.append(number)
                    rest = rest[len(start) + 1 :]
                    break
            else:
                if switch.contact is None:
                    return None
                digits.append(switch.free)
        return tuple(digits) if self.name_mode(tuple(digits)) == mode else None


def find_bits(digits: Digits) -> int:
    """Return digits as bits: bit k says that switch k is above."""
    return sum(1 << k for k, digit in enumerate(digits) if digit == ABOVE)


def name_digits(switches: tuple[Switch, ...], digits: Digits, but: int = -1) -> str:
    """Return the digits in words, without those of switch ``but``: "friction_on_wall_below"."""
    named = (s.word(d) for k, (s, d) in enumerate(zip(switches, digits, strict=True)) if k != but)
    return "_".join(filter(None, named))
