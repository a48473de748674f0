"""What a ``continue`` step that starts from an equilibrium follows: equilibria, or the orbits that are born there."""

from __future__ import annotations

import cmath
from dataclasses import replace
from typing import Any

from pddecont.bifurcation import (
    FOLD_LABEL,
    BranchSettings,
    BranchStart,
    TorusFunction,
    define_fold,
    start_at_hopf,
    start_curve_at_hopf,
)
from pddecont.equilibrium import find_birth, find_other_frequency, solve_equilibrium
from pddecont.errors import ConvergenceError
from pddecont.runfile import PlannedStep
from pddecont.steps.context import Context
from pddecont.steps.continuation import ContinueSettings
from pddecont.steps.execution.equilibrium import find_equilibrium
from pddecont.steps.execution.equilibrium_rows import equilibrium_from_row

# Special equilibria at which orbits are born, by the number of free parameters.
HOPF, BAUTIN, DOUBLE_HOPF = "HB", "GH", "HH"
ORBITS_BORN = {1: (HOPF,), 2: (BAUTIN, DOUBLE_HOPF)}


def starts_from_equilibrium(context: Context, step: PlannedStep[Any]) -> bool:
    """Return whether a step starts from an equilibrium."""
    assert step.source is not None, "a continue step's schema has a source"
    return "roots" in context.read_source(step.source)[1].format.orbits


def follows_equilibria(context: Context, step: PlannedStep[ContinueSettings]) -> bool:
    """Return whether a step follows equilibria: from one it does, but for orbits that are born where it starts."""
    if not starts_from_equilibrium(context, step):
        return False
    recorded, row = find_equilibrium(context, step)
    return not (step.settings.switches and recorded.kind_of(row) in ORBITS_BORN[len(step.settings.free)])


def start_from_hopf(context: Context, step: PlannedStep[ContinueSettings], settings: BranchSettings) -> BranchStart:
    """Return the first orbit of what is born at the point that a step starts from.

    From a Hopf point a branch of orbits, from a generalised Hopf point a curve of folds, from a Hopf-Hopf point a curve
    of torus bifurcations of the orbits of the curve's own pair.

    Raises
    ------
    ConvergenceError
        If there is none.
    """
    recorded, row = find_equilibrium(context, step)
    plan, kind = context.plan, recorded.kind_of(row)
    at = equilibrium_from_row(plan, step.delay, recorded, row)
    at = replace(at, parameters=plan.set_parameters(step, at.parameters))
    free, width = plan.numeric.parameter_index(settings.free[0]), settings.widths[0]
    try:
        if kind == HOPF:
            at, _, _ = solve_equilibrium(at)
            return start_at_hopf(find_birth(at, free, width), settings)
        own = float(recorded.points["frequency"][row])
        birth = find_birth(at, free, width, own)
        if kind == BAUTIN:
            return start_curve_at_hopf(birth, settings, FOLD_LABEL, define_fold)
        other = find_other_frequency(at, own)
        pair = cmath.exp(2j * cmath.pi * other / own)
        torus = TorusFunction(settings.find_multipliers(), pair if pair.imag >= 0.0 else pair.conjugate())
        return start_curve_at_hopf(birth, settings, torus.kind, lambda _: torus)
    except ConvergenceError as exc:
        text = f"step '{step.name}': no small orbit is found at the {kind} point that it starts from: {exc}"
        raise ConvergenceError(text, exc.history) from exc
