"""Expressions over boxes: intervals that hold their values and those of their derivatives.

Derivatives are taken forwards, by the chain rule from the variables up: no expression of theirs is written out, and
each rule knows where its function has none. Where a function has a corner its slope is the interval of the slopes on
both sides (Clarke's generalised gradient), so that f(x) - f(y) = J (x - y) with a J in the interval for all x and y of
a box over which f is sure.

Reference: Rall, Corliss, An Introduction to Automatic Differentiation (1996).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import sympy

from pddecont.intervals import functions
from pddecont.intervals.arithmetic import Array, Interval, invert, make_interval, make_point, replace_where, stack
from pddecont.intervals.functions import make_number

Slopes: TypeAlias = Mapping[int, Interval]
ONE = make_number(1.0, exact=True)
ZERO = make_number(0.0, exact=True)


@dataclass(frozen=True, eq=False)
class _Term:
    """The values of an expression, and of its derivatives in the variables that it reads by their numbers."""

    value: Interval
    slopes: Slopes


@dataclass(frozen=True, eq=False)
class Enclosure:
    """Expressions of ``variables``, the other symbols being ``constants``; boxes stand on the last axis of arrays."""

    exprs: tuple[sympy.Expr, ...]
    variables: tuple[sympy.Symbol, ...]
    constants: Mapping[sympy.Symbol, float]

    def values(self, low: Array, high: Array) -> Interval:
        """Return the values over boxes (n_variables, n_boxes), shape (n_exprs, n_boxes)."""
        return self._stack_values(self._evaluate(low, high, slopes=False), low.shape[1])

    def derivatives(self, low: Array, high: Array) -> tuple[Interval, Interval]:
        """Return the values and the slopes over boxes, the latter of shape (n_exprs, n_variables, n_boxes)."""
        terms, n = self._evaluate(low, high, slopes=True), low.shape[1]
        rows = [stack([_spread(term.slopes.get(k, ZERO), n) for k in range(len(self.variables))]) for term in terms]
        return self._stack_values(terms, n), stack(rows)

    @staticmethod
    def _stack_values(terms: Sequence[_Term], n: int) -> Interval:
        return stack([_spread(term.value, n) for term in terms])

    def _evaluate(self, low: Array, high: Array, *, slopes: bool) -> list[_Term]:
        known: dict[sympy.Basic, _Term] = {s: _Term(make_number(v, exact=True), {}) for s, v in self.constants.items()}
        for k, symbol in enumerate(self.variables):
            known[symbol] = _Term(make_interval(low[k], high[k]), {k: ONE} if slopes else {})

        def find(e: sympy.Basic) -> _Term:
            if e not in known:
                known[e] = _combine(e, [find(a) for a in e.args])
            return known[e]

        with np.errstate(all="ignore"):
            return [find(expr) for expr in self.exprs]


def _combine(e: sympy.Basic, args: list[_Term]) -> _Term:
    """Return an expression of its arguments; the whole line for what no rule is known for."""
    if not e.args:
        return _Term(_enclose_number(e), {})
    if e.is_Add:
        return _fold(_add, args)
    if e.is_Mul:
        return _negate(_fold(_multiply, args[1:])) if e.args[0] == -1 else _fold(_multiply, args)
    if e.is_Pow:
        return _raise(*args)
    if e.func in _UNARY:
        function, differentiate = _UNARY[e.func]
        (arg,) = args
        value = function(arg.value)
        return _Term(value, _chain(differentiate(arg.value, value), arg.slopes) if arg.slopes else {})
    if e.func is sympy.atan2:
        return _find_angle(*args)
    line = replace_where(np.array([True]), -np.inf, np.inf, ZERO)
    return _Term(line, {k: line for a in args for k in a.slopes})


def _enclose_number(e: sympy.Basic) -> Interval:
    if e.is_Rational:
        value = e.p / e.q
        return make_number(value, exact=value.as_integer_ratio() == (e.p, e.q))
    return make_number(float(e), exact=bool(e.is_Float))


def _chain(slope: Interval, slopes: Slopes) -> Slopes:
    """Return the slopes of a function whose argument has some."""
    return {k: slope if s is ONE else slope * s for k, s in slopes.items()}


def _fold(combine: Callable[[_Term, _Term], _Term], args: list[_Term]) -> _Term:
    total = args[0]
    for arg in args[1:]:
        total = combine(total, arg)
    return total


def _add(a: _Term, b: _Term) -> _Term:
    return _Term(a.value + b.value, _add_slopes(a.slopes, b.slopes))


def _add_slopes(a: Slopes, b: Slopes) -> Slopes:
    both = a.keys() & b.keys()
    return {**a, **b, **{k: a[k] + b[k] for k in both}}


def _negate(a: _Term) -> _Term:
    return _Term(-a.value, {k: -s for k, s in a.slopes.items()})


def _multiply(a: _Term, b: _Term) -> _Term:
    return _Term(a.value * b.value, _add_slopes(_chain(b.value, a.slopes), _chain(a.value, b.slopes)))


def _raise(base: _Term, exponent: _Term) -> _Term:
    """Return a power; (b^e)' = e b^(e-1) b' + b^e log(b) e'."""
    value = functions.power(base.value, exponent.value)
    slopes: Slopes = {}
    if base.slopes and np.any(exponent.value.magnitude != 0.0):
        slope = exponent.value * functions.power(base.value, exponent.value - ONE)
        slopes = _chain(slope, base.slopes)
    if exponent.slopes:
        slope = value * functions.log(base.value)
        slopes = _add_slopes(slopes, _chain(slope, exponent.slopes))
    return _Term(value, slopes)


