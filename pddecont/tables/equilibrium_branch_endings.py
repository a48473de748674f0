"""How branches of equilibria ended, in a sentence each, with advice."""

from __future__ import annotations

from pddecont.reasons import Reason
from pddecont.results import Step
from pddecont.tables.branch_endings import BRANCH_ENDS, Ends, describe_direction
from pddecont.tables.words import name_kind

UNSTATED_ROOTS = (
    "a count of the characteristic roots to the right of the imaginary axis does not confirm those that were found, "
    "and whether the equilibrium is stable is not known"
)
# What ends a branch of equilibria, where that is not said as of orbits.
EQUILIBRIUM_ENDS: Ends = {
    **BRANCH_ENDS,
    "step_too_small": (
        "the step fell below 'step: {min}'",
        "look at the last equilibria for an event surface or a sharp fold, or lower 'step: {min}'",
    ),
    "impossible": ("can go no further in this mode", ""),
    "special": ("ends at a special point", ""),
}


def describe_equilibrium_branch(step: Step, ending: Reason) -> str:
    """Return how a direction of a branch, or curve, of equilibria ended."""
    if ending.values.get("detail") == "kind":
        kind = str(ending.values["kind"])
        ending = Reason(ending.code, {**ending.values, "kind": f"{kind}, {name_kind(step, kind)}"})
    return describe_direction(step, ending, "modes", EQUILIBRIUM_ENDS)
