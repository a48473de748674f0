"""What a hybrid model is made of besides its vector fields: events and segments."""

from __future__ import annotations

from dataclasses import dataclass

import sympy
from sympy.logic.boolalg import Boolean

# The reset that changes nothing.
IDENTITY = "identity"


@dataclass(frozen=True)
class Form:
    """Expressions that many modes share: they hold the digits of switches, which ``bits`` says for one mode.

    The digit of switch k is bit k. Expressions without digits have the bits 0.
    """

    exprs: tuple[sympy.Expr, ...]
    bits: int = 0


@dataclass(frozen=True)
class Event:
    """A zero of ``function`` along the orbit, or a moment ``delay`` after the event ``after``."""

    name: str
    function: sympy.Expr | None
    after: str | None = None
    delay: sympy.Expr | None = None
    # Of a model given by its equations: the switch or jump that this is an event of, and its function in digits.
    source: str = ""
    form: Form | None = None

    def starts(self, other: Event) -> bool:
        """Return whether this event starts the clock of another."""
        return other.after is not None and other.after in (self.name, self.source)


@dataclass(frozen=True)
class Segment:
    """The arc {mode, event, reset} of the paper's section 2.3 and the mode it leads to."""

    name: str
    mode: str
    event: str
    direction: str
    reset: str
    to: str
    # Of a segment that may lead to several modes: its name in the file, and when it leads to this one, judged by the
    # states after the reset.
    written: str = ""
    guard: Boolean = sympy.true
    # Of a model given by its equations: the switches whose digits are read anew after it, and that motions slide along
    # or are repelled by.
    anew: tuple[int, ...] = ()
    # Whether it ends with the last of impacts that accumulate: from there on the motion rests in the mode it leads to.
    rests: bool = False
