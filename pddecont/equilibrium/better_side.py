"""On which side of a curve of special equilibria, in the plane of two parameters, there is more to expect.

That is where, beside the curve,

    Hopf        fewer roots are unstable: against the gradient of Re lambda, lambda the root i omega
    fold        equilibria exist: A y^2 + g . dp = 0 has solutions y, with A = p . G_yy(v, v) and g = p . G_p of the
                null vectors v and p
    boundary    the equilibrium lies in its mode: along the gradient of the event function, turned into the mode

Gradients are along the equilibria y(p), which move by dy = -G_y^-1 G_p dp.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.equilibrium.critical import BoundaryCondition, CriticalEvaluation, FoldCondition
from pddecont.equilibrium.equations import Equilibrium, EquilibriumEvaluation
from pddecont.equilibrium.hopf_condition import HopfCondition, find_frequency
from pddecont.equilibrium.normal_forms import Forms, find_root_speed
from pddecont.equilibrium.sides import list_sides
from pddecont.errors import ConvergenceError

Array = NDArray[np.float64]
UNKNOWN = np.full(2, np.nan)
# Length of the steps over which matrices are differentiated, in sizes of the unknowns and widths of the ranges.
DIFFERENCE = 1e-5
# A matrix of a larger condition number is singular: the equilibrium is a fold, and moves infinitely fast.
SINGULAR = 1e12


def find_better_side(at: CriticalEvaluation) -> Array:
    """Return the direction to that side from a point of a curve, shape (2,), of length one in units of the ranges.

    It is NaN where the two sides do not differ to the first order, as at a cusp or where the frequency is zero.
    """
    critical, widths = at.system.critical, np.array(at.system.inner.widths)
    try:
        if isinstance(critical, HopfCondition):
            gradient = -_find_growth(at)
        elif isinstance(critical, FoldCondition):
            gradient = _find_existence(at)
        elif isinstance(critical, BoundaryCondition):
            gradient = _find_admission(at, critical.event)
        else:
            return UNKNOWN
    except (ConvergenceError, np.linalg.LinAlgError):
        return UNKNOWN
    scaled = gradient * widths
    length = float(np.linalg.norm(scaled))
    return np.asarray(scaled / length * widths) if 0.0 < length < np.inf else UNKNOWN


def _find_growth(at: CriticalEvaluation) -> Array:
    """Return the derivatives of Re lambda in the two parameters, shape (2,)."""
    moves, speeds = _find_moves(at.inner), []
    if not np.all(np.isfinite(moves)):
        return UNKNOWN
    root = Forms(at.equilibrium).find_critical(1j * find_frequency(at.own))
    for move, width in zip(moves.T, at.system.inner.widths, strict=True):
        before, after = (_shift(at.inner, sign * DIFFERENCE * width * move) for sign in (-1.0, 1.0))
        speeds.append(find_root_speed(root, before, after, 2.0 * DIFFERENCE * width).real)
    return np.array(speeds)


def _find_existence(at: CriticalEvaluation) -> Array:
    """Return -A g: a direction in which the equation of the fold has solutions, shape (2,)."""
    inner, v = at.inner, at.own
    jacobian = _dense(inner)
    left = np.linalg.svd(jacobian[:, : len(v)])[0][:, -1]
    step = DIFFERENCE / float(np.max(np.abs(v) / at.system.scaling.scale[: len(v)]))
    move = step * np.append(v, np.zeros(2))
    ends = [_dense(EquilibriumEvaluation(inner.problem, inner.x + sign * move)) for sign in (-1.0, 1.0)]
    curvature = float(left @ ((ends[1] - ends[0])[:, : len(v)] @ v))
    return np.asarray(-np.sign(curvature) * (left @ jacobian[:, -2:]))


def _find_admission(at: CriticalEvaluation, event: str) -> Array:
    """Return the derivatives in the two parameters of how far the equilibrium lies within its mode, shape (2,)."""
    motion, equilibrium = at.inner.problem.motion, at.equilibrium
    sign = next((side.sign for side in list_sides(motion.numeric.model, motion.mode) if side.event == event), np.nan)
    _, in_x, in_p = motion.measure_event(event, equilibrium.states, equilibrium.parameters, at.inner.problem.free)
    return np.asarray(-sign * (in_x @ _find_moves(at.inner)[: len(in_x)] + in_p))


def _find_moves(inner: EquilibriumEvaluation) -> Array:
    """Return how all unknowns move with each of the two parameters, shape (n_unknowns, 2); NaN at a fold."""
    jacobian = _dense(inner)
    if not np.linalg.cond(jacobian[:, :-2]) < SINGULAR:
        return np.full((jacobian.shape[1], 2), np.nan)
    return np.vstack([-np.linalg.solve(jacobian[:, :-2], jacobian[:, -2:]), np.eye(2)])


def _shift(inner: EquilibriumEvaluation, move: Array) -> Equilibrium:
    """Return the equilibrium whose unknowns are so far from those of another, to the first order."""
    return EquilibriumEvaluation(inner.problem, inner.x + move).equilibrium


def _dense(inner: EquilibriumEvaluation) -> Array:
    matrix: Any = inner.jacobian()
    return np.asarray(matrix if isinstance(matrix, np.ndarray) else matrix.toarray())
