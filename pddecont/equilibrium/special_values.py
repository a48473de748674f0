"""What is said of a special point of a branch of equilibria: its normal form, and on which side orbits are born."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass

import numpy as np

from pddecont.continuation import BranchPoint
from pddecont.equilibrium.birth import find_birth
from pddecont.equilibrium.branch_tests import FOLD, HOPF
from pddecont.equilibrium.critical import CriticalEvaluation
from pddecont.equilibrium.curve_tests import TAKENS, ZERO_HOPF
from pddecont.equilibrium.equations import EquilibriumEvaluation
from pddecont.equilibrium.hopf_condition import find_frequency
from pddecont.equilibrium.normal_forms import Forms, find_cubic_coefficient, find_fold_coefficient
from pddecont.errors import ConvergenceError
from pddecont.reasons import Reason, make_reason

HOPF_CODE, LINEAR_HOPF_CODE, FOLD_CODE = "hopf_normal_form", "linear_hopf", "fold_normal_form"
# What a Hopf point is by the sign of its first Lyapunov coefficient.
SUPERCRITICAL, SUBCRITICAL = "supercritical", "subcritical"
# Points of curves at which the coefficient is infinite: another root is zero there.
UNDEFINED = {(FOLD, TAKENS), (HOPF, TAKENS), (HOPF, ZERO_HOPF)}


@dataclass(frozen=True)
class SpecialValues:
    """The frequency of a Hopf point, the coefficient of a normal form (NaN: there is none), and what is said of it."""

    frequency: float
    coefficient: float
    reason: Reason


def find_special_values(point: BranchPoint[EquilibriumEvaluation], parameter: str, width: float) -> SpecialValues:
    """Return what is recorded of a special point besides the equilibrium itself.

    ``width`` is that of the range of the free ``parameter``.
    """
    at = point.state.point.at
    if point.kind == HOPF:
        return _describe_hopf(point, parameter, width)
    if point.kind == FOLD and not at.problem.n_forces:
        a = find_fold_coefficient(at.equilibrium)
        return SpecialValues(np.nan, a, make_reason(FOLD_CODE, coefficient=a))
    return SpecialValues(np.nan, np.nan, point.reason)


def _describe_hopf(point: BranchPoint[EquilibriumEvaluation], parameter: str, width: float) -> SpecialValues:
    at = point.state.point.at
    try:
        birth = find_birth(at.equilibrium, at.problem.free[0], width)
    except ConvergenceError:
        return SpecialValues(np.nan, np.nan, point.reason)
    if not np.isfinite(birth.coefficient):
        return SpecialValues(birth.frequency, np.nan, point.reason)
    if birth.coefficient == 0.0:
        return SpecialValues(birth.frequency, 0.0, make_reason(LINEAR_HOPF_CODE, frequency=birth.frequency))
    reason = make_reason(
        HOPF_CODE,
        nature=SUPERCRITICAL if birth.coefficient < 0.0 else SUBCRITICAL,
        frequency=birth.frequency,
        coefficient=birth.coefficient,
        side="larger" if birth.growth > 0.0 else "smaller",
        parameter=parameter,
    )
    return SpecialValues(birth.frequency, birth.coefficient, reason)


def find_curve_values(point: BranchPoint[CriticalEvaluation]) -> SpecialValues:
    """Return what is recorded of a point of a curve: the frequency and the coefficient of its normal form."""
    at = point.state.point.at
    curve, defined = at.system.critical.label, not at.system.problem.n_forces
    frequency = np.nan
    if curve == HOPF:
        frequency = 0.0 if point.kind == TAKENS else find_frequency(at.own)
    coefficient = np.nan
    if defined and (curve, point.kind) not in UNDEFINED:
        with contextlib.suppress(ConvergenceError):
            coefficient = _find_coefficient(at, curve, frequency)
    return SpecialValues(frequency, coefficient, point.reason)


def _find_coefficient(at: CriticalEvaluation, curve: str, frequency: float) -> float:
    """Return the coefficient of the normal form of a fold or a Hopf point; NaN of others."""
    if curve == FOLD:
        return find_fold_coefficient(at.equilibrium)
    if curve != HOPF or frequency == 0.0:
        return np.nan
    forms = Forms(at.equilibrium)
    return find_cubic_coefficient(forms, forms.find_critical(1j * frequency)).real / frequency
