"""The mode of a model given by its equations, read from states, delayed values, time and parameters."""

from __future__ import annotations

from collections.abc import Mapping

import sympy

from pddecont.model.derived_modes import DerivedModes
from pddecont.model.evaluation import evaluate
from pddecont.model.sliding import UndecidedSlidingError
from pddecont.model.switches import ABOVE, BELOW, ON, Digits
from pddecont.model.vanishing import measure_terms
from pddecont.model.ways import Undecided, choose_digits, list_options

# A function this small, relative to the terms it adds, is zero: the motion starts on the surface.
ROUNDING = 1e-14

Numbers = Mapping[sympy.Symbol, float]


def find_start_mode(derived: DerivedModes, numbers: Numbers) -> str:
    """Return the mode of a motion that starts where symbols have these ``numbers``.

    A relay with memory is below between its thresholds. On a surface the motion goes where the fields lead it.

    Raises
    ------
    UndecidedSlidingError
        If both fields point away from a surface on which it starts.
    """
    known, surfaces = dict(numbers), derived.surfaces
    digits: list[int] = []
    undecided: dict[int, Undecided] = {}
    for k, switch in enumerate(derived.equations.switches):
        u = evaluate(switch.argument, known)
        if switch.remembers:
            digit = ABOVE if u > evaluate(switch.high, known) else BELOW
        else:
            digit = ABOVE if u > 0.0 else BELOW
            if abs(u) <= ROUNDING * measure_terms(switch.argument, known) and surfaces.rates[k] is not None:
                undecided[k] = list_options(surfaces, k, on_surface=True)
        known[switch.digit] = float(digit)
        digits.append(digit)
    found = choose_digits(surfaces, tuple(digits), undecided, numbers)
    for k in undecided:
        if surfaces.slides[k]:
            _check_surface(derived, found, k, numbers)
    return derived.build(found)


def _check_surface(derived: DerivedModes, digits: Digits, number: int, numbers: Numbers) -> None:
    """Raise an error where both fields point away from a surface."""
    lower, upper = (evaluate(rate, numbers) for rate in derived.surfaces.find_bounds(number, digits))
    if digits[number] != ON and lower < 0.0 < upper:
        switch = derived.equations.switches[number]
        where = ", ".join(f"{x} = {numbers[x]:.6g}" for x in derived.equations.states)
        raise UndecidedSlidingError(
            f"the motion starts on the surface {switch.argument} = 0 of switch '{switch.name}' at {where}, and both "
            f"fields point away from it (its rate is {lower:.6g} below and {upper:.6g} above): nothing decides "
            "on which side it goes on; start beside the surface"
        )
