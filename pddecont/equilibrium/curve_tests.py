"""Points of codimension two along curves of special equilibria: CP, BT, ZH, HH, GH.

    along folds     cusp (CP): the coefficient a is zero; Bogdanov-Takens (BT): p Delta'(0) q = 0; zero-Hopf (ZH): a
                    pair crosses the imaginary axis
    along Hopf      generalised Hopf (GH): l1 is zero; Bogdanov-Takens (BT): omega is zero, the curve ends; zero-Hopf
    points          (ZH): a real root passes zero; Hopf-Hopf (HH): another pair crosses the axis

Reference: Kuznetsov, Elements of Applied Bifurcation Theory (2004), chapter 8 and section 10.5.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

import numpy as np

from pddecont.continuation import CountFunction, Counts, CurvePoint, End, TestFunction, TestFunctions
from pddecont.equilibrium.branch_tests import PairTest
from pddecont.equilibrium.critical import CriticalEvaluation
from pddecont.equilibrium.crossings import count_unstable, hides_crossings
from pddecont.equilibrium.expansion import Exponential
from pddecont.equilibrium.hopf_condition import find_frequency
from pddecont.equilibrium.mirrored import find_mirrored
from pddecont.equilibrium.normal_forms import Forms, find_cubic_coefficient
from pddecont.errors import ConvergenceError
from pddecont.reasons import make_reason

CUSP, TAKENS, ZERO_HOPF, DOUBLE_HOPF, BAUTIN = "CP", "BT", "ZH", "HH", "GH"
CURVE_NAMES = {
    CUSP: "cusp",
    TAKENS: "Bogdanov-Takens",
    ZERO_HOPF: "zero-Hopf",
    DOUBLE_HOPF: "Hopf-Hopf",
    BAUTIN: "generalised Hopf",
}
# Next to where it is zero the square of a frequency is less than this part of what is typical of it.
SMALL = 0.3
# What is said of a Bogdanov-Takens point.
HOMOCLINIC = make_reason("homoclinic")
Point = CurvePoint[CriticalEvaluation]


def make_curve_tests(
    at: CriticalEvaluation, detect: Collection[str] | None = None
) -> TestFunctions[CriticalEvaluation]:
    """Return what is looked for along a curve of special equilibria: kinds in ``detect`` (None: all)."""

    def wants(label: str) -> bool:
        return detect is None or label in detect

    kind, smooth = at.system.critical.label, not at.system.problem.n_forces
    tests: list[TestFunction[CriticalEvaluation]] = []
    if kind == "LP" and smooth:
        tests = [TestFunction(CUSP, _measure_cusp), TestFunction(TAKENS, _measure_takens, reason=HOMOCLINIC)]
        labels = ("", ZERO_HOPF)
    elif kind == "HB":
        # Beyond omega = 0 the roots are real, or the curve comes back on the mirror image of its way.
        tests = [
            TestFunction(TAKENS, lambda point: float(point.at.own[-1]), End.SPECIAL, HOMOCLINIC),
            TestFunction(TAKENS, _measure_turning, End.SPECIAL, HOMOCLINIC, find_meeting=find_mirrored),
        ]
        tests += [TestFunction(BAUTIN, _measure_bautin)] if smooth else []
        labels = (ZERO_HOPF, DOUBLE_HOPF)
    else:
        return TestFunctions([])
    counts = CountFunction(count_unstable, _make_explain(labels), hides_crossings)
    return TestFunctions([test for test in tests if wants(test.kind)], counts if any(map(wants, labels)) else None)


def _make_explain(labels: tuple[str, str]) -> Any:
    def explain(before: Counts, after: Counts) -> Sequence[TestFunction[CriticalEvaluation]] | None:
        real, pairs = after[0] - before[0], after[1] - before[1]
        if abs(real) == 1 and pairs == 0:
            return [TestFunction(labels[0], _measure_real)] if labels[0] else []
        if real == 0 and abs(pairs) == 1:
            return [TestFunction(labels[1], PairTest(min(before[1], after[1])))]
        return [] if (real, pairs) in ((2, -1), (-2, 1), (0, 0)) else None

    return explain


def _measure_real(point: Point) -> float:
    """Return the real root nearest to zero."""
    values = point.at.roots.values
    real = values[values.imag == 0.0].real
    return float(real[int(np.argmin(np.abs(real)))]) if len(real) else float("nan")


def _measure_cusp(point: Point) -> float:
    """Return p . B(q, q), p and q the null vectors; p on one side along the curve."""
    at = point.at
    phi = Exponential(at.own.astype(complex), 0.0 + 0.0j)
    return float((_find_left(at) @ Forms(at.equilibrium).second(phi, phi)).real)


def _measure_takens(point: Point) -> float:
    """Return p . Delta'(0) q."""
    at = point.at
    return float((_find_left(at) @ (Forms(at.equilibrium).matrix.at(0.0 + 0.0j)[1] @ at.own)).real)


def _find_left(at: CriticalEvaluation) -> Any:
    """Return the left null vector of the Jacobian, of length one, on the side that the derivatives tell.

    Its sign is that with which the Jacobian, bordered by it and by the null vector, has a positive determinant.
    """
    jacobian = at.inner.jacobian()
    dense = jacobian if isinstance(jacobian, np.ndarray) else jacobian.toarray()
    square = dense[:, : len(at.own)]
    left = np.linalg.svd(square)[0][:, -1]
    bordered = np.block([[square, left[:, None]], [at.own[None, :], np.zeros((1, 1))]])
    return left if np.linalg.slogdet(bordered)[0] > 0.0 else -left


def _measure_turning(point: Point) -> float:
    """Return the frequency, relative to what is typical, on the side to which it changes; NaN where it is not small.

    Where omega^2 is zero to the second order along the curve that function changes its sign.
    """
    square = abs(float(point.at.own[-1])) / float(point.system.scaling.scale[-3])
    return float(np.copysign(np.sqrt(square), point.tangent[-3])) if square < SMALL else float("nan")


def _measure_bautin(point: Point) -> float:
    """Return the first Lyapunov coefficient."""
    at = point.at
    omega = find_frequency(at.own)
    if omega == 0.0:
        return float("nan")
    try:
        forms = Forms(at.equilibrium)
        return find_cubic_coefficient(forms, forms.find_critical(1j * omega)).real / omega
    except ConvergenceError:
        return float("nan")
