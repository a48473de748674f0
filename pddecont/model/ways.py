"""Where motions go on after an event: the digits that follow, and the conditions on the states that decide."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product

import sympy
from sympy.logic.boolalg import Boolean

from pddecont.model.sliding import Surfaces, put_in
from pddecont.model.switches import ABOVE, BELOW, ON, Digits


@dataclass(frozen=True)
class Undecided:
    """A switch whose digit has to be read anew: the digits it may have, and whether its function is zero."""

    options: tuple[int, ...]
    on_surface: bool = False


@dataclass(frozen=True)
class Way:
    """Digits that follow where ``guard`` holds in the states after an event."""

    digits: Digits
    guard: Boolean


def list_ways(surfaces: Surfaces, digits: Digits, undecided: Mapping[int, Undecided]) -> list[Way]:
    """Return the digits that may follow, each with its condition: the first that holds decides."""
    numbers = list(undecided)
    every = [
        after
        for chosen in product(*(undecided[k].options for k in numbers))
        if surfaces.may_slide(after := _replace(digits, dict(zip(numbers, chosen, strict=True))))
    ]
    conditions = [
        sympy.And(*(_find_condition(surfaces, after, k, undecided[k], digits[k]) for k in numbers))
        for after in every[:-1]
    ]
    rest = sympy.And(*map(sympy.Not, conditions))
    guarded = zip(every, [*conditions, rest], strict=True)
    return [Way(after, guard) for after, guard in guarded if guard != sympy.false]


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
    lower, upper = surfaces.find_bounds(number, digits)
    leaves = {ABOVE: upper > 0, BELOW: lower < 0, ON: sympy.And(upper <= 0, lower >= 0)}[digit]
    if undecided.on_surface:
        return leaves
    if digit == ON:
        return sympy.And(u <= 0, u >= 0, leaves)
    return sympy.Or(u > 0, sympy.And(u >= 0, leaves)) if digit == ABOVE else sympy.Or(u < 0, sympy.And(u <= 0, leaves))


def list_options(surfaces: Surfaces, number: int, *, on_surface: bool) -> Undecided:
    """Return that a switch may have any digit."""
    return Undecided((ABOVE, BELOW, ON) if surfaces.slides[number] else (ABOVE, BELOW), on_surface)
