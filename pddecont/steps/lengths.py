"""Whether delays and the forcing period are lengths of time at some parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping

import sympy

from pddecont.model.expression import ExpressionError
from pddecont.model.system import Model


def lengths(model: Model) -> list[tuple[str, sympy.Expr, bool]]:
    """Return what is a length of time: its name in words, its expression in the parameters, whether it must not be zero."""
    found = [(f"the delay {d}", d, False) for d in model.delays]
    found += [(f"the delay of event {e.name}", e.delay, False) for e in model.events.values() if e.delay is not None]
    return found + ([("the forcing period", model.period, True)] if model.period is not None else [])


def wrong_lengths(model: Model, values: Mapping[str, float]) -> list[tuple[str, set[str]]]:
    """Return what is no length of time at parameters of these ``values``, in words, each with the parameters that it depends on."""
    wrong = []
    for what, expr, positive in lengths(model):
        try:
            value = model.evaluate(expr, values)
        except ExpressionError:
            value = math.nan
        if not 0 <= value < math.inf or (positive and value == 0):
            names = sorted(s.name for s in expr.free_symbols if s.name in values)
            where = f" at {', '.join(f'{name} = {values[name]:g}' for name in names)}" if names else ""
            shown = f"{value:g}" if math.isfinite(value) else "not a finite number"
            wrong.append((f"{what} is {shown}{where}; expected a {'positive' if positive else 'non-negative'} number", set(names)))
    return wrong
