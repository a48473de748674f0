"""Branch point (BP): two branches of orbits cross; a multiplier passes +1 and the branch does not turn.

The directions of both branches span the null space of the Jacobian, which is two-dimensional there.

Reference: Allgower, Georg, Introduction to Numerical Continuation Methods (2003), chapter 8.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.bifurcation.branch_start import BranchStart, StartError
from pddecont.bifurcation.fold import remove_fold_multiplier
from pddecont.bifurcation.kinds import SpecialPointKind
from pddecont.bifurcation.settings import BranchSettings
from pddecont.continuation import CurvePoint, equilibrate, find_null_vectors
from pddecont.orbit import Orbit, OrbitEvaluation
from pddecont.stability import Multipliers

Array = NDArray[np.float64]
LABEL = "BP"
# Length of the step over which second derivatives are taken; its error balances that of rounding.
DIFFERENCE = 1e-3


def measure_distance(m: Multipliers) -> float:
    """Return the distance to +1 of the real multiplier nearest to it, with the sign of the parity of those beyond."""
    real = m.nontrivial[m.nontrivial.imag == 0.0].real
    if not len(real):
        return float("nan")
    return float((-1.0) ** np.sum(real > 1.0) * np.min(np.abs(real - 1.0)))


def find_other_branch(at: OrbitEvaluation, tangent: Array) -> Array:
    """Return the unit direction of the branch that crosses the one with ``tangent``.

    With t the tangent, v the rest of the null space, w the left null vector and B the equations' second derivative,
    both branches have directions p t + q v with (w B t t) p^2 + 2 (w B t v) p q + (w B v v) q^2 = 0. The one farther
    from t is the other's, however roughly t is known. Reference: Keller, Lectures on Numerical Methods in Bifurcation
    Problems (1987), ch. 5.
    """
    scaling = at.system.scaling
    scaled = equilibrate(at.jacobian(), scaling.size)
    left, right = find_null_vectors(scaled.matrix)
    null = right * scaling.size
    along = np.array([scaling.dot(v, tangent) for v in null])
    rest = scaling.normalise(null.T @ np.array([-along[1], along[0]]))
    w = left * scaled.rows

    def second_derivative(direction: Array) -> float:
        ends = sum(at.system.at(at.x + sign * DIFFERENCE * direction).residual for sign in (-1.0, 1.0))
        return float(w @ (ends - 2.0 * at.residual)) / DIFFERENCE**2

    t = scaling.normalise(tangent)
    of_t, of_rest = second_derivative(t), second_derivative(rest)
    mixed = 0.5 * (second_derivative(t + rest) - of_t - of_rest)
    # The root of larger size, from the form without cancellation.
    root = mixed + np.copysign(np.sqrt(max(mixed**2 - of_t * of_rest, 0.0)), mixed)
    return scaling.normalise(root * rest - of_rest * t)


def _switch(orbit: Orbit, tangent: Array, settings: BranchSettings) -> BranchStart:
    system, orbit = settings.make_system(orbit)
    if len(tangent) != len(orbit.x):
        raise StartError(
            "a branch is switched at a BP point on the mesh and with the free parameter of the step that found it"
        )
    at = system.at(orbit.x)
    direction = find_other_branch(at, tangent)
    # Towards larger values of the parameter, as branches begin.
    forward = -1.0 if direction[orbit.problem.unknowns.free.start] < 0.0 else 1.0
    return BranchStart(CurvePoint(system, at, None, forward * direction))


BRANCH_POINT = SpecialPointKind(
    LABEL,
    "branch point",
    on_branches=True,
    needs_multipliers=True,
    remove_critical=remove_fold_multiplier,
    switch=_switch,
)
