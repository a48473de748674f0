"""Where a curve of special equilibria in two parameters starts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.equilibrium.critical import BoundaryCondition, Critical, CriticalSystem, FoldCondition, make_dense
from pddecont.equilibrium.equations import Equilibrium, EquilibriumEvaluation, EquilibriumSystem
from pddecont.equilibrium.hopf_condition import start_at_double_zero, start_at_pair
from pddecont.equilibrium.stability import find_own_roots
from pddecont.errors import ConvergenceError

Array = NDArray[np.float64]
# How far from a double root zero the first Hopf point is looked for, in scaled unknowns.
OFF = 0.02


def make_critical_start(
    inner: EquilibriumSystem, label: str, event: str, at: Equilibrium, frequency: float | None = None
) -> tuple[CriticalSystem, Array]:
    """Return the system of a curve of special points and its unknowns at the point ``at``, or next to it.

    ``event`` is that of a boundary equilibrium. Of several pairs of roots on the imaginary axis the one nearest to
    ``frequency`` is meant; zero: a curve of Hopf points begins there, at a double root zero.
    """
    inside = inner.problem.join(at)
    evaluation = EquilibriumEvaluation(inner.problem, inside)
    critical: Critical = BoundaryCondition(event)
    own = np.zeros(0)
    if label == "LP":
        own = np.asarray(np.linalg.svd(make_dense(evaluation.jacobian())[:, : len(inside) - 2])[2][-1])
        critical = FoldCondition(own)
    elif label == "HB":
        critical, own = (
            start_at_double_zero(evaluation) if frequency == 0.0 else start_at_pair(*_find_pair(at, frequency))
        )
    start = np.concatenate([inside[:-2], own, inside[-2:]])
    system = CriticalSystem(inner, critical, start)
    return system, start + OFF * _leave_double_zero(system, start) if frequency == 0.0 else start


def _find_pair(at: Equilibrium, frequency: float | None) -> tuple[NDArray[np.complex128], float]:
    """Return the vector and the frequency of the pair nearest to the imaginary axis, or to ``frequency`` on it."""
    roots = find_own_roots(at.motion, at.states, at.parameters)
    pairs = np.flatnonzero(roots.values.imag > 0.0)
    if not len(pairs):
        raise ConvergenceError("there is no pair of complex characteristic roots here")
    values = roots.values[pairs]
    away = np.abs(values.real if frequency is None else values - 1j * frequency)
    nearest = int(pairs[np.argmin(away)])
    return roots.vectors[nearest], float(roots.values[nearest].imag)


def _leave_double_zero(system: CriticalSystem, start: Array) -> Array:
    """Return the direction in which the square of the frequency grows."""
    scale = system.scaling.scale
    null = np.linalg.svd(system.at(start).jacobian() * scale)[2][-1] * scale
    return np.asarray(null * np.sign(null[-3]) / system.scaling.length(null))
