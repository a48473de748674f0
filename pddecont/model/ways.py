"""Where motions go on after an event: the digits that follow, and the conditions on the states that decide."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field
from itertools import product

import sympy
from sympy.logic.boolalg import Boolean

from pddecont.model.sliding import FIXED, Surfaces, put_in
from pddecont.model.switches import ABOVE, BELOW, ON, OPEN, Digits


@dataclass(frozen=True)
class Undecided:
    """A switch whose digit has to be read anew: the digits it may have, and whether its function is zero."""

    options: tuple[int, ...]
    on_surface: bool = False


@dataclass(frozen=True)
class Way:
    """Digits that follow where ``guard`` holds in the states after an event.

    ``rule`` is the same in the digits of the switches that do not change: many modes share one.
    """

    digits: Digits
    guard: Boolean
    rule: Boolean


@dataclass
class WayFinder:
    """Finds where motions go on; what it has worked out once it knows."""

    surfaces: Surfaces
    _rules: dict[Hashable, list[Boolean]] = field(default_factory=dict)
    _guards: dict[Hashable, Boolean] = field(default_factory=dict)

    def list_ways(self, digits: Digits, undecided: Mapping[int, Undecided]) -> list[Way]:
        """Return the digits that may follow, each with its condition: the first that holds decides."""
        numbers = tuple(undecided)
        possible = [
            chosen
            for chosen in product(*(undecided[k].options for k in numbers))
            if self.surfaces.may_be(_replace(digits, dict(zip(numbers, chosen, strict=True))))
        ]
        kept = tuple(d if d == ON or k in undecided else OPEN for k, d in enumerate(digits))
        key = kept, tuple(undecided.items()), tuple(possible)
        if key not in self._rules:
            changed = [_replace(kept, dict(zip(numbers, chosen, strict=True))) for chosen in possible]
            self._rules[key] = _list_rules(self.surfaces, changed, kept, undecided)
        found = []
        for chosen, rule in zip(possible, self._rules[key], strict=True):
            guard = self._put_in(rule, digits)
            if guard != sympy.false:
                found.append(Way(_replace(digits, dict(zip(numbers, chosen, strict=True))), guard, rule))
            if guard == sympy.true:
                break
        return found

    def _put_in(self, rule: Boolean, digits: Digits) -> Boolean:
        """Return a rule with the digits of a mode."""
        switches = self.surfaces.equations.switches
        values = {s.digit: FIXED[d] for s, d in zip(switches, digits, strict=True) if s.digit in rule.free_symbols}
        key = rule, tuple(values.items())
        if key not in self._guards:
            self._guards[key] = rule.xreplace(values) if values else rule
        return self._guards[key]


def _list_rules(
    surfaces: Surfaces, changed: list[Digits], before: Digits, undecided: Mapping[int, Undecided]
) -> list[Boolean]:
    """Return the condition of each of the sets of digits that may follow; the last one holds where no other does."""
    conditions = [
        sympy.And(*(_find_condition(surfaces, after, k, undecided[k], before[k]) for k in undecided))
        for after in changed[:-1]
    ]
    return [*conditions, sympy.And(*map(sympy.Not, conditions))]


def _replace(digits: Digits, changes: Mapping[int, int]) -> Digits:
    return tuple(changes.get(k, digit) for k, digit in enumerate(digits))


def _find_condition(surfaces: Surfaces, digits: Digits, number: int, undecided: Undecided, before: int) -> Boolean:
    """Return the condition under which a switch has its digit, where the others have theirs."""
    switch, digit = surfaces.equations.switches[number], digits[number]
    u = put_in(switch.argument, surfaces.find_values(digits))
    if switch.remembers:
        above = u > switch.high if before == BELOW else u >= switch.low
        return above if digit == ABOVE else sympy.Not(above)
    if surfaces.rates[number] is None:
        return u > 0 if digit == ABOVE else u <= 0
    leaves = _find_direction(surfaces, digits, number)
    if undecided.on_surface:
        return leaves
    if digit == ON:
        return sympy.And(u <= 0, u >= 0, leaves)
    return sympy.Or(u > 0, sympy.And(u >= 0, leaves)) if digit == ABOVE else sympy.Or(u < 0, sympy.And(u <= 0, leaves))


def _find_direction(surfaces: Surfaces, digits: Digits, number: int) -> Boolean:
    """Return the condition under which a motion on the surface of a switch goes where its digit says."""
    # On the other side there may be no rate: what holds the motion on other surfaces may not act there.
    lower, upper = surfaces.find_bounds(number, digits)
    if digits[number] == ON:
        return sympy.And(upper <= 0, lower >= 0)
    return upper > 0 if digits[number] == ABOVE else lower < 0


def list_options(surfaces: Surfaces, number: int, *, on_surface: bool) -> Undecided:
    """Return that a switch may have any digit."""
    return Undecided(surfaces.list_digits(number), on_surface)
