"""Whether what depends on t repeats after the forcing period."""

from __future__ import annotations

import math
import random
from collections.abc import Mapping, Sequence

import sympy

from pddecont.model.evaluation import count_terms, evaluate
from pddecont.model.expression import TIME

N_POINTS = 8
# Differences that are smaller than this part of the terms that are added are rounding.
SAME = 1e-7
# Points at which an expression must differ; at a single one it may be rounding that something steep has magnified.
ENOUGH = 2
# Terms that are compared at most; a model that is written out longer is not compared further.
MAX_TERMS = 30_000

Numbers = Mapping[sympy.Symbol, float]


def explain_non_periodic(named: Sequence[tuple[str, sympy.Expr]], period: float, numbers: Numbers) -> str:
    """Return what does not repeat after ``period`` among expressions over a model, in words; empty if all do.

    They are compared at random times, states and delayed values, the same at every call; where one has no finite value
    it is not.

    Parameters
    ----------
    named
        What the expressions are called, and the expressions.
    period
        The forcing period.
    numbers
        The parameters' values.
    """
    left = MAX_TERMS
    for name, expr in named:
        if TIME not in expr.free_symbols:
            continue
        # Terms without t, which may be far larger than the forcing, repeat as they are.
        whole = sympy.Add(*(a for a in sympy.Add.make_args(expr) if TIME in a.free_symbols), evaluate=False)
        left -= count_terms(whole)
        if left < 0:
            break
        points = _points(whole, period, numbers)
        if not _differs(whole, points):
            continue
        part: sympy.Expr = whole
        while part.is_Add or part.is_Mul:
            part = next((a for a in part.args if _differs(a, points)), None) or whole
            if part is whole:
                break
        a, b = max(points, key=lambda pair: _difference(part, *pair))
        what = name if part == expr else f"{part} in {name}"
        return (
            f"{what} does not repeat after the forcing period {period:.8g}: it is {evaluate(part, a):.6g} "
            f"at t = {a[TIME]:.6g} and {evaluate(part, b):.6g} at t = {b[TIME]:.6g}"
        )
    return ""


def _points(expr: sympy.Expr, period: float, numbers: Numbers) -> list[tuple[Numbers, Numbers]]:
    """Return points at some times, each with the same point a period later."""
    draw = random.Random(1)
    known = {s: numbers[s] for s in expr.free_symbols if s in numbers}
    free = sorted((s for s in expr.free_symbols if s not in known and s != TIME), key=str)
    points: list[tuple[Numbers, Numbers]] = []
    for i in range(N_POINTS):
        # Half of the points have positive states only: roots and logarithms exist there.
        low = 0.0 if i % 2 else -1.0
        here = {**known, **{s: draw.uniform(low, 1.0) for s in free}}
        t = draw.uniform(0.0, period)
        points.append(({**here, TIME: t}, {**here, TIME: t + period}))
    return points


def _differs(expr: sympy.Expr, points: Sequence[tuple[Numbers, Numbers]]) -> bool:
    """Whether an expression differs at some points from what it is a period later."""
    if TIME not in expr.free_symbols:
        return False
    terms = max((s for a, _ in points if math.isfinite(s := _size(expr, a))), default=0.0)
    return sum(_difference(expr, a, b) > SAME * terms for a, b in points) >= ENOUGH


def _difference(expr: sympy.Expr, a: Numbers, b: Numbers) -> float:
    """Return how far an expression's values at two points lie apart; zero if one of them is not finite."""
    here, there = evaluate(expr, a), evaluate(expr, b)
    return abs(here - there) if math.isfinite(here) and math.isfinite(there) else 0.0


def _size(expr: sympy.Expr, numbers: Numbers) -> float:
    """Return how large the terms are that an expression adds."""
    if expr.is_Add:
        return math.fsum(_size(a, numbers) for a in expr.args)
    if expr.is_Mul:
        return math.prod(_size(a, numbers) for a in expr.args)
    return abs(evaluate(expr, numbers))
