"""Characteristic roots that special equilibria have on the imaginary axis by their nature.

On which side of it rounding puts them says nothing of stability: counts of unstable roots leave them out.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from pddecont.equilibrium.roots import Roots


def find_zero(roots: Roots) -> Sequence[int]:
    """Return the number of the root nearest zero; of a double root zero it may be one of a pair."""
    return [int(np.argmin(np.abs(roots.values)))] if len(roots.values) else []


def find_pair(roots: Roots, root: complex | None = None) -> Sequence[int]:
    """Return the numbers of the two nearest to a ``root`` and its negative, or of the pair next to the axis (None)."""
    values = roots.values
    if root is None:
        upper = np.where(values.imag > 0.0, np.abs(values.real), np.inf)
        if not np.any(np.isfinite(upper)):
            return []
        root = 1j * float(values[int(np.argmin(upper))].imag)
    if len(values) < 2:
        return []
    first = int(np.argmin(np.abs(values - root)))
    away = np.abs(values + root)
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


def has_critical(curve: str, kind: str) -> bool:
    """Return whether points of a ``kind`` have roots on the axis that others of their ``curve`` do not."""
    return (curve, kind) in OF_POINTS
