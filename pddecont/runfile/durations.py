"""Whether delays and the forcing period are lengths of time at some parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping

import sympy

from pddecont.model import ExpressionError, Model


def list_durations(model: Model) -> list[tuple[str, sympy.Expr, bool]]:
    """Return all lengths of time: name in words, expression in the parameters, whether it must not be zero."""
    found = [(f"the delay {d}", d, False) for d in model.delays]
    found += [(f"the delay of event {e.name}", e.delay, False) for e in model.events.values() if e.delay is not None]
    return found + ([("the forcing period", model.period, True)] if model.period is not None else [])


def find_wrong_durations(model: Model, values: Mapping[str, float]) -> list[tuple[str, set[str]]]:
    """Return what is no length of time at some ``values`` of parameters, in words, with those that it depends on."""
    wrong = []
    for what, expr, positive in list_durations(model):
        try:
            value = model.evaluate(expr, values)
        except ExpressionError:
            value = math.nan
        if not 0 <= value < math.inf or (positive and value == 0):
            names = sorted(s.name for s in expr.free_symbols if s.name in values)
            where = f" at {', '.join(f'{name} = {values[name]:g}' for name in names)}" if names else ""
            shown = f"{value:g}" if math.isfinite(value) else "not a finite number"
            expected = f"expected a {'positive' if positive else 'non-negative'} number"
            wrong.append((f"{what} is {shown}{where}; {expected}", set(names)))
    return wrong
