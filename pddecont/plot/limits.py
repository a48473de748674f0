"""Limits of axes: what is constant but for rounding is drawn as a constant."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.results.reader import Step

# What varies by less than this share of its size is constant.
ROUNDING = 1e-9
# Nothing is taken to be smaller than this share of the largest state: all of it is rounding, then.
SMALL = 1e-5


def size_of(steps: Sequence[Step], values: NDArray[Any]) -> float:
    """Return how large ``values`` that belong to some steps are, for telling what of them is rounding."""
    states = [step.orbits[name] for step in steps for name in ("states", "returns") if name in step.orbits]
    return max(_largest(values), SMALL * max(map(_largest, states), default=0.0))


def varies(values: NDArray[Any], size: float) -> bool:
    """Whether ``values`` of a size vary beyond rounding."""
    finite = values[np.isfinite(values)]
    return len(finite) > 0 and float(np.ptp(finite)) > ROUNDING * size


def widened(low: float, high: float, size: float) -> tuple[float, float]:
    """Return the limits of an axis for values from ``low`` to ``high``; far apart, where between these there is only rounding."""
    if high - low > ROUNDING * size:
        return low, high
    middle, half = 0.5 * (low + high), 0.05 * (size or 1.0)
    return middle - half, middle + half


def widen(axes: Any, which: str, size: float) -> None:
    """Widen the limits of the axis ``which`` (x, y or z), whose values have a ``size``, where only rounding shows between them."""
    low, high = getattr(axes, f"get_{which}lim")()
    limits = widened(low, high, size)
    if limits != (low, high):
        getattr(axes, f"set_{which}lim")(limits)


def _largest(values: NDArray[Any]) -> float:
    return float(np.max(np.abs(values), initial=0.0, where=np.isfinite(values)))
