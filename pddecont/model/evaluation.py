"""What an expression is worth, in plain doubles, and how large it is.

Numbers that a file writes are never worked out with more digits than a double has: a tower of powers is infinite here
at once, where exact arithmetic would fill the memory.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import sympy

_FUNCTIONS: dict[type, Callable[..., float]] = {
    sympy.sin: math.sin,
    sympy.cos: math.cos,
    sympy.tan: math.tan,
    sympy.asin: math.asin,
    sympy.acos: math.acos,
    sympy.atan: math.atan,
    sympy.atan2: math.atan2,
    sympy.sinh: math.sinh,
    sympy.cosh: math.cosh,
    sympy.tanh: math.tanh,
    sympy.exp: math.exp,
    sympy.log: math.log,
    sympy.Abs: abs,
    sympy.sign: lambda v: math.copysign(1.0, v) if v else 0.0,
}
FUNCTIONS = frozenset(_FUNCTIONS)


def evaluate(expr: sympy.Expr, numbers: Mapping[sympy.Symbol, float] | None = None) -> float:
    """Return what ``expr`` is worth where its symbols have ``numbers``.

    The result is NaN or an infinity where that is no finite real number.
    """
    known: dict[sympy.Basic, float] = dict(numbers or {})

    def worth(e: sympy.Expr) -> float:
        if e not in known:
            try:
                known[e] = _worth(e, [worth(a) for a in e.args])
            except (ValueError, ZeroDivisionError):
                known[e] = math.nan
            except OverflowError:
                known[e] = math.inf
        return known[e]

    return worth(expr)


def apply_function(function: type, args: list[float]) -> float:
    """Return a function's value; NaN or an infinity where it has no finite one."""
    try:
        return _FUNCTIONS[function](*args)
    except ValueError:
        return math.nan
    except OverflowError:
        return math.inf


def raise_power(a: float, b: float) -> float:
    """Return the power a**b; NaN or an infinity where it is no finite real number."""
    try:
        return math.sqrt(a) if b == 0.5 else math.pow(a, b)
    except (ValueError, ZeroDivisionError):
        return math.nan
    except OverflowError:
        return math.inf


def _worth(e: sympy.Expr, args: list[float]) -> float:
    if isinstance(e, sympy.Rational):
        result: float = e.p / e.q
        return result
    if e.is_Add:
        return math.fsum(args)
    if e.is_Mul:
        return math.prod(args)
    if e.is_Pow:
        return 1.0 / args[0] if args[1] == -1.0 else raise_power(*args)
    if e.func in _FUNCTIONS:
        return apply_function(e.func, args)
    if isinstance(e, sympy.Float | sympy.NumberSymbol):
        return float(e)
    return math.nan


def count_terms(expr: sympy.Expr, weights: Mapping[sympy.Symbol, int] | None = None) -> int:
    """Return the number of terms that ``expr`` has when it is written out.

    Symbols count as ``weights`` say, else as one.
    """
    known: dict[sympy.Basic, int] = dict(weights or {})

    def count(e: sympy.Basic) -> int:
        if e not in known:
            known[e] = 1 + sum(map(count, e.args))
        return known[e]

    return count(expr)


def bound_derivative_terms(expr: sympy.Expr) -> int:
    """Return a bound on the number of terms of a derivative of ``expr`` that is written out, without taking it."""
    known: dict[sympy.Basic, int] = {}

    def count(e: sympy.Basic) -> int:
        if e not in known:
            inner = sum(map(count, e.args))
            known[e] = (
                inner + (len(e.args) if e.is_Mul else 2) * count_terms(e) if e.args and not e.is_Add else inner + 1
            )
        return known[e]

    return count(expr)


def measure_depth(expr: sympy.Basic) -> int:
    """Return how deeply ``expr`` is nested."""
    known: dict[sympy.Basic, int] = {}

    def level(e: sympy.Basic) -> int:
        if e not in known:
            known[e] = 1 + max(map(level, e.args), default=0)
        return known[e]

    return level(expr)
