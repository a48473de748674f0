"""Sliding along switching surfaces: how fast a motion leaves them, and the digits that keep it there.

Along the field f = f- + h (f+ - f-) of a switch with function u and digit h the rate du/dt is linear in h. A motion on
the surface slides with the h for which the rate is zero, as long as that is between the bounds (0 and 1, farther apart
with static friction).

Reference: Filippov, Differential Equations with Discontinuous Righthand Sides (1988), section 4; Utkin's equivalent
control is the same where the field is linear in the digits, as it is here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import sympy

from pddecont.errors import PddecontError
from pddecont.model.expression import TIME
from pddecont.model.switches import ABOVE, BELOW, ON, Digits, Equations
from pddecont.model.vanishing import vanishes, vanishes_where

Values = Mapping[sympy.Symbol, sympy.Expr]
FIXED: Mapping[int, sympy.Expr] = {BELOW: sympy.S.Zero, ABOVE: sympy.S.One}


class UndecidedSlidingError(PddecontError):
    """No linear system decides how a motion slides."""


@dataclass(frozen=True)
class Surfaces:
    """The switching surfaces of a model's equations.

    ``rates`` holds du/dt of each switch along the flow, as an expression in the digits, or None where u reads delayed
    values; ``slides`` says along which of them motions can slide.
    """

    equations: Equations
    rates: tuple[sympy.Expr | None, ...]
    slides: tuple[bool, ...]
    _solved: dict[tuple[Digits, int], Values] = field(default_factory=dict, repr=False, compare=False)

    def find_values(self, digits: Digits, free: int = -1) -> Values:
        """Return what each digit's symbol stands for: 0, 1, or what keeps the motion on its surface.

        Raises
        ------
        UndecidedSlidingError
            If the surfaces along which a motion slides do not determine how.
        """
        key = digits, free
        if key not in self._solved:
            self._solved[key] = self._solve(digits, free)
        return self._solved[key]

    def find_rate(self, number: int, digits: Digits, value: sympy.Expr) -> sympy.Expr:
        """Return du/dt of a switch with the digit ``value``, the others having ``digits``."""
        rate, symbol = self.rates[number], self.equations.switches[number].digit
        assert rate is not None, "the rate of a function of delayed values is not known"
        values = self.find_values(digits, number)
        return put_in(put_in(rate, {s: v for s, v in values.items() if s != symbol}), {symbol: value})

    def find_bounds(self, number: int, digits: Digits) -> tuple[sympy.Expr, sympy.Expr]:
        """Return du/dt at the lower and the upper bound of a switch's digit: a motion slides from + to -."""
        low, high = self.equations.switches[number].bounds
        return self.find_rate(number, digits, low), self.find_rate(number, digits, high)

    def _solve(self, digits: Digits, free: int) -> Values:
        switches = self.equations.switches
        values = {
            s.digit: FIXED[d] for k, (s, d) in enumerate(zip(switches, digits, strict=True)) if d != ON and k != free
        }
        on = [k for k, d in enumerate(digits) if d == ON and k != free]
        unknown = [switches[k].digit for k in on]
        if not on:
            return values
        rates = [put_in(self.rates[k], values) for k in on]
        matrix = sympy.Matrix([[rate.diff(h) for h in unknown] for rate in rates])
        names = " and ".join(f"'{switches[k].name}'" for k in on)
        if matrix.free_symbols & set(unknown):
            raise UndecidedSlidingError(
                f"no linear system decides how a motion slides along {names} at once: their laws are multiplied"
            )
        determinant = matrix.det(method="berkowitz")
        if vanishes(determinant):
            raise UndecidedSlidingError(f"nothing decides how a motion slides along {names} at once")
        rest = sympy.Matrix([-rate.xreplace(dict.fromkeys(unknown, sympy.S.Zero)) for rate in rates])
        solution = (matrix.adjugate() * rest) / determinant if len(on) > 1 else rest / determinant
        return values | dict(zip(unknown, solution, strict=True))


def find_surfaces(equations: Equations, delayed: frozenset[sympy.Symbol]) -> Surfaces:
    """Return the switching surfaces of equations that read the ``delayed`` values."""
    rates = tuple(_find_rate(equations, s.argument, delayed) for s in equations.switches)
    moving = {*equations.states, TIME}
    slides = tuple(
        rate is not None
        and not switch.remembers
        and bool(switch.argument.free_symbols & set(equations.states))
        and not vanishes_where(sympy.expand(rate.diff(switch.digit)), switch.argument, moving)
        for switch, rate in zip(equations.switches, rates, strict=True)
    )
    return Surfaces(equations, rates, slides)


def put_in(expr: sympy.Expr, values: Values) -> sympy.Expr:
    """Return an expression with digits put in."""
    return expr.xreplace(dict(values)) if expr.free_symbols & set(values) else expr


def _find_rate(equations: Equations, u: sympy.Expr, delayed: frozenset[sympy.Symbol]) -> sympy.Expr | None:
    if u.free_symbols & delayed:
        return None
    moving = (u.diff(x) * f for x, f in zip(equations.states, equations.field, strict=True) if x in u.free_symbols)
    return u.diff(TIME) + sum(moving, sympy.S.Zero)
