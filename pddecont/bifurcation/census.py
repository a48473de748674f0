"""What changes where along a branch: which multipliers have left the unit circle, and which way the parameter goes.

A change of these numbers tells the kind of special point between two orbits; where several come together the step is cut until each
has its own. Two multipliers that meet on the real axis outside the circle change the numbers too, and are no special point.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pddecont.bifurcation import branch_point, fold, period_doubling, torus
from pddecont.continuation.locate import Located
from pddecont.continuation.special import Census, Counts, TestFunction
from pddecont.stability.multipliers import Known, Multipliers


def outside(m: Multipliers) -> Counts:
    """Return how many multipliers are real and above 1, real and below -1, and how many complex pairs lie outside."""
    real, upper = m.own[m.own.imag == 0.0].real, m.own[m.own.imag > 0.0]
    return int(np.sum(real > 1.0)), int(np.sum(real < -1.0)), int(np.sum(np.abs(upper) > 1.0))


FOLD = TestFunction(fold.KIND, fold.turning)


@dataclass(frozen=True, eq=False)
class BranchCensus:
    """The census of a branch in one parameter; without ``known`` multipliers it sees folds only."""

    known: Known | None

    def count(self, point: Located) -> Counts:
        """Return the numbers of :func:`outside` and the direction of the parameter."""
        turn = (int(fold.turning(point) > 0.0),)
        return turn if self.known is None else (*outside(self.known(point.problem.problem, point.x)), *turn)

    def explain(self, before: Counts, after: Counts) -> Sequence[TestFunction] | None:
        """Return the test functions for one change; None for several."""
        if self.known is None:
            return [FOLD]
        plus, minus, pairs, turn = (b - a for a, b in zip(before, after, strict=True))
        change, turned = (plus, minus, pairs), turn != 0
        if turned:
            return [FOLD] if change in ((0, 0, 0), (1, 0, 0), (-1, 0, 0)) else None
        if change in ((1, 0, 0), (-1, 0, 0)):
            return [self._test(branch_point.KIND, branch_point.passing)]
        if change in ((0, 1, 0), (0, -1, 0)):
            return [self._test(period_doubling.KIND, period_doubling.passing)]
        if change in ((0, 0, 1), (0, 0, -1)):
            return [self._test(torus.KIND, torus.passing)]
        return [] if change in ((2, 0, -1), (-2, 0, 1), (0, 2, -1), (0, -2, 1)) else None

    def _test(self, kind: str, of_multipliers) -> TestFunction:  # type: ignore[no-untyped-def]
        known = self.known
        assert known is not None
        return TestFunction(kind, lambda point: of_multipliers(known(point.problem.problem, point.x)))


def branch_census(known: Known | None) -> Census:
    """Return the census of a branch in one parameter."""
    census = BranchCensus(known)
    return Census(census.count, census.explain)
