"""One setting that a ``precision`` step tries, and what it found."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# Columns of a row that is no orbit's, and whose method is no delay's.
PLAIN: dict[str, Any] = {
    "tracked": True,
    "order": 0,
    "explicit": False,
    "degree": 0,
    "intervals": 0,
    "tolerance": np.nan,
    "n": 0,
}


@dataclass(frozen=True, eq=False)
class Finding:
    """What one setting found: quantities, states at the segments' ends (of orbits), the size of the computation."""

    values: Array
    ends: Array
    time: Array
    states: Array
    n_unknowns: int = 0
    n_intervals: int = 0
    n_iterations: int = 0
    n_steps: int = 0


@dataclass(frozen=True, eq=False)
class Case:
    """One row: the columns that say which setting it is, and what computes it."""

    columns: dict[str, Any]
    compute: Callable[[], Finding]
