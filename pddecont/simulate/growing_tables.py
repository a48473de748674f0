"""Tables that grow, list after list: what decides which of several ways an event leads, and what modes share."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import sympy

from pddecont.codegen import write_rule
from pddecont.model import Ending, Form, Model, list_shared_forms


@dataclass
class Lists:
    """Lists one after the other: where each begins, and all their members."""

    first: list[int] = field(default_factory=lambda: [0])
    members: list[int] = field(default_factory=list)

    def append(self, numbers: Iterable[int]) -> None:
        """Add a list."""
        self.members += numbers
        self.first.append(len(self.members))


@dataclass
class Decisions:
    """What decides digits, as the integrator reads it: see :class:`System`."""

    option_first: list[int] = field(default_factory=list)
    option_end: list[int] = field(default_factory=list)
    is_open: list[int] = field(default_factory=list)
    number_first: list[int] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)
    size: list[int] = field(default_factory=list)
    digit_first: list[int] = field(default_factory=list)
    digits: list[int] = field(default_factory=list)
    rules: list[tuple[sympy.Expr, ...] | None] = field(default_factory=list)

    def add(self, ending: Ending) -> tuple[int, int]:
        """Add the decisions of an ending; return where they begin and end."""
        first = len(self.size)
        for decision in ending.decisions:
            self.option_first.append(len(self.rules))
            last = len(decision.options) - 1
            for i, rule in enumerate(decision.rules):
                # The last holds where no other does.
                self.rules.append(None if i == last and not decision.is_open else write_rule(rule))
                self.digit_first.append(len(self.digits))
                self.digits += decision.options[i]
            self.option_end.append(len(self.rules))
            self.is_open.append(int(decision.is_open))
            self.number_first.append(len(self.numbers))
            self.numbers += decision.numbers
            self.size.append(len(decision.numbers))
        return first, len(self.size)


@dataclass
class Shared:
    """Functions and conditions that modes like those reached have too."""

    events: list[Form] = field(default_factory=list)
    resets: list[Form] = field(default_factory=list)
    rules: list[tuple[sympy.Expr, ...]] = field(default_factory=list)

    def add(self, model: Model, mode: str) -> None:
        """Add those of modes like one."""
        events, resets, rules = list_shared_forms(model, mode)
        self.events += events
        self.resets += resets
        self.rules += map(write_rule, rules)
