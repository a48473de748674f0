"""Sliding along switching surfaces: how fast a motion leaves them, and the digits that keep it there.

Along the field f = f- + h (f+ - f-) of a switch with function u and digit h the rate du/dt is linear in h. A motion on
the surface slides with the h for which the rate is zero, as long as that is between the bounds (0 and 1, farther apart
with static friction).

Reference: Filippov, Differential Equations with Discontinuous Righthand Sides (1988), section 4; Utkin's equivalent
control is the same where the field is linear in the digits, as it is here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import sympy
from sympy.logic.boolalg import Boolean

from pddecont.errors import PddecontError
from pddecont.model.expression import TIME
from pddecont.model.parallel import Compatible, find_compatible
from pddecont.model.switches import ABOVE, BELOW, ON, OPEN, Digits, Equations, Switch
from pddecont.model.vanishing import find_rank, vanishes, vanishes_where

Values = Mapping[sympy.Symbol, sympy.Expr]
FIXED: Mapping[int, sympy.Expr] = {BELOW: sympy.S.Zero, ABOVE: sympy.S.One}


class UndecidedSlidingError(PddecontError):
    """No linear system decides how a motion slides."""


@dataclass(frozen=True)
class Surfaces:
    """The switching surfaces of a model's equations.

    ``rates`` holds du/dt of each switch along the flow, as an expression in the digits, or None where delayed values
    change u in a way that is not known; ``slides`` says along which of them motions can slide, ``compatible`` which
    digits of parallel ones go together.
    """

    equations: Equations
    rates: tuple[sympy.Expr | None, ...]
    slides: tuple[bool, ...]
    compatible: Compatible
    _solved: dict[Digits, Values] = field(default_factory=dict, repr=False, compare=False)
    _possible: dict[Digits, bool] = field(default_factory=dict, repr=False, compare=False)
    _meeting: dict[tuple[int, ...], bool] = field(default_factory=dict, repr=False, compare=False)
    # What :mod:`pddecont.model.repulsion` has worked out.
    repulsions: dict[tuple[int, Digits], Boolean] = field(default_factory=dict, repr=False, compare=False)

    def find_values(self, digits: Digits, free: int = -1) -> Values:
        """Return what each digit's symbol stands for: 0, 1, or what keeps the motion on its surface.

        The digit of the switch ``free`` stands for itself.
        """
        switches = self.equations.switches
        on = tuple(k for k, d in enumerate(digits) if d == ON and k != free)
        fixed = {
            s.digit: FIXED[d] for k, (s, d) in enumerate(zip(switches, digits, strict=True)) if d in FIXED and k != free
        }
        return fixed | {s: put_in(e, fixed) for s, e in self.solve(on).items()}

    def may_be(self, digits: Digits) -> bool:
        """Return whether a motion can have these digits: they agree, and it can slide where it should."""
        return self.agree(digits) and self.may_slide(digits)

    def agree(self, digits: Digits) -> bool:
        """Return whether no digits exclude each other, as x > 1 and x < 0; those that are open exclude none."""
        return all(
            OPEN in (digits[i], digits[j]) or (digits[i], digits[j]) in pairs
            for (i, j), pairs in self.compatible.items()
        )

    def list_digits(self, number: int) -> tuple[int, ...]:
        """Return the digits that a switch may have."""
        switch = self.equations.switches[number]
        if switch.contact is not None:
            return switch.free, ON
        return (ABOVE, BELOW, ON) if self.slides[number] else (ABOVE, BELOW)

    def may_slide(self, digits: Digits) -> bool:
        """Return whether the laws that jump at the surfaces of a mode can hold a motion on them all.

        They cannot where one of them does not act there, where the surfaces are parallel, or where the laws move the
        motion in the same way.
        """
        if ON not in digits:
            return True
        if digits not in self._possible:
            on = tuple(k for k, d in enumerate(digits) if d == ON)
            fixed = {s.digit: FIXED[d] for s, d in zip(self.equations.switches, digits, strict=True) if d != ON}
            matrix = self._find_matrix(on).applyfunc(lambda e: put_in(e, fixed))
            self._possible[digits] = self._may_meet(on) and not vanishes(matrix.det(method="berkowitz"))
        return self._possible[digits]

    def check_linear(self) -> None:
        """Check that linear systems decide how motions slide along surfaces at once.

        Raises
        ------
        UndecidedSlidingError
            If laws are multiplied: how the digit of one moves a surface depends on another digit.
        """
        switches = self.equations.switches
        sliding = {s.digit: k for k, (s, slides) in enumerate(zip(switches, self.slides, strict=True)) if slides}
        for number in sliding.values():
            rate = self._rate_of(number)
            read = rate.free_symbols & set(sliding)
            for one in sorted(read, key=sliding.__getitem__):
                for other in rate.diff(one).free_symbols & read:
                    on = tuple(sorted({number, sliding[one], sliding[other]}))
                    if self._may_meet(on):
                        names = " and ".join(f"'{switches[k].name}'" for k in on)
                        raise UndecidedSlidingError(
                            f"no linear system decides how a motion slides along {names} at once: their laws are "
                            "multiplied"
                        )

    def _may_meet(self, on: tuple[int, ...]) -> bool:
        """Return whether surfaces are independent: parallel ones have no point in common."""
        if on not in self._meeting:
            self._meeting[on] = self._find_whether_they_meet(on)
        return self._meeting[on]

    def _find_whether_they_meet(self, on: tuple[int, ...]) -> bool:
        arguments = [self.equations.switches[k].argument for k in on]
        slopes = [[u.diff(x) for x in self.equations.states] for u in arguments]
        return find_rank(slopes) == len(on)

    def find_function(self, number: int, digits: Digits) -> sympy.Expr:
        """Return the function of a switch, the others having ``digits``."""
        return put_in(self.equations.switches[number].argument, self.find_values(digits))

    def find_rate(self, number: int, digits: Digits, value: sympy.Expr) -> sympy.Expr:
        """Return du/dt of a switch with the digit ``value``, the others having ``digits``."""
        rate = put_in(self._rate_of(number), self.find_values(digits, number))
        return put_in(rate, {self.equations.switches[number].digit: value})

    def find_bounds(self, number: int, digits: Digits) -> tuple[sympy.Expr, sympy.Expr]:
        """Return du/dt at the lower and the upper bound of a switch's digit: a motion slides from + to -.

        A contact presses as much as it has to, and pulls nothing.
        """
        switch = self.equations.switches[number]
        if switch.contact is not None:
            rate = self.find_rate(number, digits, FIXED[switch.free])
            return (rate, -sympy.oo) if switch.free == BELOW else (sympy.oo, rate)
        low, high = switch.bounds
        return self.find_rate(number, digits, low), self.find_rate(number, digits, high)

    def solve(self, on: tuple[int, ...]) -> Values:
        """Return the digits of the switches ``on`` along whose surfaces a motion slides, in terms of the others."""
        if on not in self._solved:
            self._solved[on] = self._solve(on)
        return self._solved[on]

    def _solve(self, on: tuple[int, ...]) -> Values:
        if not on:
            return {}
        unknown = [self.equations.switches[k].digit for k in on]
        matrix = self._find_matrix(on)
        determinant = matrix.det(method="berkowitz")
        zero = dict.fromkeys(unknown, sympy.S.Zero)
        rest = sympy.Matrix([-put_in(self._rate_of(k), zero) for k in on])
        solution = (matrix.adjugate() * rest) / determinant if len(on) > 1 else rest / determinant
        return dict(zip(unknown, solution, strict=True))

    def _find_matrix(self, on: tuple[int, ...]) -> sympy.Matrix:
        unknown = [self.equations.switches[k].digit for k in on]
        return sympy.Matrix([[self._rate_of(k).diff(h) for h in unknown] for k in on])

    def _rate_of(self, number: int) -> sympy.Expr:
        rate = self.rates[number]
        assert rate is not None, "how delayed values change this function is not known"
        return rate


def find_surfaces(equations: Equations) -> Surfaces:
    """Return the switching surfaces of equations.

    Raises
    ------
    UndecidedSlidingError
        If the surfaces along which a motion slides do not determine how.
    """
    rates = tuple(_find_rate(equations, switch) for switch in equations.switches)
    moving = {*equations.states, TIME}
    slides = tuple(
        rate is not None
        and not switch.remembers
        and bool(switch.argument.free_symbols & set(equations.states))
        and not vanishes_where(sympy.expand(rate.diff(switch.digit)), switch.argument, moving)
        for switch, rate in zip(equations.switches, rates, strict=True)
    )
    found = Surfaces(equations, rates, slides, find_compatible(equations.switches))
    found.check_linear()
    return found


def make_return(states: tuple[sympy.Symbol, ...], functions: Sequence[sympy.Expr]) -> tuple[sympy.Expr, ...]:
    """Return the reset to the nearest states at which functions are zero, by one step of Newton's method."""
    x, u = sympy.Matrix(states), sympy.Matrix(functions)
    slopes = u.jacobian(x)
    square = slopes * slopes.T
    change = slopes.T * (square.adjugate() * u) / square.det(method="berkowitz")
    return tuple(x - change)


def put_in(expr: sympy.Expr, values: Values) -> sympy.Expr:
    """Return an expression with digits put in."""
    return expr.xreplace(dict(values)) if expr.free_symbols & set(values) else expr


def _find_rate(equations: Equations, switch: Switch) -> sympy.Expr | None:
    u = switch.argument
    if switch.drift is None:
        return None
    moving = (u.diff(x) * f for x, f in zip(equations.states, equations.field, strict=True) if x in u.free_symbols)
    return u.diff(TIME) + switch.drift + sum(moving, sympy.S.Zero)
