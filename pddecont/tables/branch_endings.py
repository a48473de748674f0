"""How directions of branches ended, in a sentence each, with advice."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

from pddecont.reasons import Reason
from pddecont.results import Step
from pddecont.tables.orbits import find_signature
from pddecont.tables.words import describe_reason

Ends: TypeAlias = Mapping[str, tuple[str, str]]
# What ends a branch: what happened, and what to do.
BRANCH_ENDS: Ends = {
    "range": ("reached the end of the range", "widen 'range' to go on"),
    "max_points": ("reached 'max_points'", "raise it, or 'step: {max}', to go on"),
    "step_too_small": (
        "the step fell below 'step: {min}'",
        "look at the last orbits for a grazing, a vanishing segment or a sharp fold, refine 'mesh', or lower "
        "'step: {min}'",
    ),
    "impossible": ("can go no further with this signature", ""),
    "limit": ("reached a limit of the model", ""),
    "special": ("stopped at a special point where the signature of the orbit changes", ""),
    "invalid": ("the orbit of this signature stops being a motion of the model", "start anew from a simulation beyond"),
    "closed": ("the branch is closed: it is back at its first point", ""),
    "asymptote": ("runs along an asymptote", ""),
    "halved": ("fell onto the single orbit: both halves of the orbit are equal there", ""),
    "shrinks": ("the orbits shrink to an equilibrium", ""),
    "resonance": ("the curve ends where its pair of multipliers meets on the real axis", ""),
}
# Values of an ending that are not those of its detail.
_OWN = ("direction", "unexplained", "detail", "next_signature")


def describe_branch_end(code: str, detail: Reason, n_unexplained: int = 0, ends: Ends = BRANCH_ENDS) -> str:
    """Return how a direction of a branch ended: what, where, what to do, why; ``ends`` are words for each code."""
    what, advice = ends.get(code, (code.replace("_", " "), ""))
    words = describe_reason(detail)
    where, why = (f", {words}", "") if code == "range" and words else ("", f" ({words})" if words else "")
    s = "s"[: n_unexplained - 1]
    lost = f"; WARNING: {n_unexplained} change{s} of stability not located: take smaller steps" if n_unexplained else ""
    return f"{what}{where}{f'; {advice}' if advice else ''}{why}{lost}"


def describe_direction(step: Step, ending: Reason, places: str, ends: Ends = BRANCH_ENDS) -> str:
    """Return which way a direction went and how it ended, with the signatures or modes that it went through.

    ``places`` is what these are called.
    """
    v = ending.values
    way = int(v["direction"])
    detail = Reason(str(v.get("detail", "")), {k: value for k, value in v.items() if k not in _OWN})
    text = describe_branch_end(ending.code, detail, int(v.get("unexplained", 0)), ends)
    names = _list_signatures_along(step, way)
    through = f", through the {places} [{'], ['.join(names)}]" if len(names) > 1 else ""
    return f"{'down' if way < 0 else 'up'}: {text}{through}"


def list_rows_along(step: Step, way: int) -> list[int]:
    """Return the rows of one direction in its order, with the row that it starts from."""
    return [int(i) for i in step.order[::way] if step.points["arclength"][i] * way >= 0]


def _list_signatures_along(step: Step, way: int) -> list[str]:
    """Return the signatures that a direction went through, in order; of equilibria their modes."""
    names: list[str] = []
    for i in list_rows_along(step, way):
        if step.kind_of(i) in ("", "EP"):
            name = find_signature(step, i)
            names += [name] if names[-1:] != [name] else []
    return names
