"""Characteristic roots that special equilibria have on the imaginary axis by their nature.

On which side of it rounding puts them says nothing of stability: counts of unstable roots leave them out.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from pddecont.equilibrium.roots import Roots

# Roots farther than this from the axis, relative to what unstable ones can be, do not lie on it. A double root zero is
# known to the square root of rounding.
NEAR_AXIS = 1e-5


def find_zero(roots: Roots) -> Sequence[int]:
    """Return the number of the root nearest zero; of a double root zero it may be one of a pair."""
    return [int(np.argmin(np.abs(roots.values)))] if len(roots.values) else []


def find_pair(roots: Roots, frequency: float | None = None) -> Sequence[int]:
    """Return the numbers of the pair nearest to a frequency on the imaginary axis, or next to the axis (None)."""
    values = roots.values
    if frequency is None:
        upper = np.where(values.imag > 0.0, np.abs(values.real), np.inf)
        if not np.any(np.isfinite(upper)):
            return []
        frequency = float(values[int(np.argmin(upper))].imag)
    if len(values) < 2:
        return []
    first = int(np.argmin(np.abs(values - 1j * frequency)))
    away = np.abs(values + 1j * frequency)
    away[first] = np.inf
    return [first, int(np.argmin(away))]


# By the label of the curve (empty: a branch in one parameter) and that of the point: of what curves have on the axis
# all along nothing stands here.
OF_POINTS: dict[tuple[str, str], Callable[[Roots], Sequence[int]]] = {
    ("", "LP"): find_zero,
    ("", "BP"): find_zero,
    ("", "HB"): find_pair,
    ("LP", "BT"): find_zero,
    ("LP", "ZH"): find_pair,
    ("HB", "ZH"): find_zero,
    ("HB", "HH"): find_pair,
}


def leave_out(roots: Roots, numbers: Sequence[int]) -> Roots:
    """Return the roots without those of some numbers."""
    kept = [k for k in range(len(roots.values)) if k not in numbers]
    return replace(roots, values=roots.values[kept], residuals=roots.residuals[kept], vectors=roots.vectors[kept])


def remove_critical(roots: Roots, curve: str, kind: str) -> Roots:
    """Return the roots without those that a point of a ``kind`` has on the axis; ``curve`` is what it was found on."""
    find = OF_POINTS.get((curve, kind))
    return roots if find is None else leave_out(roots, find(roots))


def has_critical(roots: Roots, curve: str, kind: str, bound: float) -> bool:
    """Return whether a point has the roots on the axis that make it one of a ``kind``; no for kinds without any.

    ``bound`` is a number that no unstable root exceeds in modulus.
    """
    find = OF_POINTS.get((curve, kind))
    numbers = [] if find is None else list(find(roots))
    return bool(numbers) and bool(np.all(np.abs(roots.values[numbers].real) <= NEAR_AXIS * bound))
