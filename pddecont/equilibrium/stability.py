"""The characteristic roots that tell the stability of an equilibrium."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pddecont.equilibrium.constant_motion import ConstantMotion
from pddecont.equilibrium.roots import N_ROOTS, Roots, find_roots

Array = NDArray[np.float64]


def find_own_roots(motion: ConstantMotion, states: Array, parameters: Array, n_roots: int = N_ROOTS) -> Roots:
    """Return the leading characteristic roots of an equilibrium in its mode.

    A mode that slides along a surface has the root zero for it, which says nothing: each is left out once. Where the
    equations would read the future none are known.
    """
    n_zero = len(motion.surfaces)
    if motion.find_negative_lag(states, parameters) is not None:
        return Roots(np.zeros(0, dtype=complex), np.zeros(0), np.zeros((0, len(states)), dtype=complex), None)
    roots = find_roots(motion.linearise(states, parameters), n_roots + n_zero)
    if not n_zero:
        return roots
    kept = np.sort(np.argsort(np.abs(roots.values))[n_zero:])
    return replace(roots, values=roots.values[kept], residuals=roots.residuals[kept], vectors=roots.vectors[kept])
