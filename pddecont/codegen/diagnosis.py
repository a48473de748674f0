"""Which part of an expression has no finite value, where and why, in a sentence."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.codegen.numeric_model import NumericModel
from pddecont.model import TIME

Array = NDArray[np.float64]


def find_non_finite(
    numeric: NumericModel, named: Sequence[tuple[str, sympy.Expr]], t: Array, x: Array, xd: Array, p: Array
) -> str:
    """Return what first has no finite value among expressions along points in order of time; empty if all have.

    Parameters
    ----------
    named
        Expressions over the model with what they are called.
    t, x, xd, p
        Times (n_points,), states (n_states, n_points), delayed values (n_delayed, n_points) and parameters.
    """
    values = numeric.function([e for _, e in named]).value(t, x, xd, p)
    failing = np.argwhere(~np.isfinite(values.T))
    if not len(failing):
        return ""
    point, row = (int(i) for i in failing[0])
    name, expr = named[row]
    here = t[point : point + 1], x[:, point : point + 1], xd[:, point : point + 1], p
    model = numeric.model
    symbols = (TIME, *model.state_symbols, *model.read_symbols, *model.parameter_symbols)
    numbers = dict(zip(symbols, [float(here[0][0]), *here[1][:, 0], *here[2][:, 0], *p], strict=True))
    broken = [f"{s} = {v:g}" for s, v in numbers.items() if s in expr.free_symbols and not np.isfinite(v)]
    if broken:
        return f"{name} is asked for where {', '.join(broken)}"
    part, why = _find_innermost(numeric, expr, here)
    at = [f"{s} = {numbers[s]:.8g}" for s in symbols if s is TIME or s in part.free_symbols]
    return f"{part} {why} in {name}, at {', '.join(at)}"


def _find_innermost(
    numeric: NumericModel, expr: sympy.Expr, here: tuple[Array, Array, Array, Array]
) -> tuple[sympy.Expr, str]:
    """Return the first part of ``expr`` without a finite value whose own parts all have one, and why it has none."""

    def number(part: sympy.Expr) -> float:
        return float(numeric.function([part]).value(*here)[0, 0])

    for part in sympy.postorder_traversal(expr):
        if part.args and not np.isfinite(number(part)):
            return part, _explain(part, [number(a) for a in part.args])
    return expr, "has no finite value"


def _explain(part: sympy.Expr, values: Sequence[float]) -> str:
    """Return why an operation has no finite value, from those of its arguments."""
    if isinstance(part, sympy.Pow):
        base, power = values
        if base == 0.0 and power < 0.0:
            return "divides by zero"
        if base < 0.0 and power != round(power):
            return f"takes a root of a negative number ({base:.6g})"
    if isinstance(part, sympy.log) and values[0] <= 0.0:
        return f"takes the logarithm of {f'a negative number ({values[0]:.6g})' if values[0] < 0.0 else 'zero'}"
    if isinstance(part, sympy.asin | sympy.acos) and abs(values[0]) > 1.0:
        return f"is not defined at {values[0]!r}"
    return "overflows"
