"""Delays along a branch: it ends where one is zero, since no motion reads its future."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation.margin import Margins

Array = NDArray[np.float64]


def _delays(curve: Any, x: Array) -> tuple[Array, Array]:
    """Return the delays (n_delays,) and their derivatives (n_delays, n_unknowns)."""
    problem = curve.problem
    p = problem.all_parameters(x)
    slopes = np.zeros((len(problem.numeric.model.delays), len(x)))
    slopes[:, problem.layout.free] = problem.numeric.delays.derivatives(p, problem.free_index)
    return problem.numeric.delays.value(p), slopes


def _in_words(curve: Any, x: Array, k: int) -> str:
    problem = curve.problem
    delay = problem.numeric.model.delays[k]
    names = {s.name for s in delay.free_symbols}
    values = zip(problem.free, x[problem.layout.free], strict=True)
    here = ", ".join(f"{name} = {0.0 if str(delay) == name else value:.8g}" for name, value in values if name in names)
    return f"delay '{delay}' becomes negative beyond {here}"


DELAYS = Margins(_delays, _in_words)
