"""What is said of a special point of a branch of equilibria: its normal form, and on which side orbits are born."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pddecont.continuation import BranchPoint
from pddecont.equilibrium.branch_tests import FOLD, HOPF
from pddecont.equilibrium.equations import Equilibrium, EquilibriumEvaluation
from pddecont.equilibrium.normal_forms import (
    DIFFERENCE,
    Forms,
    find_cubic_coefficient,
    find_fold_coefficient,
    find_root_speed,
)
from pddecont.errors import ConvergenceError
from pddecont.reasons import Reason, make_reason

HOPF_CODE, FOLD_CODE = "hopf_normal_form", "fold_normal_form"
# What a Hopf point is by the sign of its first Lyapunov coefficient.
SUPERCRITICAL, SUBCRITICAL = "supercritical", "subcritical"


@dataclass(frozen=True)
class SpecialValues:
    """The frequency of a Hopf point, the coefficient of a normal form (NaN: there is none), and what is said of it."""

    frequency: float
    coefficient: float
    reason: Reason


def find_special_values(point: BranchPoint[EquilibriumEvaluation], parameter: str) -> SpecialValues:
    """Return what is recorded of a special point besides the equilibrium itself."""
    at = point.state.point.at
    if point.kind == HOPF and not at.problem.n_forces:
        return _describe_hopf(point, parameter)
    if point.kind == HOPF:
        return SpecialValues(_find_frequency(at), np.nan, point.reason)
    if point.kind == FOLD and not at.problem.n_forces:
        a = find_fold_coefficient(at.equilibrium)
        return SpecialValues(np.nan, a, make_reason(FOLD_CODE, coefficient=a))
    return SpecialValues(np.nan, np.nan, point.reason)


def _find_frequency(at: EquilibriumEvaluation) -> float:
    values = at.roots.values[at.roots.values.imag > 0.0]
    return float(values[int(np.argmin(np.abs(values.real)))].imag)


def _describe_hopf(point: BranchPoint[EquilibriumEvaluation], parameter: str) -> SpecialValues:
    state, at = point.state, point.state.point.at
    omega = _find_frequency(at)
    try:
        forms = Forms(at.equilibrium)
        critical = forms.find_critical(1j * omega)
        cubic = find_cubic_coefficient(forms, critical)
    except ConvergenceError:
        return SpecialValues(omega, np.nan, point.reason)
    coefficient = cubic.real / omega
    problem = at.problem

    def beside(sign: float) -> Equilibrium:
        return problem.split(at.x + sign * DIFFERENCE * state.tangent)

    # |z|^2 = -Re (d lambda / d s) / Re c1 (s - s_0): orbits lie where this is positive.
    speed = find_root_speed(critical, beside(-1.0), beside(1.0), 2.0 * DIFFERENCE).real
    onward = -speed * cubic.real * float(state.tangent[-1])
    reason = make_reason(
        HOPF_CODE,
        nature=SUPERCRITICAL if coefficient < 0.0 else SUBCRITICAL,
        frequency=omega,
        coefficient=coefficient,
        side="larger" if onward > 0.0 else "smaller",
        parameter=parameter,
    )
    return SpecialValues(omega, coefficient, reason)
