"""Special points along a branch of equilibria in one parameter: LP, HB, BP, BE.

Fold (LP): the branch turns in the parameter. Branch point (BP): the determinant of the Jacobian bordered by the tangent
is zero. Hopf (HB): a pair of roots crosses the imaginary axis. Boundary equilibrium (BE): the equilibrium lies on the
surface of an event that ends its mode.

Reference: Kuznetsov, Elements of Applied Bifurcation Theory (2004), sections 10.2 and 10.3.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp

from pddecont.continuation import (
    CountFunction,
    Counts,
    CurvePoint,
    End,
    TestFunction,
    TestFunctions,
    add_row,
    factor,
    find_log_determinant,
    scale_matrix,
)
from pddecont.equilibrium.characteristic import DENSE
from pddecont.equilibrium.crossings import count_unstable, hides_crossings
from pddecont.equilibrium.equations import EquilibriumEvaluation
from pddecont.equilibrium.sides import Side, list_sides
from pddecont.reasons import make_reason

FOLD, HOPF, BRANCH, BOUNDARY = "LP", "HB", "BP", "BE"
NAMES = {FOLD: "fold", HOPF: "Hopf", BRANCH: "branch point", BOUNDARY: "boundary equilibrium"}
# A boundary, as the reason of a special point.
BOUNDARY_CODE = "boundary_equilibrium"
Point = CurvePoint[EquilibriumEvaluation]


def make_tests(
    at: EquilibriumEvaluation, detect: Collection[str] | None = None
) -> TestFunctions[EquilibriumEvaluation]:
    """Return what is looked for along the branch of equilibria of one mode: kinds in ``detect`` (None: all)."""
    motion = at.problem.motion
    tests: list[TestFunction[EquilibriumEvaluation]] = [
        TestFunction(FOLD, lambda point: float(point.tangent[-1])),
        TestFunction(BRANCH, _measure_branching, crosses=True),
        *(_test_side(side) for side in list_sides(motion.numeric.model, motion.mode)),
    ]
    counts = CountFunction(count_unstable, _explain, hides_crossings)
    wanted = [test for test in tests if detect is None or test.kind in detect]
    return TestFunctions(wanted, counts if detect is None or HOPF in detect else None)


def _test_side(side: Side) -> TestFunction[EquilibriumEvaluation]:
    reason = make_reason(BOUNDARY_CODE, event=side.event, segment=side.segments[0])
    return TestFunction(BOUNDARY, lambda point: side.measure(point.at.equilibrium), End.SPECIAL, reason)


def _measure_branching(point: Point) -> float:
    """Return a function with the sign of the determinant of the Jacobian bordered by the tangent, smooth at its zeros.

    Its modulus is that of the last unknown of the bordered matrix, bordered once more by vectors that nothing depends
    on. Where that larger matrix is singular the modulus has a pole, and the sign does not change.
    """
    scaling, n = point.system.scaling, len(point.x)
    columns = scale_matrix(point.at.jacobian(), np.ones(n - 1), scaling.size)
    once = sp.csc_matrix(add_row(columns, point.tangent / scaling.size))
    border = np.random.default_rng(0).normal(size=(2, n))
    twice = sp.bmat([[once, sp.csc_matrix(border[0][:, None])], [sp.csc_matrix(border[1][None]), None]], format="csc")
    if n <= DENSE:
        once, twice = once.toarray(), twice.toarray()
    unit = np.zeros(n + 1)
    unit[-1] = 1.0
    modulus = abs(float(factor(twice)(unit)[-1]))
    return float(np.copysign(modulus, np.cos(find_log_determinant(once).imag)))


@dataclass(frozen=True)
class PairTest:
    """The real part of the pair of roots with so many pairs to its right."""

    number: int

    def __call__(self, point: CurvePoint[Any]) -> float:
        """Return it; NaN where there are not so many pairs."""
        values = point.at.roots.values
        pairs = values[values.imag > 0.0].real
        return float(pairs[self.number]) if self.number < len(pairs) else float("nan")


def _explain(before: Counts, after: Counts) -> Sequence[TestFunction[EquilibriumEvaluation]] | None:
    """Return the test of a pair that crosses; nothing where a real root does, or two meet on the real axis."""
    real, pairs = after[0] - before[0], after[1] - before[1]
    if real == 0 and abs(pairs) == 1:
        return [TestFunction(HOPF, PairTest(min(before[1], after[1])))]
    if (abs(real) <= 1 and pairs == 0) or (real, pairs) in ((2, -1), (-2, 1)):
        return []
    return None
