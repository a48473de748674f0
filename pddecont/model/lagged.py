"""Values of the past that a model reads: states, rates and integrals, by delays that may vary along a motion.

A read whose delay varies depends on what the delay depends on: with y = x(t - tau(v))

    dy/dv = -x'(t - tau) dtau/dv

and an integral of g(s, x(t - s)) over s from a(v) to b(v) changes by g(b, x(t - b)) db/dv - g(a, x(t - a)) da/dv. A
model reads all the values that these derivatives hold (:func:`close_reads`), so that they are expressions over it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import sympy

from pddecont.model.expression import TIME

PRIMES = ("", "'", "''")


@dataclass(frozen=True)
class DelayedValue:
    """A state read a delay ago: the numbers of both, and how often it is differentiated there.

    Delays are numbered through the model's constant ones and then those that vary.
    """

    state: int
    delay: int
    derivative: int = 0


@dataclass(frozen=True)
class Integral:
    """The integral of ``integrand`` over lags s from ``low`` to ``high``.

    In the integrand t stands for the lag s and the symbol of a state for its value at t - s; it holds parameters
    besides. The limits are expressions as delays are.
    """

    integrand: sympy.Expr
    low: sympy.Expr
    high: sympy.Expr


# How a value changes with what it is read by: (expression, derivative in it) pairs.
Ways: TypeAlias = tuple[tuple[sympy.Expr, sympy.Expr], ...]
ChainRule: TypeAlias = Mapping[sympy.Symbol, Ways]


def make_symbol(name: str) -> sympy.Symbol:
    """Return the symbol of a state or parameter."""
    return sympy.Symbol(name, real=True)


def make_delayed_symbol(state: str, delay: sympy.Expr, derivative: int = 0) -> sympy.Symbol:
    """Return the symbol of a state's delayed value, or rate; its name cannot be typed as an identifier."""
    written = f"({delay})" if delay.is_Add else str(delay)
    return sympy.Symbol(f"{state}{PRIMES[derivative]}(t - {written})", real=True)


def make_integral_symbol(integral: Integral, states: Sequence[str]) -> sympy.Symbol:
    """Return the symbol of an integral over the past; its name cannot be typed as an identifier."""
    lag = sympy.Symbol("s")
    past = {make_symbol(name): sympy.Symbol(f"{name}(t - s)") for name in states}
    written = integral.integrand.xreplace({TIME: lag, **past})
    return sympy.Symbol(f"integral({written}, s, {integral.low}, {integral.high})", real=True)


def find_reading_symbols(expr: sympy.Expr, chain: ChainRule) -> set[sympy.Symbol]:
    """Return the symbols that an expression depends on, those in delays and limits too."""
    found: set[sympy.Symbol] = set(expr.free_symbols)
    for read in expr.free_symbols & chain.keys():
        for inner, _ in chain[read]:
            found |= find_reading_symbols(inner, chain)
    return found


def make_chain_rule(
    states: Sequence[str],
    delays: Sequence[sympy.Expr],
    varying: Sequence[sympy.Expr],
    delayed: Sequence[DelayedValue],
    integrals: Sequence[Integral],
) -> dict[sympy.Symbol, Ways]:
    """Return how the values that a model reads change with what their delays and limits depend on."""
    chain: dict[sympy.Symbol, Ways] = {}
    every = (*delays, *varying)
    for read in delayed:
        lag = every[read.delay]
        if read.delay >= len(delays) and read.derivative + 1 < len(PRIMES):
            rate = make_delayed_symbol(states[read.state], lag, read.derivative + 1)
            chain[make_delayed_symbol(states[read.state], lag, read.derivative)] = ((lag, -rate),)
    for integral in integrals:
        ways = [(integral.high, read_integrand(integral, integral.high, states))]
        ways.append((integral.low, -read_integrand(integral, integral.low, states)))
        slopes = list_parameter_slopes(integral, states)
        # Those of slopes themselves are not read: nothing is differentiated twice in a parameter.
        ways += [(p, make_integral_symbol(slope, states)) for p, slope in slopes if slope in integrals]
        moving = tuple((limit, slope) for limit, slope in ways if limit.free_symbols and slope != 0)
        if moving:
            chain[make_integral_symbol(integral, states)] = moving
    return chain


def read_integrand(integral: Integral, lag: sympy.Expr, states: Sequence[str]) -> sympy.Expr:
    """Return an integrand at one lag, as an expression over the model."""
    past = {make_symbol(name): make_symbol(name) if lag == 0 else make_delayed_symbol(name, lag) for name in states}
    return integral.integrand.xreplace({**past, TIME: lag})


def list_parameter_slopes(integral: Integral, states: Sequence[str]) -> list[tuple[sympy.Symbol, Integral]]:
    """Return the derivatives of an integral in the parameters that its integrand holds, which are integrals too."""
    inside = integral.integrand.free_symbols - {TIME, *map(make_symbol, states)}
    slopes = ((p, integral.integrand.diff(p)) for p in sorted(inside, key=str))
    return [(p, Integral(slope, integral.low, integral.high)) for p, slope in slopes if slope != 0]


def close_reads(delayed: Sequence[DelayedValue], n_constant: int) -> tuple[DelayedValue, ...]:
    """Return the delayed values with the rates that the derivatives of those with delays that vary hold."""
    rates = [
        DelayedValue(read.state, read.delay, read.derivative + 1)
        for read in delayed
        if read.delay >= n_constant and read.derivative + 1 < len(PRIMES)
    ]
    return tuple(dict.fromkeys([*delayed, *rates]))


def arrange_delays(
    delays: Sequence[sympy.Expr], delayed: Sequence[DelayedValue], varies: Sequence[bool]
) -> tuple[tuple[sympy.Expr, ...], tuple[sympy.Expr, ...], tuple[DelayedValue, ...]]:
    """Return the constant delays, those that vary, and the delayed values with the delays numbered through both."""
    order = [k for k, v in enumerate(varies) if not v] + [k for k, v in enumerate(varies) if v]
    n_constant = len(delays) - sum(varies)
    renumbered = [DelayedValue(read.state, order.index(read.delay), read.derivative) for read in delayed]
    arranged = tuple(delays[k] for k in order)
    return arranged[:n_constant], arranged[n_constant:], tuple(renumbered)
