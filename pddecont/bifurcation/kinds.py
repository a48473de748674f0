"""What the program knows of a kind of special point: one entry a kind.

A kind is found along branches of orbits in one parameter, along curves of special points in two, or both. An entry says
how (test functions, or counts of multipliers), how the point itself is defined, so that it can be followed in two
parameters, and how branches go on from it. To add a kind, write a file with its entry and list it in
``bifurcation.builtin``, or hand the entry to ``register_kind``; nothing else names kinds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from pddecont.bifurcation.branch_start import BranchStart
from pddecont.bifurcation.extended_system import DefiningFunction, ExtendedEvaluation
from pddecont.bifurcation.settings import BranchSettings
from pddecont.continuation import BranchPoint, BranchState, CurvePoint, TestFunction
from pddecont.orbit import Orbit, OrbitEvaluation
from pddecont.reasons import Reason
from pddecont.stability import Multipliers

Complex = NDArray[np.complex128]
# Labels of points on a curve where one more multiplier is +1, is -1, or a pair passes the rest of the unit circle.
CROSSINGS = ("GL", "GP", "GT")
OrbitTest: TypeAlias = TestFunction[OrbitEvaluation]
CurveTest: TypeAlias = TestFunction[ExtendedEvaluation]


def _no_branch_tests(at: OrbitEvaluation, settings: BranchSettings) -> Sequence[OrbitTest]:
    return ()


def _no_curve_tests(at: ExtendedEvaluation, settings: BranchSettings) -> Sequence[CurveTest]:
    return ()


def _keep_all(multipliers: Multipliers) -> Complex:
    return multipliers.nontrivial


def _no_side(defining: DefiningFunction) -> float | None:
    return None


@dataclass(frozen=True, eq=False)
class SpecialPointKind:
    """One kind of special point.

    Attributes
    ----------
    label, name
        What files call it (``GR``), and what people do (``grazing``).
    on_branches, on_curves
        Where it can be found.
    needs_multipliers
        Whether it is seen from multipliers.
    branch_tests
        Return its test functions along the branch of orbits that goes on from an orbit.
    curve_tests
        The same along a curve of special points in two parameters.
    define
        Return its defining function at an orbit, so that it can be followed in two parameters; the reason is what was
        recorded of the point. None: it cannot be followed. Raises ConvergenceError where the orbit is no such point.
    good_side
        Return the sign with which a defining function grows to the side of a curve on which the orbit keeps its
        signature or is stable (None: there is no such side).
    crossings
        Labels of points on its curve where one more multiplier is +1, is -1, or a pair passes the unit circle.
    meets
        Labels of the kinds whose curves meet in such a point of a curve: from there the one goes on that it was not
        found on.
    remove_critical
        Return the multipliers of such a point without those that it has on the unit circle by its nature.
    switch
        Return the start of the other branch there, from the recorded orbit, as a guess, and the recorded tangent.
    go_on
        Return where a branch goes on beyond such a point that ended it, None where it really ends; from the point and
        the last ordinary state before it.
    """

    label: str
    name: str
    on_branches: bool = False
    on_curves: bool = False
    needs_multipliers: bool = False
    branch_tests: Callable[[OrbitEvaluation, BranchSettings], Sequence[OrbitTest]] = _no_branch_tests
    curve_tests: Callable[[ExtendedEvaluation, BranchSettings], Sequence[CurveTest]] = _no_curve_tests
    define: Callable[[OrbitEvaluation, BranchSettings, Reason], DefiningFunction] | None = None
    good_side: Callable[[DefiningFunction], float | None] = _no_side
    crossings: tuple[str, str, str] = CROSSINGS
    meets: tuple[str, ...] = ()
    remove_critical: Callable[[Multipliers], Complex] = _keep_all
    switch: Callable[[Orbit, NDArray[np.float64], BranchSettings], BranchStart] | None = None
    go_on: (
        Callable[
            [BranchPoint[OrbitEvaluation], BranchState[OrbitEvaluation], BranchSettings],
            CurvePoint[OrbitEvaluation] | None,
        ]
        | None
    ) = None