def _find_angle(y: _Term, x: _Term) -> _Term:
    """Return atan2(y, x), with the derivative (x y' - y x') / (x^2 + y^2)."""
    size = invert(functions.raise_to(x.value, 2.0) + functions.raise_to(y.value, 2.0))
    up, across = x.value * size, -(y.value * size)
    slopes = _add_slopes(_chain(up, y.slopes), _chain(across, x.slopes))
    return _Term(functions.atan2(y.value, x.value), slopes)


def _spread(x: Interval, n: int) -> Interval:
    """Return intervals of ``n`` boxes, those that are the same for all of them repeated."""
    return Interval(np.broadcast_to(x.low, (n,)), np.broadcast_to(x.high, (n,)), np.broadcast_to(x.sure, (n,)))


def _slope_of_root(x: Interval) -> Interval:
    """Return 1 / sqrt(1 - x^2)."""
    return invert(functions.sqrt(ONE - functions.raise_to(x, 2.0)))


def _slope_of_sign(x: Interval, value: Interval) -> Interval:
    """Return zero, and the whole line where the sign jumps."""
    zero = make_point(np.where(x.is_empty, np.nan, 0.0))
    return replace_where(x.holds_zero, -np.inf, np.inf, zero)


# Each function with its derivative as a function of the argument and the value.
_UNARY: dict[type, tuple[Callable[[Interval], Interval], Callable[[Interval, Interval], Interval]]] = {
    sympy.exp: (functions.exp, lambda x, v: v),
    sympy.log: (functions.log, lambda x, v: invert(x)),
    sympy.sin: (functions.sin, lambda x, v: functions.cos(x)),
    sympy.cos: (functions.cos, lambda x, v: -functions.sin(x)),
    sympy.tan: (functions.tan, lambda x, v: ONE + functions.raise_to(v, 2.0)),
    sympy.asin: (functions.asin, lambda x, v: _slope_of_root(x)),
    sympy.acos: (functions.acos, lambda x, v: -_slope_of_root(x)),
    sympy.atan: (functions.atan, lambda x, v: invert(ONE + functions.raise_to(x, 2.0))),
    sympy.sinh: (functions.sinh, lambda x, v: functions.cosh(x)),
    sympy.cosh: (functions.cosh, lambda x, v: functions.sinh(x)),
    sympy.tanh: (functions.tanh, lambda x, v: ONE - functions.raise_to(v, 2.0)),
    sympy.Abs: (functions.absolute, lambda x, v: functions.sign(x)),
    sympy.sign: (functions.sign, _slope_of_sign),
}
