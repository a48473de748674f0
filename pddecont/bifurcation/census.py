"""What changes where along a branch: which multipliers have left the unit circle, and which way the parameter goes.

A change of these numbers tells the kind of special point between two orbits; where several come together the step is cut until each
has its own. Two multipliers that meet on the real axis outside the circle change the numbers too, and are no special point.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from pddecont.bifurcation import branch_point, fold, period_doubling, torus
from pddecont.continuation.locate import Located
from pddecont.continuation.special import Census, Counts, TestFunction
from pddecont.stability.multipliers import Known, Multipliers

# Whether a kind of special point is asked for.
Asks = Callable[[str], bool]
# A multiplier passes +1, one passes -1, a pair passes the circle elsewhere.
PASSING = (branch_point.passing, period_doubling.passing, torus.passing)
KINDS = (branch_point.KIND, period_doubling.KIND, torus.KIND)
ON_THE_AXIS = ((2, 0, -1), (-2, 0, 1), (0, 2, -1), (0, -2, 1))
FOLD = TestFunction(fold.KIND, fold.turning)


def outside(m: Multipliers) -> Counts:
    """Return how many multipliers are real and above 1, real and below -1, and how many complex pairs lie outside."""
    real, upper = m.own[m.own.imag == 0.0].real, m.own[m.own.imag > 0.0]
    return int(np.sum(real > 1.0)), int(np.sum(real < -1.0)), int(np.sum(np.abs(upper) > 1.0))


def crossings(kinds: Sequence[str], multipliers_of: Callable[[Located], Multipliers]) -> Census:
    """Return the census of a point's multipliers; ``kinds`` name what it is when one passes +1, -1 or the rest of the circle."""

    def test(kind: str, passing: Callable[[Multipliers], float]) -> TestFunction:
        return TestFunction(kind, lambda at: passing(multipliers_of(at)))

    tests = [test(kind, passing) for kind, passing in zip(kinds, PASSING, strict=True)]

    def explain(before: Counts, after: Counts) -> Sequence[TestFunction] | None:
        change = tuple(b - a for a, b in zip(before, after, strict=True))
        if sum(map(abs, change)) == 1:
            return [tests[next(i for i, c in enumerate(change) if c)]]
        return [] if change in ON_THE_AXIS or not any(change) else None

    return Census(lambda at: outside(multipliers_of(at)), explain)


def asked_only(census: Census, kinds: Sequence[str], asks: Asks) -> Census | None:
    """Return the census as far as it is asked for, None if it is not; ``kinds`` name what a change of each number alone is."""
    wanted = [i for i, kind in enumerate(kinds) if asks(kind)]
    if not wanted:
        return None

    def explain(before: Counts, after: Counts) -> Sequence[TestFunction] | None:
        if all(before[i] == after[i] for i in wanted):
            return []
        tests = census.explain(before, after)
        return None if tests is None else [test for test in tests if asks(test.kind)]

    return Census(census.count, explain)


def branch_census(known: Known | None, asks: Asks) -> Census | None:
    """Return the census of a branch in one parameter, as far as it is asked for.

    It counts multipliers, if ``known``, and the direction of the parameter last. At a fold both change at once, by one multiplier at +1
    or, where a branch meets its mirror image, by none.
    """

    def turn(at: Located) -> int:
        return int(fold.turning(at) > 0.0)

    if known is None or not any(map(asks, KINDS)):
        return asked_only(Census(lambda at: (turn(at),), lambda before, after: [FOLD]), (fold.KIND,), asks)
    circle = crossings(KINDS, lambda at: known(at.problem.problem, at.x))

    def explain(before: Counts, after: Counts) -> Sequence[TestFunction] | None:
        if before[-1] == after[-1]:
            return circle.explain(before[:-1], after[:-1])
        change = tuple(b - a for a, b in zip(before[:-1], after[:-1], strict=True))
        return [FOLD] if change in ((0, 0, 0), (1, 0, 0), (-1, 0, 0)) else None

    return asked_only(Census(lambda at: (*circle.count(at), turn(at)), explain), (*KINDS, fold.KIND), asks)
