"""Torus (TR): a pair of complex multipliers crosses the unit circle.

On a curve in two parameters the defining function is the product of the pair less 1. Product and sum of the pair are
smooth even where it meets on the real axis, which ends the curve: at a sum of 2 (resonance 1:1) or -2 (1:2). On the way
-1 is 1:3 and 0 is 1:4.

Reference: Kuznetsov, Elements of Applied Bifurcation Theory (2004), chapter 9.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.bifurcation import fold, period_doubling
from pddecont.bifurcation.extended_system import DefiningFunction, ExtendedEvaluation, ExtendedSystem
from pddecont.bifurcation.kinds import CurveTest, SpecialPointKind
from pddecont.bifurcation.settings import BranchSettings
from pddecont.continuation import CurvePoint, TestFunction
from pddecont.errors import ConvergenceError
from pddecont.orbit import OrbitEvaluation
from pddecont.reasons import Reason
from pddecont.stability import MultiplierCache, Multipliers

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
LABEL = "TR"
# Two real multipliers this near to each other are about to become a pair.
TOGETHER = 1e-2
# Length of a step aside that shows whether they do.
ASIDE = 1e-4
# Code of the end of a curve where its pair meets on the real axis.
RESONANCE = "resonance"


def measure_distance(m: Multipliers) -> float:
    """Return the distance to the unit circle of the complex pair nearest to it; pairs outside alternate its sign."""
    upper = np.abs(m.nontrivial[m.nontrivial.imag > 0.0])
    if not len(upper):
        return float("nan")
    return float((-1.0) ** np.sum(upper > 1.0) * np.min(np.abs(upper - 1.0)))


@dataclass(frozen=True, eq=False)
class TorusFunction:
    """The product of a pair of multipliers less 1; ``near`` is where the pair's upper one was."""

    multipliers: MultiplierCache
    near: complex
    kind: str = LABEL

    def find_pair(self, at: OrbitEvaluation) -> tuple[complex, complex]:
        """Return the two multipliers; NaN if there are not two."""
        values = self.multipliers.find(at.orbit).nontrivial
        if len(values) < 2:
            return complex("nan"), complex("nan")
        i = int(np.argmin(np.abs(values - self.near)))
        others = np.where(np.arange(len(values)) == i, np.inf, np.abs(values - np.conj(self.near)))
        return complex(values[i]), complex(values[int(np.argmin(others))])

    def evaluate(self, at: OrbitEvaluation) -> float:
        """Return product - 1."""
        a, b = self.find_pair(at)
        return float((a * b).real - 1.0)

    def find_sum(self, at: OrbitEvaluation) -> float:
        """Return the sum of the pair, 2 cos(angle) on the curve."""
        a, b = self.find_pair(at)
        return float((a + b).real)

    def update_at(self, at: OrbitEvaluation) -> TorusFunction:
        """Return the same function with the pair looked for where it is at an orbit."""
        a, b = self.find_pair(at)
        return TorusFunction(self.multipliers, a if a.imag >= b.imag else b)


def _define(at: OrbitEvaluation, settings: BranchSettings, reason: Reason) -> DefiningFunction:
    multipliers = settings.find_multipliers()
    values = multipliers.find(at.orbit).nontrivial
    # Where a pair meets on the real axis rounding decides whether it is complex.
    real = values[values.imag == 0.0]
    doubled = real[:-1][np.abs(np.diff(real)) < TOGETHER] if len(real) else real
    upper = np.concatenate([values[values.imag > 0.0], doubled])
    if not len(upper):
        raise ConvergenceError("no complex pair of multipliers is left at this point")
    return TorusFunction(multipliers, complex(upper[np.argmin(np.abs(np.abs(upper) - 1.0))]))


def find_side_with_pair(system: ExtendedSystem, x: Array, direction: Array) -> float:
    """Return on which side (1 or -1 times ``direction``) of a resonance at ``x`` its pair is complex; 0 elsewhere.

    On the other side the curve of the same equations is one of two real multipliers whose product is 1, and no tori are
    born there.
    """
    pair = system.defining
    if not isinstance(pair, TorusFunction):
        return 0.0
    before, here, after = (pair.find_sum(system.at(x + step * direction).inner) for step in (-ASIDE, 0.0, ASIDE))
    return 0.0 if abs(here) < 2.0 - TOGETHER else float(np.sign(np.sign(here) * (before - after)))


def remove_pair(m: Multipliers) -> Complex:
    """Return the multipliers without the two, complex or past a resonance real, whose product is nearest to 1."""
    values = m.nontrivial
    if len(values) < 2:
        return values
    lower = np.tril(np.full((len(values), len(values)), np.inf))
    product = np.abs(np.triu(values[:, None] * values, 1) - 1.0) + lower
    return np.delete(values, np.unravel_index(np.argmin(product), product.shape))


TORUS = SpecialPointKind(
    LABEL,
    "torus",
    on_branches=True,
    needs_multipliers=True,
    define=_define,
    good_side=lambda _: -1.0,
    crossings=("FT", "PT", "TT"),
    remove_critical=remove_pair,
)


def _make_resonance(label: str, name: str, level: float, other: str = "") -> SpecialPointKind:
    """Return the kind of a resonance: the sum of the pair is ``level``.

    Where it meets on the real axis the curve ends on one of the ``other`` kind.
    """

    def value(point: CurvePoint[ExtendedEvaluation]) -> float:
        defining = point.at.system.defining
        assert isinstance(defining, TorusFunction)
        return defining.find_sum(point.at.inner) - level

    def tests(at: ExtendedEvaluation, settings: BranchSettings) -> list[CurveTest]:
        return [TestFunction(label, value, end)] if isinstance(at.system.defining, TorusFunction) else []

    end = RESONANCE if other else ""
    meets = (other, LABEL) if other else ()
    return SpecialPointKind(label, name, on_curves=True, curve_tests=tests, meets=meets)


RESONANCES = (
    _make_resonance("R1", "resonance 1:1", 2.0, fold.LABEL),
    _make_resonance("R2", "resonance 1:2", -2.0, period_doubling.LABEL),
    _make_resonance("R3", "resonance 1:3", -1.0),
    _make_resonance("R4", "resonance 1:4", 0.0),
)
