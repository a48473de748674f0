"""The mode of a model given by its equations, read from states, delayed values, time and parameters."""

from __future__ import annotations

from collections.abc import Mapping

import sympy

from pddecont.model.derived_modes import DerivedModes
from pddecont.model.evaluation import evaluate
from pddecont.model.repulsion import ROUNDING, list_surfaces_met
from pddecont.model.sliding import UndecidedSlidingError
from pddecont.model.switches import ABOVE, BELOW, Digits
from pddecont.model.vanishing import measure_terms
from pddecont.model.ways import Undecided, choose_digits, list_options

Numbers = Mapping[sympy.Symbol, float]


def find_start_mode(derived: DerivedModes, numbers: Numbers, before: str | None = None) -> str:
    """Return the mode of a motion that starts where symbols have these ``numbers``.

    A relay with memory is between its thresholds what it was in the mode ``before``, and below at a start. On a surface
    the motion goes where the fields lead it.

    Raises
    ------
    UndecidedSlidingError
        If both fields point away from a surface on which it starts.
    """
    digits = find_start_digits(derived, numbers, before)
    for surface in list_surfaces_met(derived.surfaces, digits, numbers):
        if surface.repels:
            states = {str(x): numbers[x] for x in derived.equations.states}
            raise UndecidedSlidingError(f"the motion starts {surface.describe(states)}; start beside the surface")
    return derived.build(digits)


def find_start_digits(derived: DerivedModes, numbers: Numbers, before: str | None = None) -> Digits:
    """Return the digits of the mode in which :func:`find_start_mode` lets a motion start, repelled or not."""
    known, surfaces = dict(numbers), derived.surfaces
    was = None if before is None else derived.find_digits(before)
    digits: list[int] = []
    undecided: dict[int, Undecided] = {}
    for k, switch in enumerate(derived.equations.switches):
        u = evaluate(switch.argument, known)
        if switch.contact is not None:
            digit = switch.free
        elif switch.remembers:
            held = was is not None and was[k] == ABOVE and u >= evaluate(switch.low, known)
            digit = ABOVE if held or u > evaluate(switch.high, known) else BELOW
        else:
            digit = ABOVE if u > 0.0 else BELOW
            if abs(u) <= ROUNDING * measure_terms(switch.argument, known) and surfaces.rates[k] is not None:
                undecided[k] = list_options(surfaces, k, on_surface=True)
        known[switch.digit] = float(digit)
        digits.append(digit)
    return choose_digits(surfaces, tuple(digits), undecided, numbers)
