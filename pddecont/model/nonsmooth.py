"""Nonsmooth functions in expressions: each becomes smooth in the digits of its switches.

With the digit h of the sign of u (0 below, 1 above): ``sign(u)`` is 2 h - 1, ``max(a, b)`` is b + h (a - b) with
u = a - b, and so on. Arguments that are equal up to a number share a switch.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Collection
from dataclasses import dataclass, field, replace
from functools import reduce

import sympy
from sympy.core.relational import Relational
from sympy.logic.boolalg import Boolean

from pddecont.model.conditions import translate_condition
from pddecont.model.expression import TIME, Builtin, Scope, translate_expression
from pddecont.model.switches import Switch
from pddecont.model.syntax import ExpressionError


@dataclass(frozen=True)
class Clock:
    """A state that grows with time and is set to zero where ``tick`` rises through zero."""

    state: sympy.Symbol
    tick: sympy.Expr
    at_start: sympy.Expr


@dataclass
class SwitchCollector:
    """The switches of a model while its expressions are read.

    ``variables`` are the symbols that change along a motion, with the state they belong to; ``taken`` names that no
    switch may have, ``names`` those that no clock may have; ``evaluate`` returns the value of an expression in the
    parameters, NaN of any other.
    """

    variables: dict[sympy.Symbol, str]
    taken: Collection[str]
    names: Collection[str]
    evaluate: Callable[[sympy.Expr], float]
    switches: list[Switch] = field(default_factory=list)
    clocks: dict[sympy.Expr, Clock] = field(default_factory=dict)
    # Switches that a coulomb law holds, and those that another function reads.
    _held: set[str] = field(default_factory=set)
    _read: set[str] = field(default_factory=set)
    _known: dict[sympy.Expr, tuple[int, bool]] = field(default_factory=dict)

    @property
    def builtins(self) -> dict[str, Builtin]:
        """The nonsmooth functions, as functions of syntax nodes."""
        return {
            "sign": self._make(1, lambda u: 2 * self.read(u) - 1),
            "heaviside": self._make(1, self.read),
            "abs": self._make(1, lambda u: (2 * self.read(u) - 1) * u),
            "max": self._fold(self._larger),
            "min": self._fold(lambda a, b: a + b - self._larger(a, b)),
            "clip": self._make(3, lambda x, a, b: a + self._ramp(x - a) - self._ramp(x - b)),
            "deadzone": self._deadzone,
            "where": self._where,
            "coulomb": self._make(3, self._coulomb),
            "hysteresis": self._make(3, self._hysteresis),
            "mod": self._make(2, self._mod),
            "square": self._make(2, self._square),
        }

    def declare(self, name: str, argument: sympy.Expr) -> None:
        """Add a switch that the file names; what reads its argument later shares it."""
        self._find(argument, name)

    def read(self, argument: sympy.Expr) -> sympy.Expr:
        """Return 1 where an argument is positive and 0 where it is negative, as an expression in a digit."""
        number, reverse = self._find(argument)
        switch = self.switches[number]
        self._read.add(switch.name)
        self._check_grip(switch)
        return 1 - switch.digit if reverse else switch.digit

    def _find(self, argument: sympy.Expr, name: str = "") -> tuple[int, bool]:
        """Return the number of the switch with an argument, and whether it has the other sign; add it if it is new."""
        key, reverse = self._normalise(argument)
        if key in self._known:
            number, known_reverse = self._known[key]
            if name:
                raise ExpressionError(f"this is the argument of switch '{self.switches[number].name}' already")
            return number, reverse != known_reverse
        return self._add(key, reverse, Switch(name, sympy.S.Zero, argument)), False

    def _add(self, key: sympy.Expr, reverse: bool, switch: Switch) -> int:
        name = switch.name or self._make_name(switch.argument)
        # No name of a file has a dot.
        switch = replace(switch, name=name, digit=sympy.Symbol(f"{name}.digit", real=True))
        self.switches.append(switch)
        self._known[key] = len(self.switches) - 1, reverse
        return len(self.switches) - 1

    def _normalise(self, argument: sympy.Expr) -> tuple[sympy.Expr, bool]:
        """Return an argument over its leading number, and whether that was negative."""
        expanded = sympy.expand(argument)
        symbols = expanded.free_symbols
        digits = {s.digit for s in self.switches}
        if not symbols & (set(self.variables) | digits | {TIME}):
            raise ExpressionError("the sign of a constant: this argument changes neither with a state nor with t")
        if expanded.is_positive or expanded.is_negative:
            raise ExpressionError(
                f"this argument is always {'positive' if expanded.is_positive else 'negative'}: it switches nothing"
            )
        terms = expanded.as_coefficients_dict()
        leading = terms[min(terms, key=lambda term: sympy.default_sort_key(term))]
        key = sympy.expand(expanded / leading)
        changing = set(self.variables) | digits | {TIME}
        for known in self._known:
            if isinstance(known, sympy.Tuple) or known == key or (known.free_symbols ^ symbols) & changing:
                continue
            ratio = sympy.cancel(key / known)
            if not ratio.free_symbols & changing:
                raise ExpressionError(
                    f"this argument is {ratio} times that of another switch, and the sign of that may change; write "
                    "both with the same argument"
                )
        return key, bool(leading < 0)

    def _make_name(self, argument: sympy.Expr) -> str:
        """Return a name for a switch: the states that it reads."""
        read = [name for symbol, name in self.variables.items() if symbol in argument.free_symbols]
        base = "_".join(dict.fromkeys(read)) or TIME.name
        names, number = {*self.taken, *(s.name for s in self.switches)}, 2
        name = base
        while name in names:
            name, number = f"{base}{number}", number + 1
        return name

    def _larger(self, a: sympy.Expr, b: sympy.Expr) -> sympy.Expr:
        # Of a number and a function the function is the argument: what lies above is what a reader expects.
        fixed, other = (a, b) if not a.free_symbols & set(self.variables) else (b, a)
        return fixed + self._ramp(other - fixed)

    def _ramp(self, u: sympy.Expr) -> sympy.Expr:
        """Return the positive part of ``u``."""
        return self.read(u) * u

    def _coulomb(self, u: sympy.Expr, kinetic: sympy.Expr, static: sympy.Expr) -> sympy.Expr:
        self._check(kinetic, "kinetic friction", positive=True)
        self._check(static - kinetic, "static less kinetic friction")
        number, reverse = self._find(u)
        switch, grip = self.switches[number], sympy.cancel(static / kinetic)
        if switch.name in self._held and switch.grip != grip:
            raise ExpressionError(f"switch '{switch.name}' has another coulomb law with another static by kinetic")
        self._held.add(switch.name)
        self.switches[number] = replace(switch, grip=grip)
        self._check_grip(self.switches[number])
        return kinetic * (2 * switch.digit - 1) * (-1 if reverse else 1)

    def _check_grip(self, switch: Switch) -> None:
        """Check that no law but coulomb's reads a switch that holds on with more than it slips with."""
        if switch.grip != 1 and switch.name in self._held & self._read:
            raise ExpressionError(
                f"the sign of switch '{switch.name}' is read by coulomb(...), with static friction, and by another "
                "function; write the other with a coulomb law too"
            )

    def _check(self, expr: sympy.Expr, what: str, *, positive: bool = False) -> None:
        """Check the sign of an expression where it has a value at the parameters."""
        value = self.evaluate(expr)
        if value < 0.0 or (positive and value == 0.0):
            wanted = "a positive number" if positive else "a positive number or zero"
            raise ExpressionError(f"{what} is {value:g} at the given parameters; expected {wanted}")

    def _hysteresis(self, u: sympy.Expr, low: sympy.Expr, high: sympy.Expr) -> sympy.Expr:
        self._check(high - low, "the upper less the lower threshold", positive=True)
        key = sympy.Tuple(u, low, high)
        if key not in self._known:
            self._normalise(u)
            self._add(key, False, Switch("", sympy.S.Zero, u, low, high))
        return 2 * self.switches[self._known[key][0]].digit - 1

    def _square(self, t: sympy.Expr, period: sympy.Expr) -> sympy.Expr:
        return 2 * self.read(sympy.sin(self._angle(t, period))) - 1

    def _mod(self, t: sympy.Expr, period: sympy.Expr) -> sympy.Expr:
        """Return the clock that counts what is left of ``t`` after whole periods, a state that ticks set to zero."""
        angle = self._angle(t, period)
        key = sympy.expand(angle)
        if key not in self.clocks:
            base = name = "clock"
            number = 2
            while name in self.names or any(clock.state.name == name for clock in self.clocks.values()):
                name, number = f"{base}{number}", number + 1
            # At t = 0 it has run since the last tick; from there the angle is measured half a turn back.
            start = angle.xreplace({TIME: sympy.S.Zero}) - sympy.pi
            left = period * (sympy.Rational(1, 2) + sympy.atan2(sympy.sin(start), sympy.cos(start)) / (2 * sympy.pi))
            at_start = sympy.S.Zero if start == -sympy.pi else left
            self.clocks[key] = Clock(sympy.Symbol(name, real=True), sympy.sin(angle), at_start)
            self.variables[self.clocks[key].state] = name
        return self.clocks[key].state

    def _angle(self, t: sympy.Expr, period: sympy.Expr) -> sympy.Expr:
        self._check(period, "the period", positive=True)
        if TIME not in t.free_symbols or t.diff(TIME) != 1 or period.free_symbols & {*self.variables, TIME}:
            raise ExpressionError("write mod(t, T) or square(t, T): t, or t - a, and a period of parameters")
        return 2 * sympy.pi * t / period

    def _make(self, n_args: int, function: Callable[..., sympy.Expr]) -> Builtin:
        """Return a function of ``n_args`` expressions as one of syntax nodes."""

        def read(node: ast.Call, scope: Scope) -> sympy.Expr:
            args = _read_arguments(node, scope, n_args, n_args)
            return _placed(lambda: function(*args), node)

        return read

    def _fold(self, function: Callable[[sympy.Expr, sympy.Expr], sympy.Expr]) -> Builtin:
        """Return a function of two expressions as one of any number of syntax nodes."""

        def read(node: ast.Call, scope: Scope) -> sympy.Expr:
            first, *rest = _read_arguments(node, scope, 2, None)
            return _placed(lambda: reduce(function, rest, first), node)

        return read

    def _deadzone(self, node: ast.Call, scope: Scope) -> sympy.Expr:
        """deadzone(x, a) is zero for -a < x < a, deadzone(x, low, high) between two thresholds; of slope 1 beyond."""
        x, *ends = _read_arguments(node, scope, 2, 3)
        low, high = (-ends[0], ends[0]) if len(ends) == 1 else ends
        return _placed(lambda: self._ramp(x - high) + (1 - self.read(x - low)) * (x - low), node)

    def _where(self, node: ast.Call, scope: Scope) -> sympy.Expr:
        if len(node.args) != 3:
            raise ExpressionError(f"where(condition, a, b) takes 3 arguments, found {len(node.args)}", node.col_offset)
        condition = translate_condition(node.args[0], scope)
        a, b = (translate_expression(arg, scope) for arg in node.args[1:])
        return _placed(lambda: b + self.weigh(condition) * (a - b), node)

    def weigh(self, condition: Boolean) -> sympy.Expr:
        """Return 1 where a condition holds and 0 where it does not, as an expression in digits."""
        if condition in (sympy.true, sympy.false):
            raise ExpressionError("this condition never changes")
        if isinstance(condition, Relational):
            return self.read(condition.gts - condition.lts)
        parts = [self.weigh(part) for part in condition.args]
        if isinstance(condition, sympy.Not):
            return 1 - parts[0]
        if isinstance(condition, sympy.And):
            return sympy.Mul(*parts)
        return 1 - sympy.Mul(*(1 - part for part in parts))


def _read_arguments(node: ast.Call, scope: Scope, least: int, most: int | None) -> list[sympy.Expr]:
    n, name = len(node.args), node.func.id if isinstance(node.func, ast.Name) else ""
    if n < least or (most is not None and n > most):
        wanted = f"{least}" if most == least else f"{least} or more" if most is None else f"{least} to {most}"
        raise ExpressionError(f"{name} takes {wanted} argument(s), found {n}", node.col_offset)
    return [translate_expression(arg, scope) for arg in node.args]


def _placed(make: Callable[[], sympy.Expr], node: ast.Call) -> sympy.Expr:
    """Return what ``make`` makes; its error is placed at ``node``."""
    try:
        return make()
    except ExpressionError as exc:
        raise ExpressionError(str(exc), node.col_offset) from exc
