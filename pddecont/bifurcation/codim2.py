"""Points on curves in two parameters where one more thing happens.

    on LP:  CP cusp, R1 second multiplier +1, FF fold-flip, FT fold-torus
    on PD:  FF fold-flip, R2 second multiplier -1, PT flip-torus
    on TR:  R1 R2 R3 R4 resonances 1:1 .. 1:4 (the curve ends at the first two), FT, PT, TT double torus
    on GR, VS and user functions:  GG double grazing, GL, GP, GT a multiplier +1, -1 or a complex pair on the unit circle

Reference: Kuznetsov, Elements of Applied Bifurcation Theory (2004), chapter 9.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pddecont.bifurcation import branch_point, fold, period_doubling, torus
from pddecont.bifurcation.census import Asks, asked_only, crossings
from pddecont.bifurcation.conditioned import SpecialCurve
from pddecont.bifurcation.fold import Fold
from pddecont.bifurcation.grazing import Graze, clearance
from pddecont.bifurcation.torus import Torus
from pddecont.continuation.ending import End
from pddecont.continuation.locate import Located
from pddecont.continuation.special import TestFunction, Watch
from pddecont.stability.multipliers import Known, Multipliers, without

KINDS = {"LP": ("R1", "FF", "FT"), "PD": ("FF", "R2", "PT"), "TR": ("FT", "PT", "TT")}
OTHERS = ("GL", "GP", "GT")
RESONANCES = (("R1", 2.0, True), ("R2", -2.0, True), ("R3", -1.0, False), ("R4", 0.0, False))


def watch_curve(special: SpecialCurve, known: Known | None, asks: Asks) -> Watch:
    """Return what is watched along a curve of special points, as far as it is asked for; without ``known`` nothing of multipliers."""
    tests: list[TestFunction] = []
    kind = special.condition.kind
    if isinstance(special.condition, Fold):
        tests.append(TestFunction("CP", cusp))
    if isinstance(special.condition, Torus):
        tests += [TestFunction(name, _resonance(level), stops, end=End.RESONANCE) for name, level, stops in RESONANCES]
    if isinstance(special.condition, Graze):
        tests.append(TestFunction("GG", lambda at: at.problem.condition.others(at.problem.curve, at.x)))
    elif kind not in ("UF",):
        tests.append(TestFunction("GG", lambda at: clearance(at.problem.problem, at.x), note="grazing"))
    tests = [test for test in tests if asks(test.kind)]
    if known is None:
        return Watch(tests)
    kinds = KINDS.get(kind, OTHERS)
    census = crossings(kinds, lambda at: without_critical(known(at.problem.problem, at.x), kind))
    return Watch(tests, asked_only(census, kinds, asks))


def cusp(at: Located) -> float:
    """Return how the fold condition changes along the null vector: zero at a cusp."""
    special = at.problem
    assert isinstance(special, SpecialCurve) and isinstance(special.condition, Fold)
    null, _ = special.condition.null(special.curve, at.x)
    direction = np.zeros(len(at.x))
    direction[: len(null)] = null * special.metric().scale[: len(null)]
    return float(special.slopes(at.x, special.metric().unit(direction)[None])[0])


def _resonance(level: float) -> Callable[[Located], float]:
    def value(at: Located) -> float:
        condition = at.problem.condition
        assert isinstance(condition, Torus)
        return condition.sum(at.problem.curve, at.x) - level

    return value


def without_critical(m: Multipliers, kind: str) -> Multipliers:
    """Return the multipliers without those that a special point of ``kind`` has on the unit circle."""
    own = m.own
    if kind in (fold.KIND, branch_point.KIND):
        own = without(own, 1.0)
    elif kind == period_doubling.KIND:
        own = without(own, -1.0)
    elif kind == torus.KIND and len(own) > 1:
        # Complex or, past a resonance, real: the two whose product is nearest to 1.
        product = np.abs(np.triu(own[:, None] * own, 1) - 1.0) + np.tril(np.full((len(own), len(own)), np.inf))
        own = np.delete(own, np.unravel_index(np.argmin(product), product.shape))
    return replace(m, own=own)
