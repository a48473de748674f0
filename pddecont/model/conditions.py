"""Conditions: comparisons of expressions, joined by ``and``, ``or`` and ``not``.

A condition is kept as sympy's logic of its comparisons, so that what contradicts itself is seen at once. How far it is
from changing is a number: a comparison has the difference of its sides, ``and`` the least of its parts, ``or`` the
largest; it is positive where the condition holds and passes zero where it begins to.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, TypeVar

import sympy
from sympy.core.relational import Relational
from sympy.logic.boolalg import Boolean

from pddecont.model.evaluation import evaluate
from pddecont.model.expression import Scope, substitute, translate_expression
from pddecont.model.syntax import ExpressionError, parse_syntax

T = TypeVar("T")
COMPARISONS: Mapping[type[ast.cmpop], Callable[[sympy.Expr, sympy.Expr], Boolean]] = {
    ast.Gt: sympy.Gt,
    ast.GtE: sympy.Ge,
    ast.Lt: sympy.Lt,
    ast.LtE: sympy.Le,
}
EXAMPLE = "write a comparison such as v > 0, or several joined by and, or, not"


def parse_condition(text: str | float, scope: Scope) -> Boolean:
    """Return the condition that ``text`` writes; raise :class:`ExpressionError` with an offset into it."""
    if not isinstance(text, str):
        raise ExpressionError(f"{text} is a number; {EXAMPLE}")
    return translate_condition(parse_syntax(text, logical=True), scope)


def translate_condition(node: ast.expr, scope: Scope) -> Boolean:
    """Return the condition of a syntax node (used by built-in functions for their arguments)."""
    if isinstance(node, ast.BoolOp):
        join = sympy.And if isinstance(node.op, ast.And) else sympy.Or
        return join(*(translate_condition(part, scope) for part in node.values))
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        return sympy.Not(translate_condition(node.operand, scope))
    if isinstance(node, ast.Compare):
        sides = [node.left, *node.comparators]
        return sympy.And(*map(lambda op, a, b: _compare(op, a, b, scope), node.ops, sides, sides[1:]))
    raise ExpressionError(f"this is no condition; {EXAMPLE}", node.col_offset)


def _compare(op: ast.cmpop, left: ast.expr, right: ast.expr, scope: Scope) -> Boolean:
    if type(op) not in COMPARISONS:
        raise ExpressionError("only > >= < <= compare here; two of them make a narrow band", left.col_offset)
    return COMPARISONS[type(op)](translate_expression(left, scope), translate_expression(right, scope))


@cache
def list_differences(condition: Boolean) -> tuple[sympy.Expr, ...]:
    """Return an expression for each comparison in a condition, positive where it holds."""
    return tuple(map(_subtract, sorted(condition.atoms(Relational), key=sympy.default_sort_key)))


def combine_differences(condition: Boolean, values: Mapping[sympy.Expr, float]) -> float:
    """Return how far a condition is from changing, from the values of :func:`list_differences`."""
    if condition in (sympy.true, sympy.false):
        return float("inf") if condition else float("-inf")
    if isinstance(condition, Relational):
        return values[_subtract(condition)]
    if isinstance(condition, sympy.Not):
        return -combine_differences(condition.args[0], values)
    parts = [combine_differences(part, values) for part in condition.args]
    return min(parts) if isinstance(condition, sympy.And) else max(parts)


def holds(condition: Boolean, numbers: Mapping[sympy.Symbol, float]) -> bool:
    """Return whether a condition holds where its symbols have ``numbers``."""
    if isinstance(condition, Relational):
        difference = evaluate(_subtract(condition), numbers)
        return difference > 0.0 or (difference == 0.0 and condition.func in (sympy.Ge, sympy.Le))
    parts = [holds(part, numbers) for part in condition.args]
    if isinstance(condition, sympy.Not):
        return not parts[0]
    return any(parts) if isinstance(condition, sympy.Or) else all(parts) and condition != sympy.false


def substitute_in(condition: Boolean, values: Mapping[sympy.Symbol, sympy.Expr]) -> Boolean:
    """Return a condition with expressions in the place of symbols."""
    if isinstance(condition, Relational):
        return condition.func(substitute(condition.lhs, values), substitute(condition.rhs, values))
    return condition.func(*(substitute_in(part, values) for part in condition.args))


@cache
def _subtract(comparison: Any) -> sympy.Expr:
    return comparison.gts - comparison.lts
