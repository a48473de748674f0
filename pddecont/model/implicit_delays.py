"""Delays that a condition defines, such as a threshold, as states that keep it.

Where G(t, x, ..., tau) = 0 defines tau, dG/dt = -G / tau is an equation for tau' in what the model reads:

    tau' = -(G_t + G_x x' + .. + G / tau) / G_tau

A motion that begins on G = 0 stays there, rounding and the errors of steps die away at the rate 1 / tau, and on a
periodic orbit G = 0 whatever the rate is.

References: Baumgarte, Comput. Methods Appl. Mech. Eng. 1 (1972), for the term G / tau; Smith, An Introduction to Delay
Differential Equations (2011), chapter 7, for threshold delays.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np
import scipy.optimize
import sympy

from pddecont.model.derivatives import differentiate
from pddecont.model.evaluation import evaluate
from pddecont.model.expression import TIME
from pddecont.model.lagged import Integral, make_integral_symbol, make_symbol, read_integrand
from pddecont.model.past_reads import PastReads
from pddecont.model.syntax import ExpressionError

# Delays between which the first one that meets a condition at the start is looked for, and how many are tried.
SHORTEST, LONGEST, N_TRIED = 1e-4, 1e4, 4000


def split_condition(text: str) -> tuple[str, str]:
    """Return the two sides of a condition 'a = b'; raise :class:`ExpressionError` where it is none."""
    sides = text.replace("==", "=").split("=")
    if len(sides) != 2 or not all(side.strip() for side in sides):
        raise ExpressionError("a delay is defined by an equation, as in 'integral(x(t - s), s, 0, tau) = 1'")
    return sides[0], sides[1]


def make_delay_equation(
    condition: sympy.Expr,
    delay: sympy.Symbol,
    states: Sequence[sympy.Symbol],
    field: Sequence[sympy.Expr],
    past: PastReads,
) -> sympy.Expr:
    """Return the derivative of a delay that a condition, zero where it holds, defines.

    ``field`` are the derivatives of ``states``; rates that the equation needs are read too.
    """
    chain = past.make_chain_rule()
    slope = differentiate(condition, delay, chain)
    if slope == 0:
        raise ExpressionError(f"this condition does not depend on {delay}")
    rate = differentiate(condition, TIME, chain)
    for x, f in zip(states, field, strict=True):
        rate += differentiate(condition, x, chain) * f
    for symbol, (state, lag, order) in list(past.list_delayed()):
        if symbol in condition.free_symbols:
            rate += condition.diff(symbol) * past.read(state, lag, order + 1)
    for integral in list(past.integrals):
        symbol = make_integral_symbol(integral, past.states)
        if symbol in condition.free_symbols:
            rate += condition.diff(symbol) * _find_rate(integral, past)
    return -(rate + condition / delay) / slope


def _find_rate(integral: Integral, past: PastReads) -> sympy.Expr:
    """Return how fast an integral changes while its limits stand still."""
    ends = [read_integrand(integral, limit, past.states) for limit in (integral.low, integral.high)]
    for limit in (integral.low, integral.high):
        for name in past.states if limit != 0 else ():
            if make_symbol(name) in integral.integrand.free_symbols:
                past.read(name, limit)
    inside = integral.integrand.diff(TIME)
    return ends[0] - ends[1] + (past.note(Integral(inside, integral.low, integral.high)) if inside != 0 else 0)


def find_delay_at_start(
    condition: sympy.Expr, delay: sympy.Symbol, past: PastReads, history: Mapping[str, sympy.Expr], guess: float | None
) -> sympy.Expr:
    """Return the delay at t = 0: a formula in the parameters where there is one, else its value at theirs.

    It is the one nearest to ``guess``, or the shortest.

    Raises
    ------
    ExpressionError
        If no delay meets the condition there.
    """
    written = _put_in_history(condition, delay, past, history)
    value = _make_value(condition, delay, past, history)
    tried = np.geomspace(SHORTEST, LONGEST, N_TRIED)
    sizes = np.array([value(tau) for tau in tried.tolist()])
    places = np.flatnonzero(np.isfinite(sizes[:-1] * sizes[1:]) & (sizes[:-1] * sizes[1:] <= 0.0))
    if not len(places):
        raise ExpressionError(f"no {delay} between {SHORTEST:g} and {LONGEST:g} meets this condition at the start")
    roots = [float(scipy.optimize.brentq(value, tried[i], tried[i + 1], xtol=1e-15, rtol=1e-14)) for i in places]
    root = roots[0] if guess is None else min(roots, key=lambda r: abs(r - guess))
    for formula in _solve(written, delay):
        known = evaluate(formula, past.numbers)
        if math.isfinite(known) and abs(known - root) <= 1e-9 * root:
            return formula
    return sympy.Float(root, 17)


def _solve(written: sympy.Expr | None, delay: sympy.Symbol) -> list[sympy.Expr]:
    if written is None:
        return []
    try:
        return [sympy.sympify(s) for s in sympy.solve(written, delay)]
    except (NotImplementedError, TypeError, ValueError):
        return []


def _put_in_history(
    condition: sympy.Expr, delay: sympy.Symbol, past: PastReads, history: Mapping[str, sympy.Expr]
) -> sympy.Expr | None:
    """Return the condition at t = 0 in the delay and the parameters; None where the history is no constant."""
    if any(TIME in expr.free_symbols for expr in history.values()):
        return None
    states = {make_symbol(name): expr for name, expr in history.items()}
    known: dict[sympy.Symbol, sympy.Expr] = {**states, TIME: sympy.S.Zero}
    for symbol, (state, _, order) in past.list_delayed():
        known[symbol] = sympy.S.Zero if order else history[state]
    lag = sympy.Symbol("(lag)", real=True)
    for integral in past.integrals:
        inside = integral.integrand.xreplace({**states, TIME: lag})
        low, high = (limit.xreplace(states) for limit in (integral.low, integral.high))
        known[make_integral_symbol(integral, past.states)] = sympy.integrate(inside, (lag, low, high))
    return condition.xreplace(known)


def _make_value(
    condition: sympy.Expr, delay: sympy.Symbol, past: PastReads, history: Mapping[str, sympy.Expr]
) -> Callable[[float], float]:
    """Return the condition at t = 0, at the parameters' values, as a function of the delay."""
    nodes, weights = np.polynomial.legendre.leggauss(40)

    def at(name: str, time: float, order: int = 0) -> float:
        expr = history[name].diff(TIME, order) if order else history[name]
        return evaluate(expr, {**past.numbers, TIME: time})

    def value(tau: float) -> float:
        known = {**past.numbers, delay: tau, TIME: 0.0, **{make_symbol(s): at(s, 0.0) for s in history}}
        for symbol, (state, lag, order) in past.list_delayed():
            known[symbol] = at(state, -evaluate(lag, known), order)
        for integral in past.integrals:
            symbol = make_integral_symbol(integral, past.states)
            if symbol in condition.free_symbols:
                low, high = evaluate(integral.low, known), evaluate(integral.high, known)
                lags = 0.5 * (low + high) + 0.5 * (high - low) * nodes
                inside = [
                    evaluate(
                        integral.integrand, {**past.numbers, TIME: s, **{make_symbol(n): at(n, -s) for n in history}}
                    )
                    for s in lags.tolist()
                ]
                known[symbol] = float(0.5 * (high - low) * np.dot(weights, inside))
        return evaluate(condition, known)

    return value
