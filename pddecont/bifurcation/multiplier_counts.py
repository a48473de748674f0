"""What changes where along a branch: which multipliers have left the unit circle, and which way the parameter goes.

A change of these numbers tells the kind of special point between two orbits; where several come together the step is
cut until each has its own. Two multipliers that meet on the real axis outside the circle change the numbers too, and
are no special point.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np

from pddecont.bifurcation import branch_point, fold, period_doubling, torus
from pddecont.bifurcation.extended_system import ExtendedEvaluation
from pddecont.bifurcation.kinds import SpecialPointKind
from pddecont.bifurcation.settings import BranchSettings
from pddecont.continuation import CountFunction, Counts, CurvePoint, TestFunction
from pddecont.orbit import OrbitEvaluation
from pddecont.stability import OUTSIDE, Multipliers

# A multiplier passes +1, one passes -1, a pair passes the circle elsewhere.
TEST_FUNCTIONS = (branch_point.measure_distance, period_doubling.measure_distance, torus.measure_distance)
# The multipliers of the first two.
CRITICAL = (1.0, -1.0)
ON_BRANCHES = (branch_point.LABEL, period_doubling.LABEL, torus.LABEL)
# Two real multipliers outside the circle become a pair, or the other way round.
ON_THE_AXIS = ((2, 0, -1), (-2, 0, 1), (0, 2, -1), (0, -2, 1))
FOLD_TEST: TestFunction[OrbitEvaluation] = TestFunction(fold.LABEL, fold.parameter_tangent)
# At a fold the parameter turns and at most one multiplier passes +1; where a branch meets its mirror image, none does.
FOLD_CHANGES = ((0, 0, 0), (1, 0, 0), (-1, 0, 0))
# A point at which no multiplier is nearer than this to +1, to -1 or to the circle is none at which one passes there.
HOLDS = 1e-4
AnyCount: TypeAlias = CountFunction[Any]
FindMultipliers: TypeAlias = Callable[[CurvePoint[Any]], Multipliers]


def count_outside(m: Multipliers) -> Counts:
    """Return how many multipliers are real and above 1, real and below -1, and how many complex pairs lie outside."""
    values = m.nontrivial
    real, upper = values[values.imag == 0.0].real, values[values.imag > 0.0]
    return int(np.sum(real > OUTSIDE)), int(np.sum(real < -OUTSIDE)), int(np.sum(np.abs(upper) > OUTSIDE))


def evaluate_polynomial(m: Multipliers, at: float) -> float:
    """Return the characteristic polynomial of the multipliers at +1 or -1, positive with all of them inside the circle.

    It is smooth where two of them meet on the real axis; those that are small, of which now more, now fewer are known,
    hardly change it.
    """
    return float(np.prod(1.0 - at * m.nontrivial).real)


def measure_miss(m: Multipliers, critical: float | None) -> float:
    """Return how far the nearest multiplier is from +1 or -1, or from the unit circle (None).

    Complex ones count too for +1 and -1, and real ones for the circle: where two meet rounding decides which they are.
    """
    if critical is None:
        return float(np.min(np.abs(np.abs(m.nontrivial) - 1.0), initial=np.inf))
    return float(np.min(np.abs(m.nontrivial - critical), initial=np.inf))


def count_crossings(labels: Sequence[str], find: FindMultipliers) -> AnyCount:
    """Return the counts of a point's multipliers.

    ``labels`` name what it is when one passes +1, -1 or the rest of the circle.
    """

    def holds(point: CurvePoint[Any], critical: float | None) -> bool:
        return measure_miss(find(point), critical) < HOLDS

    def make_test(label: str, i: int) -> TestFunction[Any]:
        value, crosses = TEST_FUNCTIONS[i], label == branch_point.LABEL
        if i == 2:
            return TestFunction(label, lambda point: value(find(point)), holds=lambda point: holds(point, None))
        critical = CRITICAL[i]
        return TestFunction(
            label,
            lambda point: value(find(point)),
            crosses=crosses,
            smooth=lambda point: evaluate_polynomial(find(point), critical),
            holds=lambda point: holds(point, critical),
        )

    tests = [make_test(label, i) for i, label in enumerate(labels)]

    def explain(before: Counts, after: Counts) -> Sequence[TestFunction[Any]] | None:
        change = tuple(b - a for a, b in zip(before, after, strict=True))
        if sum(map(abs, change)) == 1:
            return [tests[next(i for i, c in enumerate(change) if c)]]
        return [] if change in ON_THE_AXIS or not any(change) else None

    return CountFunction(lambda point: count_outside(find(point)), explain)


def _restrict(counts: AnyCount, labels: Sequence[str], settings: BranchSettings) -> AnyCount | None:
    """Return counts as far as their special points are looked for, None if none is.

    ``labels`` name what a change of each number alone is.
    """
    wanted = [i for i, label in enumerate(labels) if settings.wants(label)]
    if not wanted:
        return None

    def explain(before: Counts, after: Counts) -> Sequence[TestFunction[Any]] | None:
        if all(before[i] == after[i] for i in wanted):
            return []
        tests = counts.explain(before, after)
        return None if tests is None else [test for test in tests if settings.wants(test.kind)]

    return CountFunction(counts.count, explain)


def count_on_branch(settings: BranchSettings) -> AnyCount | None:
    """Return the counts along a branch of orbits: multipliers, if wanted, and the direction of the parameter last."""

    def turn(point: CurvePoint[OrbitEvaluation]) -> int:
        return int(fold.parameter_tangent(point) > 0.0)

    multipliers = settings.multipliers
    if multipliers is None or not any(map(settings.wants, ON_BRANCHES)):
        turns: AnyCount = CountFunction(lambda point: (turn(point),), lambda before, after: [FOLD_TEST])
        return _restrict(turns, (fold.LABEL,), settings)
    circle = count_crossings(ON_BRANCHES, lambda point: multipliers.find(point.at.orbit))

    def explain(before: Counts, after: Counts) -> Sequence[TestFunction[Any]] | None:
        if before[-1] == after[-1]:
            return circle.explain(before[:-1], after[:-1])
        change = tuple(b - a for a, b in zip(before[:-1], after[:-1], strict=True))
        return [FOLD_TEST] if change in FOLD_CHANGES else None

    counts: AnyCount = CountFunction(lambda point: (*circle.count(point), turn(point)), explain)
    return _restrict(counts, (*ON_BRANCHES, fold.LABEL), settings)


def count_on_curve(kind: SpecialPointKind, settings: BranchSettings) -> AnyCount | None:
    """Return the counts along a curve of special points of a kind, whose own multipliers on the circle do not count."""
    multipliers = settings.multipliers
    if multipliers is None:
        return None

    def find(point: CurvePoint[ExtendedEvaluation]) -> Multipliers:
        found = multipliers.find(point.at.orbit)
        return replace(found, nontrivial=kind.remove_critical(found))

    return _restrict(count_crossings(kind.crossings, find), kind.crossings, settings)
