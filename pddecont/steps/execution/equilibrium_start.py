"""What a ``continue`` step that starts from an equilibrium follows: equilibria, or the orbits that are born there."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from pddecont.bifurcation import BranchSettings, BranchStart, start_at_hopf
from pddecont.equilibrium import find_birth, solve_equilibrium
from pddecont.errors import ConvergenceError
from pddecont.runfile import PlannedStep
from pddecont.steps.context import Context
from pddecont.steps.continuation import ContinueSettings
from pddecont.steps.execution.equilibrium import find_equilibrium
from pddecont.steps.execution.equilibrium_rows import equilibrium_from_row

HOPF = "HB"


def starts_from_equilibrium(context: Context, step: PlannedStep[Any]) -> bool:
    """Return whether a step starts from an equilibrium."""
    assert step.source is not None, "a continue step's schema has a source"
    return "roots" in context.read_source(step.source)[1].format.orbits


def follows_equilibria(context: Context, step: PlannedStep[ContinueSettings]) -> bool:
    """Return whether a step follows equilibria: from one it does, but for the orbits that are born at a Hopf point."""
    if not starts_from_equilibrium(context, step):
        return False
    recorded, row = find_equilibrium(context, step)
    return not (step.settings.switches and recorded.kind_of(row) == HOPF)


def start_from_hopf(context: Context, step: PlannedStep[ContinueSettings], settings: BranchSettings) -> BranchStart:
    """Return the first orbit of the branch that is born at the Hopf point that a step starts from.

    Raises
    ------
    ConvergenceError
        If there is none.
    """
    recorded, row = find_equilibrium(context, step)
    plan = context.plan
    guess = equilibrium_from_row(plan, step.delay, recorded, row)
    try:
        at, _, _ = solve_equilibrium(replace(guess, parameters=plan.set_parameters(step, guess.parameters)))
        birth = find_birth(at, plan.numeric.parameter_index(settings.free[0]), settings.widths[0])
        return start_at_hopf(birth, settings)
    except ConvergenceError as exc:
        text = f"step '{step.name}': no small orbit is found at the Hopf point that it starts from: {exc}"
        raise ConvergenceError(text, exc.history) from exc
