"""What a model reads of the past at rest, as expressions in its states: integrals in closed form."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.equilibrium.rest_reads import RestReads
from pddecont.errors import ConvergenceError
from pddecont.model import TIME, Integral

Array = NDArray[np.float64]
# What a closed form may hold: functions of which intervals have bounds.
ELEMENTARY = (sympy.exp, sympy.log, sympy.sin, sympy.cos, sympy.tan, sympy.sinh, sympy.cosh, sympy.tanh, sympy.atan)
# A closed form agrees with a quadrature to this part of their size; a wrong one does not.
AGREES = 1e-9
# Where in a box that is tried: parts of the way from its lowest to its highest states.
TRIED = (0.0, 0.37, 0.71, 1.0)


@dataclass(frozen=True, eq=False)
class Box:
    """States from ``low`` to ``high`` (n_states,) at parameters ``p``."""

    p: Array
    low: Array
    high: Array


def find_rest_expressions(reads: RestReads, box: Box) -> dict[sympy.Symbol, sympy.Expr]:
    """Return what each symbol of a read stands for at rest; in integrals the parameters have their values.

    Raises
    ------
    ConvergenceError
        If an integral has no closed form.
    """
    model = reads.numeric.model
    found: dict[sympy.Symbol, sympy.Expr] = {
        symbol: sympy.S.Zero if value.derivative else model.state_symbols[value.state]
        for symbol, value in zip(model.delayed_symbols, model.delayed, strict=True)
    }
    exact = {s: sympy.Rational(v) for s, v in zip(model.parameter_symbols, box.p.tolist(), strict=True)}
    for number, symbol in enumerate(model.integral_symbols):
        integral = model.integrals[number]
        limits = (limit.xreplace(found).xreplace(exact) for limit in (integral.low, integral.high))
        closed = _integrate(Integral(integral.integrand.xreplace(exact), *limits))
        if closed is None or not _agrees(closed, reads, number, box):
            raise ConvergenceError(
                f"a search proves that it found all equilibria from closed forms, and none is known of {symbol}; look "
                "for equilibria from guesses with 'from'"
            )
        found[symbol] = closed
    return found


def _integrate(integral: Integral) -> sympy.Expr | None:
    """Return an integral between its limits, in the states that its integrand holds; None if that is not found."""
    lag, total = sympy.Symbol("v", real=True), sympy.S.Zero
    for term in sympy.Add.make_args(sympy.expand(integral.integrand.xreplace({TIME: lag}))):
        factor, kernel = term.as_independent(lag, as_Add=False)
        whole = sympy.integrate(kernel, lag, manual=True)
        if whole.has(sympy.Integral) or not all(isinstance(f, ELEMENTARY) for f in whole.atoms(sympy.Function)):
            return None
        total += factor * (whole.xreplace({lag: integral.high}) - whole.xreplace({lag: integral.low}))
    return sympy.sympify(total)


def _agrees(closed: sympy.Expr, reads: RestReads, number: int, box: Box) -> bool:
    """Return whether a closed form has the values of a quadrature, in several places of a box."""
    model = reads.numeric.model
    for share in TRIED:
        x = box.low + share * (box.high - box.low)
        values: Mapping[sympy.Symbol, float] = dict(zip(model.state_symbols, x.tolist(), strict=True))
        own = float(reads.find_values(x, box.p)[len(model.delayed) + number])
        try:
            exact = float(closed.evalf(30, subs=values))
        except TypeError:
            return False
        if not abs(exact - own) <= AGREES * max(1.0, abs(own)):
            return False
    return True
