"""Limits of axes: what is constant but for rounding is drawn as a constant."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pddecont.results import Step

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# What varies by less than this share of its size is constant: the tolerances of orbits are larger by far, rounding is
# smaller.
ROUNDING = 1e-9
# Nothing is taken to be smaller than this share of the largest state: all of it is rounding, then.
SMALL = 1e-5
# Half the height of an axis that shows a constant, as a share of the constant.
HALF_OF_CONSTANT = 0.05


def measure_size(steps: Sequence[Step], values: NDArray[Any]) -> float:
    """Return how large ``values`` (any shape) that belong to some steps are, to know what of them is rounding."""
    states = [step.orbits[name] for step in steps for name in ("states", "returns") if name in step.orbits]
    states += [step.points["states"] for step in steps if "states" in step.points]
    return max(_find_largest(values), SMALL * max(map(_find_largest, states), default=0.0))


def varies(values: NDArray[Any], size: float) -> bool:
    """Return whether ``values`` (n,) of a size vary beyond rounding."""
    finite = values[np.isfinite(values)]
    return len(finite) > 0 and float(np.ptp(finite)) > ROUNDING * size


def widen_limits(low: float, high: float, size: float) -> tuple[float, float]:
    """Return the limits of an axis for values from ``low`` to ``high``, far apart if these differ by rounding only."""
    if high - low > ROUNDING * size:
        return low, high
    middle, half = 0.5 * (low + high), HALF_OF_CONSTANT * (size or 1.0)
    return middle - half, middle + half


def widen_axis(axes: Axes, which: str, size: float) -> None:
    """Widen the limits of the axis ``which`` (x, y or z), whose values have a ``size``, if they show only rounding."""
    low, high = getattr(axes, f"get_{which}lim")()
    limits = widen_limits(low, high, size)
    if limits != (low, high):
        getattr(axes, f"set_{which}lim")(limits)


def widen_for_columns(axes: Axes, steps: Sequence[Step], shown: Mapping[str, Sequence[NDArray[Any]]]) -> None:
    """Widen the axes, by their letters, that show columns of points, any shape, if these differ by rounding only."""
    for which, columns in shown.items():
        widen_axis(axes, which, measure_size(steps, np.concatenate([np.ravel(values) for values in columns])))


def _find_largest(values: NDArray[Any]) -> float:
    return float(np.max(np.abs(values), initial=0.0, where=np.isfinite(values)))
