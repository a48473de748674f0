"""How steps that hold equilibria ended, in a sentence each, with advice."""

from __future__ import annotations

from pddecont.reasons import Reason
from pddecont.results import Step
from pddecont.tables.branch_endings import BRANCH_ENDS, Ends, describe_direction
from pddecont.tables.equilibria import read_mode, read_roots
from pddecont.tables.words import describe_reason, name_kind

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
# What the ending of a step says that just found equilibria.
FOUND = "equilibria"


def describe_equilibria(step: Step, ending: Reason) -> str:
    """Return how many equilibria a step found and how many of them are stable; of one also its leading root."""
    n = len(step)
    text = f"1 equilibrium: {_describe_one(step)}" if n == 1 else f"{n or 'no'} equilibria{_count_kinds(step)}"
    return text if ending.code == FOUND else f"{text}; {describe_reason(ending)}"


def describe_equilibrium_branch(step: Step, ending: Reason) -> str:
    """Return how a direction of a branch, or curve, of equilibria ended."""
    if ending.values.get("detail") == "kind":
        kind = str(ending.values["kind"])
        ending = Reason(ending.code, {**ending.values, "kind": f"{kind}, {name_kind(step, kind)}"})
    return describe_direction(step, ending, "modes", EQUILIBRIUM_ENDS)


def _describe_one(step: Step) -> str:
    p, roots = step.points, read_roots(step, 0)
    n_unstable = int(p["n_unstable"][0])
    if n_unstable < 0:
        stable = f"WARNING: {UNSTATED_ROOTS}"
    elif n_unstable:
        stable = f"unstable ({n_unstable} root{'s'[: n_unstable - 1]} to the right of the imaginary axis)"
    else:
        stable = "stable" if p["stable"][0] == 1 else "no root to the right of the imaginary axis"
    if len(roots):
        leading = complex(roots[0])
        stable += f", leading root {leading.real:.6g}{f'{leading.imag:+.6g}i' if leading.imag else ''}"
    beyond = f"virtual: it does not lie in its mode '{read_mode(step, 0)}'; " if not p["admissible"][0] else ""
    return beyond + stable


def _count_kinds(step: Step) -> str:
    """Return how many equilibria are stable, unstable, of unknown stability, and virtual, after a colon."""
    p = step.points
    real = p["admissible"] != 0
    counts = {
        "stable": int((real & (p["stable"] == 1)).sum()),
        "unstable": int((real & (p["stable"] == 0)).sum()),
        "of unknown stability": int((real & (p["stable"] < 0)).sum()),
        "virtual": int((~real).sum()),
    }
    shown = ", ".join(f"{n} {what}" for what, n in counts.items() if n)
    return f": {shown}" if shown else ""
