"""Derivatives of expressions over a model, in all the symbols that they hold at once.

One pass from the symbols upwards finds, for every part of an expression, its derivatives in the symbols that it holds;
parts that several expressions share are differentiated once. The derivatives are those of :meth:`sympy.Expr.diff`, term
for term; that method asks of every part, for every symbol, what kind of number it is, and that takes most of its time.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import TypeAlias

import sympy
from sympy.core.function import ArgumentIndexError

from pddecont.model.lagged import ChainRule

# The derivatives of an expression that are not zero, by symbol.
Gradient: TypeAlias = Mapping[sympy.Symbol, sympy.Expr]
# Takes an expression and the derivatives of its arguments to its own.
Rule: TypeAlias = Callable[[sympy.Expr, Sequence[Gradient]], Gradient]


def differentiate(expr: sympy.Expr, symbol: sympy.Symbol, chain: ChainRule) -> sympy.Expr:
    """Return the derivative of an expression over a model, through delays that vary too."""
    return find_slopes([expr], [symbol], chain).get((0, 0), sympy.S.Zero)


def find_slopes(
    exprs: Sequence[sympy.Expr], symbols: Sequence[sympy.Symbol], chain: ChainRule
) -> dict[tuple[int, int], sympy.Expr]:
    """Return the derivatives of expressions over a model that are not zero, through delays that vary too.

    They are known by the numbers of the expression and the symbol, and come in order of these.
    """
    number = {s: k for k, s in enumerate(symbols)}
    gradients = _Gradients({*number, *chain}, chain)
    slopes: dict[tuple[int, int], sympy.Expr] = {}
    for i, expr in enumerate(exprs):
        found = {number[s]: slope for s, slope in gradients.find_whole(expr).items() if s in number}
        slopes |= {(i, k): found[k] for k in sorted(found)}
    return slopes


class _Gradients:
    """The derivatives of expressions, and of their parts, in some symbols."""

    def __init__(self, symbols: Collection[sympy.Symbol], chain: ChainRule) -> None:
        self._symbols, self._chain = symbols, chain
        self._known: dict[sympy.Basic, Gradient] = {}

    def find_whole(self, expr: sympy.Expr) -> Gradient:
        """Return the derivatives of an expression, through delays that vary too."""
        gradient = self._find(expr)
        reads = gradient.keys() & self._chain.keys()
        if not reads:
            return gradient
        result = dict(gradient)
        for read in sorted(reads, key=str):
            for inner, slope in self._chain[read]:
                for symbol, moved in self.find_whole(inner).items():
                    result[symbol] = result.get(symbol, sympy.S.Zero) + gradient[read] * slope * moved
        return _keep_nonzero(result)

    def _find(self, expr: sympy.Basic) -> Gradient:
        if not expr.args:
            return {expr: sympy.S.One} if expr in self._symbols else {}
        if expr not in self._known:
            self._known[expr] = _keep_nonzero(self._find_slopes(expr))
        return self._known[expr]

    def _find_slopes(self, expr: sympy.Basic) -> Gradient:
        rule = _find_rule(expr)
        if rule is not None:
            return rule(expr, [self._find(part) for part in expr.args])
        # Choices between numbers, and functions with corners.
        return {s: expr.diff(s) for s in expr.free_symbols if s in self._symbols}


def _find_rule(expr: sympy.Basic) -> Rule | None:
    if expr.is_Add:
        return _differentiate_sum
    if expr.is_Mul:
        return _differentiate_product
    if expr.is_Pow:
        return _differentiate_power
    by_arguments = getattr(type(expr), "_eval_derivative", None) is sympy.Function._eval_derivative
    return _differentiate_function if by_arguments else None


def _differentiate_sum(expr: sympy.Add, inner: Sequence[Gradient]) -> Gradient:
    return _add(item for gradient in inner for item in gradient.items())


def _differentiate_product(expr: sympy.Mul, inner: Sequence[Gradient]) -> Gradient:
    return _add(
        (s, sympy.Mul(*expr.args[:i], slope, *expr.args[i + 1 :]))
        for i, gradient in enumerate(inner)
        for s, slope in gradient.items()
    )


def _differentiate_power(expr: sympy.Pow, inner: Sequence[Gradient]) -> Gradient:
    base, exponent = expr.args
    slopes = {s: slope * exponent / base for s, slope in inner[0].items()}
    for s, slope in inner[1].items():
        slopes[s] = slope * sympy.log(base) + slopes.get(s, sympy.S.Zero)
    return {s: expr * slope for s, slope in slopes.items()}


def _differentiate_function(expr: sympy.Function, inner: Sequence[Gradient]) -> Gradient:
    outer = {i: _differentiate_in(expr, i + 1) for i, gradient in enumerate(inner) if gradient}
    return _add((s, outer[i] * slope) for i, gradient in enumerate(inner) for s, slope in gradient.items())


def _differentiate_in(expr: sympy.Function, place: int) -> sympy.Expr:
    """Return a function's derivative in one of its arguments, counted from 1."""
    try:
        return expr.fdiff(place)
    except ArgumentIndexError:
        return sympy.Function.fdiff(expr, place)


def _add(terms: Iterable[tuple[sympy.Symbol, sympy.Expr]]) -> Gradient:
    """Return the sum of the terms of each symbol."""
    groups: dict[sympy.Symbol, list[sympy.Expr]] = {}
    for symbol, term in terms:
        groups.setdefault(symbol, []).append(term)
    return {symbol: sympy.Add(*group) for symbol, group in groups.items()}


def _keep_nonzero(gradient: Gradient) -> Gradient:
    return {symbol: slope for symbol, slope in gradient.items() if slope != 0}
