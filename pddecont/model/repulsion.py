"""Surfaces that repel: both fields point away, and nothing decides on which side a motion on one goes on.

A motion never arrives at such a place, as the field that it arrives along leads to the surface. Jumps put motions
there, starts, and changes of what held one on a surface.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import sympy
from sympy.logic.boolalg import Boolean

from pddecont.model.evaluation import evaluate
from pddecont.model.expression import TIME
from pddecont.model.parts import Segment
from pddecont.model.sliding import Surfaces
from pddecont.model.switches import ON, OPEN, Digits, Switch
from pddecont.model.system import Model
from pddecont.model.vanishing import measure_terms

# A function this small, relative to the terms it adds, is zero.
ROUNDING = 1e-14

Numbers = Mapping[sympy.Symbol, float]


@dataclass(frozen=True)
class Surface:
    """A surface that a motion is on, ``function`` = 0, and du/dt along the fields below and above it."""

    switch: Switch
    function: sympy.Expr
    below: float
    above: float

    @property
    def repels(self) -> bool:
        """Whether both fields point away from it."""
        return self.below < 0.0 < self.above

    def describe(self, states: Mapping[str, float]) -> str:
        """Return in words that the surface repels a motion with these states, or begins to."""
        where = ", ".join(f"{name} = {value:.6g}" for name, value in states.items())
        point = "point" if self.repels else "begin to point"
        return (
            f"on the surface {self.function} = 0 of switch '{self.switch.name}' at {where}, and both fields {point} "
            f"away from it (its rate is {self.below:.6g} below and {self.above:.6g} above): nothing decides on which "
            "side it goes on"
        )


def list_surfaces_met(surfaces: Surfaces, digits: Digits, numbers: Numbers) -> list[Surface]:
    """Return the surfaces that a motion is on without sliding along them, of those along which motions slide."""
    found = []
    for k, switch in enumerate(surfaces.equations.switches):
        if digits[k] == ON or not surfaces.slides[k]:
            continue
        function, rates = surfaces.find_function(k, digits), surfaces.find_bounds(k, digits)
        if abs(evaluate(function, numbers)) <= evaluate(_write_rounding(function, rates), numbers):
            below, above = (_clear_rounding(rate, numbers) for rate in rates)
            if math.isfinite(below) and math.isfinite(above):
                found.append(Surface(switch, function, below, above))
    return found


def _clear_rounding(expr: sympy.Expr, numbers: Numbers) -> float:
    """Return what an expression is worth; zero where that is rounding in its terms."""
    value = evaluate(expr, numbers)
    return 0.0 if abs(value) <= ROUNDING * measure_terms(expr, numbers) else value


def write_repulsion(model: Model, segment: Segment) -> Boolean:
    """Return the condition that a surface repels the motion after a segment: one whose digit is read anew.

    It is the same for all modes that slide along the same surfaces: the digits of the other switches stand.
    """
    if model.derived is None or not segment.anew:
        return sympy.false
    surfaces, digits = model.derived.surfaces, model.derived.find_digits(segment.to) or ()
    kept = tuple(d if d == ON else OPEN for d in digits)
    return sympy.Or(*(_write_repulsion(surfaces, k, kept) for k in segment.anew if digits[k] != ON))


def _write_repulsion(surfaces: Surfaces, number: int, digits: Digits) -> Boolean:
    key = number, digits
    if key not in surfaces.repulsions:
        surfaces.repulsions[key] = _find_repulsion(surfaces, number, digits)
    return surfaces.repulsions[key]


def _find_repulsion(surfaces: Surfaces, number: int, digits: Digits) -> Boolean:
    u, rates = surfaces.find_function(number, digits), surfaces.find_bounds(number, digits)
    if any(rate.has(sympy.nan, sympy.zoo) for rate in rates):
        # On the other side no law holds the motion on another surface that it slides along.
        return sympy.false
    return sympy.And(sympy.Abs(u) <= _write_rounding(u, rates), rates[0] < 0, rates[1] > 0)


def _write_rounding(u: sympy.Expr, rates: tuple[sympy.Expr, sympy.Expr]) -> sympy.Expr:
    """Return how far from zero a function may be on its surface: by rounding in its terms, and in the time."""
    terms = (sympy.Abs(u.diff(s) * s) for s in sorted(u.free_symbols, key=str))
    return ROUNDING * sympy.Add(*terms, (1 + sympy.Abs(TIME)) * sympy.Add(*map(sympy.Abs, rates)))
