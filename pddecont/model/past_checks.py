"""Whether what a model reads of the past makes sense: no future at the start, rates that fade."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import sympy

from pddecont.model.evaluation import evaluate
from pddecont.model.expression import TIME
from pddecont.model.past_reads import PastReads

Numbers = Mapping[sympy.Symbol, float]


def list_negative_delays(
    past: PastReads, states: Sequence[sympy.Symbol], history: Sequence[sympy.Expr]
) -> Iterator[tuple[sympy.Expr, str]]:
    """Yield the delays that vary and are negative, or no numbers, at the start, each with a message."""
    known = {**past.numbers, TIME: 0.0}
    known |= {x: evaluate(h, known) for x, h in zip(states, history, strict=True)}
    known |= past.evaluate_at_start(known, history)
    for delay in filter(past.varies, past.delays):
        value = evaluate(delay, known)
        if math.isnan(value) and any(math.isnan(known.get(s, 0.0)) for s in delay.free_symbols):
            continue
        if not value >= 0.0:
            shown = f"{value:g}" if math.isfinite(value) else "no finite number"
            yield (
                delay,
                f"the delay {delay} is {shown} at the start, t = 0; a value in the future cannot be read: change "
                "'initial' or the delay",
            )


def measure_rates(field: Sequence[sympy.Expr], past: PastReads) -> float:
    """Return by how much delayed rates can make rates grow, the largest over all their phases; NaN if not constant.

    It is the spectral radius of the sum of the moduli of their coefficients. From one on no motion is stable: there are
    perturbations of any frequency that do not decay.

    Reference: Hale, Verduyn Lunel, Introduction to Functional Differential Equations (1993), section 9.6.
    """
    names = list(past.states)
    total = np.zeros((len(names), len(names)))
    for symbol, (state, _, derivative) in past.list_delayed():
        for row, f in enumerate(field[: len(names)] if derivative else ()):
            slope = f.diff(symbol)
            if not slope.free_symbols <= past.numbers.keys():
                return math.nan
            total[row, names.index(state)] += abs(evaluate(slope, past.numbers))
    return float(np.max(np.abs(np.linalg.eigvals(total)), initial=0.0))
