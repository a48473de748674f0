"""Whether an expression is zero wherever it is evaluated, or wherever another one is: asked at random points.

Symbolic simplification may take for ever and may still not see it; a value that is rounding at several points drawn at
random is no accident.
"""

from __future__ import annotations

import math
import random
from collections.abc import Collection, Iterator, Mapping, Sequence

import numpy as np
import sympy

from pddecont.model.evaluation import evaluate

# Points at which an expression must be zero, those that are tried at most, and what counts as rounding in its terms. A
# function of time has many zeros, and at half of them a ramp may not jump: so many points do not all lie there.
N_POINTS, N_TRIES, ROUNDING = 12, 100, 1e-9
# Steps of Newton's method to a point of the surface.
MAX_STEPS = 30


def vanishes(expr: sympy.Expr) -> bool:
    """Return whether an expression is zero at every point at which it has a value."""
    return vanishes_where(expr, sympy.S.Zero, ())


def vanishes_where(expr: sympy.Expr, surface: sympy.Expr, moving: Collection[sympy.Symbol]) -> bool:
    """Return whether ``expr`` is zero at every point at which ``surface`` is.

    Points of the surface are found along one of the symbols ``moving``.
    """
    if expr.is_Number:
        return bool(expr.is_zero)
    draw = random.Random(1)
    symbols = sorted(expr.free_symbols | surface.free_symbols, key=str)
    along = sorted(surface.free_symbols & set(moving), key=str)
    found = 0
    for _ in range(N_TRIES):
        point = {s: draw.uniform(0.2, 1.7) for s in symbols}
        if along and not _move_to(surface, draw.choice(along), point):
            continue
        size = measure_terms(expr, point)
        if not math.isfinite(size):
            continue
        if abs(evaluate(expr, point)) > ROUNDING * max(size, 1e-300):
            return False
        found += 1
        if found == N_POINTS:
            return True
    return False


def find_rank(rows: Sequence[Sequence[sympy.Expr]]) -> int:
    """Return the largest rank that a matrix of expressions has at points drawn at random."""
    draw, largest = random.Random(1), 0
    symbols = sorted(set().union(*(e.free_symbols for row in rows for e in row)), key=str)
    for _ in range(N_POINTS if symbols else 1):
        point = {s: draw.uniform(0.2, 1.7) for s in symbols}
        numbers = np.array([[evaluate(e, point) for e in row] for row in rows])
        if np.all(np.isfinite(numbers)):
            scale = np.max(np.abs(numbers), axis=1, keepdims=True)
            largest = max(largest, int(np.linalg.matrix_rank(numbers / np.where(scale > 0.0, scale, 1.0), ROUNDING)))
    return largest


def _move_to(surface: sympy.Expr, symbol: sympy.Symbol, point: dict[sympy.Symbol, float]) -> bool:
    """Move a point along a symbol to where ``surface`` is zero; return whether that was found."""
    slope = surface.diff(symbol)
    for _ in range(MAX_STEPS):
        value, steepness = evaluate(surface, point), evaluate(slope, point)
        if not math.isfinite(value) or not math.isfinite(steepness) or steepness == 0.0:
            return False
        change = value / steepness
        point[symbol] -= change
        if abs(change) <= 1e-15 * (1.0 + abs(point[symbol])):
            return True
    return False


def measure_terms(expr: sympy.Expr, point: Mapping[sympy.Symbol, float]) -> float:
    """Return how large what an expression adds and multiplies is: rounding is counted in it."""
    if expr.is_Add:
        return math.fsum(measure_terms(a, point) for a in expr.args)
    if expr.is_Mul:
        return math.prod(measure_terms(a, point) for a in expr.args)
    if expr.is_Pow and expr.exp.is_Integer and expr.exp > 0:
        return float(measure_terms(expr.base, point) ** int(expr.exp))
    value = abs(evaluate(expr, point))
    # What rounding in its arguments makes of a function's value counts too.
    slopes = ((a, expr.diff(s).xreplace({s: a})) for a, s, expr in _list_arguments(expr))
    return value + math.fsum(abs(evaluate(slope, point)) * measure_terms(a, point) for a, slope in slopes)


def _list_arguments(expr: sympy.Expr) -> Iterator[tuple[sympy.Expr, sympy.Symbol, sympy.Expr]]:
    """Yield each argument of a function, a symbol, and the function with the symbol in the argument's place."""
    for k, argument in enumerate(expr.args if isinstance(expr, sympy.Function) else ()):
        symbol = sympy.Dummy(real=True)
        yield argument, symbol, expr.func(*(symbol if i == k else a for i, a in enumerate(expr.args)))
