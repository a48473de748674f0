"""Fold (LP): a branch turns back in its parameter; a multiplier is +1.

Along a branch the test function is the free parameter's component of the tangent, which is smooth and needs no
multipliers. On a curve in two parameters the fold is where the Jacobian J of the orbit's equations at fixed parameters
is singular: with b and c near its null vectors,

    [J   b] [v]   [0]
    [c^T 0] [g] = [1]

is regular, and g = 0 exactly where J is singular. v is then the null vector, and a cusp is where g does not change
along it.

Reference: Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria (2000), sections 3.2 and 4.1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.bifurcation.extended_system import DefiningFunction, ExtendedEvaluation
from pddecont.bifurcation.kinds import SpecialPointKind
from pddecont.bifurcation.settings import BranchSettings
from pddecont.continuation import (
    CurvePoint,
    Matrix,
    TestFunction,
    add_border,
    equilibrate,
    factor,
    find_null_vectors,
    scale_matrix,
)
from pddecont.orbit import OrbitEvaluation
from pddecont.reasons import Reason
from pddecont.stability import Multipliers, remove_known

Array = NDArray[np.float64]
FOLD_LABEL = LABEL = "LP"


def parameter_tangent(point: CurvePoint[OrbitEvaluation]) -> float:
    """Return the rate at which the (first) free parameter changes along the branch."""
    return float(point.tangent[point.at.orbit.problem.unknowns.free][0])


def _fixed_jacobian(at: OrbitEvaluation) -> Matrix:
    """Return the Jacobian in the orbit's own unknowns, without the free parameters."""
    return at.jacobian()[:, : at.orbit.problem.unknowns.free.start]


def _last_unit(n: int) -> Array:
    unit = np.zeros(n)
    unit[-1] = 1.0
    return unit


@dataclass(frozen=True, eq=False)
class FoldFunction:
    """The function g, with the vectors b and c that border the Jacobian and the rows' scales."""

    b: Array
    c: Array
    rows: Array
    kind: str = LABEL

    def evaluate(self, at: OrbitEvaluation) -> float:
        """Return g at an orbit."""
        return self.find_null(at)[1]

    def find_null(self, at: OrbitEvaluation) -> tuple[Array, float]:
        """Return the vector v (in scaled unknowns) and g."""
        n = at.orbit.problem.unknowns.free.start
        matrix = scale_matrix(_fixed_jacobian(at), self.rows, at.system.scaling.scale[:n])
        solved = factor(add_border(matrix, self.b, self.c[None]))(_last_unit(n + 1))
        return solved[:-1], float(solved[-1])

    def update_at(self, at: OrbitEvaluation) -> FoldFunction:
        """Return the same function with vectors fit for an orbit, of the same signs."""
        new = define_fold(at)
        same_c = len(self.c) != len(new.c) or self.c @ new.c >= 0.0
        same_b = len(self.b) != len(new.b) or self.b @ new.b >= 0.0
        return FoldFunction(new.b if same_b else -new.b, new.c if same_c else -new.c, new.rows)


def define_fold(at: OrbitEvaluation) -> FoldFunction:
    """Return the function with b and c the left and right null vectors at an orbit."""
    n = at.orbit.problem.unknowns.free.start
    scaled = equilibrate(_fixed_jacobian(at), at.system.scaling.scale[:n])
    left, right = find_null_vectors(scaled.matrix)
    return FoldFunction(left, right[0], scaled.rows)


def cusp_function(point: CurvePoint[ExtendedEvaluation]) -> float:
    """Return how the fold function changes along the null vector: zero at a cusp.

    The vector's sign comes from orbits before; with the other one the value is the same to the last bit, but for its
    own sign, so that a branch which is resumed locates the same point.
    """
    at = point.at
    assert isinstance(at.system.defining, FoldFunction)
    null, _ = at.system.defining.find_null(at.inner)
    scaling = at.system.scaling
    direction = np.zeros(len(at.x))
    direction[: len(null)] = null * scaling.scale[: len(null)]
    along = scaling.normalise(direction)
    forth, back = at.rates_along(np.stack([along, -along]))
    return float(0.5 * (forth - back))


def _define(at: OrbitEvaluation, settings: BranchSettings, reason: Reason) -> DefiningFunction:
    return define_fold(at)


def remove_fold_multiplier(m: Multipliers) -> NDArray[np.complex128]:
    """Return the multipliers without the +1 of a fold or a branch point."""
    return remove_known(m.nontrivial, 1.0)


def _cusp_tests(at: ExtendedEvaluation, settings: BranchSettings) -> list[TestFunction[ExtendedEvaluation]]:
    return [TestFunction(CUSP.label, cusp_function)] if isinstance(at.system.defining, FoldFunction) else []


FOLD = SpecialPointKind(
    LABEL,
    "fold",
    on_branches=True,
    define=_define,
    crossings=("R1", "FF", "FT"),
    remove_critical=remove_fold_multiplier,
)
CUSP = SpecialPointKind("CP", "cusp", on_curves=True, curve_tests=_cusp_tests)
