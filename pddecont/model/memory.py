"""Integrals over all the past as states: exponential kernels by the linear chain.

With Y_0' = r (q - Y_0) and Y_k' = r (Y_{k-1} - Y_k), q = g(x(t - a)),

    integral over v from 0 to infinity of v^n exp(-r v) q(t - v) = n! / r^(n + 1) Y_n

so a kernel that is a sum of terms c s^n exp(-r s) becomes a few states, each of the size of q, and equal to it at rest.

Reference: MacDonald, Time Lags in Biological Models (1978), chapter 2 (the linear chain trick).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import factorial

import sympy

from pddecont.model.evaluation import evaluate
from pddecont.model.expression import TIME
from pddecont.model.lagged import make_symbol
from pddecont.model.syntax import ExpressionError

INFINITE = ("inf", "oo", "infinity")
# Powers of the lag in a kernel at most.
MAX_POWER = 50
KERNEL = (
    "an integral to infinity needs a kernel that decays exponentially: a sum of terms c*s**n*exp(-r*s) with r > 0, "
    "each times an expression in x(t - s)"
)


@dataclass(frozen=True)
class Memory:
    """A state that follows ``source`` at the ``rate``: its equation is symbol' = rate (source - symbol).

    Number ``power`` of the chain that begins with ``quantity``, read ``low`` ago and written as ``of`` in the states'
    symbols.
    """

    symbol: sympy.Symbol
    source: sympy.Expr
    rate: sympy.Expr
    quantity: sympy.Expr
    of: sympy.Expr
    low: sympy.Expr
    power: int

    @property
    def equation(self) -> sympy.Expr:
        """The state's derivative."""
        return self.rate * (self.source - self.symbol)

    def at_start(self, states: Sequence[str], history: Sequence[sympy.Expr]) -> sympy.Expr:
        """Return the state's value at t = 0 after a history of the ``states``.

        Raise :class:`ExpressionError` where there is no formula for it.
        """
        lag = sympy.Symbol("v", positive=True)
        then = {make_symbol(s): h.xreplace({TIME: -self.low - lag}) for s, h in zip(states, history, strict=True)}
        past = self.of.xreplace(then)
        if lag not in past.free_symbols:
            return past
        rate = sympy.Symbol("r", positive=True)
        weight = rate ** (self.power + 1) * lag**self.power / factorial(self.power) * sympy.exp(-rate * lag)
        value = sympy.integrate(sympy.expand(weight * past), (lag, 0, sympy.oo), conds="none")
        if value.has(sympy.Integral, sympy.oo, sympy.nan, sympy.zoo):
            raise ExpressionError("an integral over all of this history has no formula; write a simpler history")
        return sympy.simplify(value).xreplace({rate: self.rate})


@dataclass(frozen=True)
class Remembered:
    """An integral over all the past: its ``value`` in terms of states, and those of them that are new."""

    value: sympy.Expr
    memories: tuple[Memory, ...]


def make_memory(
    integrand: sympy.Expr,
    low: sympy.Expr,
    past: Mapping[str, sympy.Expr],
    known: Sequence[Memory],
    numbers: Mapping[sympy.Symbol, float],
    names: Sequence[str],
) -> Remembered:
    """Return an integral from the lag ``low`` to infinity in terms of states.

    Parameters
    ----------
    integrand
        An expression in t, the lag, and the states' symbols, their values at that lag.
    past
        The symbols of the states' values ``low`` ago.
    known
        The memories that there are already; one that does is used again.
    numbers, names
        The parameters' values, and the names of the states.

    Raises
    ------
    ExpressionError
        If the kernel does not decay exponentially.
    """
    lag = sympy.Symbol("v", positive=True)
    shifted = sympy.expand(integrand.xreplace({TIME: low + lag}), power_exp=True, mul=True)
    symbols = {make_symbol(s) for s in past}
    value, memories = sympy.S.Zero, list(known)
    grouped: dict[tuple[sympy.Expr, int, sympy.Expr], sympy.Expr] = {}
    for term in sympy.Add.make_args(shifted):
        kernel, of = sympy.powsimp(term).as_independent(*symbols, as_Add=False)
        if lag in of.free_symbols:
            raise ExpressionError(f"{KERNEL}; this one mixes s with the states")
        coefficient, power, rate = _split_kernel(kernel, lag)
        key = (rate, power, of)
        grouped[key] = grouped.get(key, sympy.S.Zero) + coefficient
    for (rate, power, of), coefficient in grouped.items():
        if evaluate(rate, numbers) <= 0:
            raise ExpressionError(f"{KERNEL}; here r is {evaluate(rate, numbers):g} at the given parameters")
        # What no state enters is what it always was: no memory is needed.
        held = _find_chain(of, low, rate, power, past, memories, names).symbol if of.free_symbols & symbols else of
        value += coefficient * factorial(power) / rate ** (power + 1) * held
    return Remembered(value, tuple(memories[len(known) :]))


def _split_kernel(kernel: sympy.Expr, lag: sympy.Symbol) -> tuple[sympy.Expr, int, sympy.Expr]:
    """Return c, n and r of the kernel c v^n exp(-r v)."""
    coefficient, power, rate = sympy.S.One, 0, sympy.S.Zero
    for factor in sympy.Mul.make_args(kernel):
        if lag not in factor.free_symbols:
            coefficient *= factor
        elif factor == lag:
            power += 1
        elif factor.is_Pow and factor.base == lag and factor.exp.is_Integer and 0 < factor.exp <= MAX_POWER:
            power += int(factor.exp)
        elif isinstance(factor, sympy.exp) and sympy.diff(factor.args[0], lag, 2) == 0:
            slope = sympy.expand(factor.args[0]).coeff(lag)
            rate -= slope
            coefficient *= sympy.exp(sympy.expand(factor.args[0] - slope * lag))
        else:
            raise ExpressionError(KERNEL)
    return coefficient, power, sympy.factor_terms(rate)


def _find_chain(
    of: sympy.Expr,
    low: sympy.Expr,
    rate: sympy.Expr,
    power: int,
    past: Mapping[str, sympy.Expr],
    memories: list[Memory],
    names: Sequence[str],
) -> Memory:
    """Return the last memory of a chain; those that are missing are added."""
    quantity = of.xreplace({make_symbol(s): symbol for s, symbol in past.items()})
    source, last = quantity, None
    for k in range(power + 1):
        same = (m for m in memories if (m.quantity, m.rate, m.power) == (quantity, rate, k))
        last = next(same, None)
        if last is None:
            symbol = make_symbol(_make_name({*names, *(m.symbol.name for m in memories)}))
            last = Memory(symbol, source, rate, quantity, of, low, k)
            memories.append(last)
        source = last.symbol
    assert last is not None
    return last


def _make_name(taken: set[str]) -> str:
    number = 1
    while f"memory_{number}" in taken:
        number += 1
    return f"memory_{number}"
