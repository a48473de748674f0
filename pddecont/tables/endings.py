"""How steps ended, in a sentence each, with advice."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from pddecont.errors import ResultsError
from pddecont.reasons import Reason
from pddecont.results import Step
from pddecont.tables.attractors import estimate_shares, find_attractors, name_motion
from pddecont.tables.branch_endings import describe_direction, list_rows_along
from pddecont.tables.equilibria import holds_equilibria, list_doubts
from pddecont.tables.equilibrium_branch_endings import UNSTATED_ROOTS, describe_equilibrium_branch
from pddecont.tables.equilibrium_endings import describe_equilibrium_step
from pddecont.tables.exploration import describe_exploration
from pddecont.tables.orbits import find_signature
from pddecont.tables.precision import describe_cheapest, describe_reference
from pddecont.tables.words import describe_reason

# Orbits whose estimated error is above this are poor.
POOR = 1e-3
# A trivial multiplier farther from 1 than this says that the mesh is too coarse.
TRIVIAL_ERROR = 1e-4
UNRELIABLE = (
    "the multipliers are lost among those of this delay line's own stages, which are far shorter than mesh intervals: "
    "use more intervals, a lower 'n' or order, or the direct method"
)
UNCOUNTED = (
    "the count of multipliers outside the unit circle does not confirm those that were found, and whether the orbit is "
    "stable is not known: use a finer mesh, or parameters a little apart"
)
NEUTRAL = "no multiplier outside the unit circle but at least one on it: they do not tell whether the orbit is stable"
# Of many points, any of them.
UNSTATED = (
    "the multipliers do not tell whether the orbit is stable: one lies on the unit circle, a count does not confirm "
    "them, or they are lost among those of a delay line's own stages; use a finer mesh, or parameters a little apart"
)


def describe_endings(step: Step) -> list[str]:
    """Return how each direction of a step ended, in order."""
    return [describe_ending(step, ending) for ending in step.endings]


def describe_ending(step: Step, ending: Reason) -> str:
    """Return how a step, or one of its directions, ended.

    Raises
    ------
    ResultsError
        If what belongs to it is not there.
    """
    if ending.code == "text":
        return describe_reason(ending)
    describe = _BY_KIND.get(step.kind)
    try:
        return describe_reason(ending) if describe is None else describe(step, ending)
    except (KeyError, IndexError, TypeError, ValueError, OverflowError) as exc:
        raise ResultsError(f"how step '{step.name}' ended is not recorded whole; the file is damaged") from exc


def register_ending(kind: str, describe: Callable[[Step, Reason], str]) -> None:
    """Give words to how steps of a kind end."""
    _BY_KIND[kind] = describe


def forget_ending(kind: str) -> None:
    """Forget words that :func:`register_ending` gave."""
    _BY_KIND.pop(kind, None)


def _describe_continue(step: Step, ending: Reason) -> str:
    last, after = _last_reason(step, int(ending.values["direction"])), ""
    if "next_signature" in ending.values:
        after = f"; the orbit of the next signature was not found: {ending.values['next_signature']}"
    elif last.code == "meeting":
        after = f": {describe_reason(last)}; beyond, they happen in another order: start anew from a simulation there"
    elif last.code == "released":
        after = (
            f": {describe_reason(last)}; beyond, the motion is released before it rests, after more and more impacts "
            "towards this point: start anew from a simulation there"
        )
    return describe_direction(step, ending, "signatures") + after


def _last_reason(step: Step, way: int) -> Reason:
    rows = list_rows_along(step, way)
    return step.reason(rows[-1]) if rows else Reason()


def _describe_orbit(step: Step, ending: Reason) -> str:
    p, v = step.points, ending.values
    text = (
        f"converged in {p['n_iterations'][0]} Newton iterations to signature [{find_signature(step, 0)}], "
        f"period {p['period'][0]:.10g}"
    )
    if p["error_estimate"][0] > POOR:
        text += (
            f"; WARNING: its estimated error is {p['error_estimate'][0]:.1e}: refine 'mesh', and with a chain of order "
            "3 or more lower 'n' (it magnifies rounding errors)"
        )
    if v.get("multipliers"):
        text += f"; {_describe_stability(step, v)}"
        if v.get("jump_returns_at_event"):
            text += (
                "; WARNING: a jump of the state comes back through a delay just at an event: nearby motions read it "
                "before or after, and have other multipliers on either side"
            )
    if v.get("detail"):
        detail = Reason(str(v["detail"]), v)
        text += f"; WARNING: no motion of the model, not admissible: {describe_reason(detail)}"
    elif v.get("not_verified"):
        text += f"; WARNING: not verified by a simulation ({str(v['not_verified']).replace('_', ' ')})"
    return text


def _describe_stability(step: Step, values: Mapping[str, Any]) -> str:
    """Return stability in words, with a warning where the trivial multiplier is far from 1."""
    n_unstable, error = int(step.points["n_unstable"][0]), float(step.points["trivial_error"][0])
    if n_unstable < 0:
        return f"WARNING: {UNCOUNTED if values.get('uncounted') else UNRELIABLE}"
    leading = [(values[f"re{k}"], values[f"im{k}"]) for k in (1, 2) if f"re{k}" in values]
    shown = ", ".join(f"{re:.6g}" if im == 0.0 else f"{re:.6g} {im:+.6g}i" for re, im in leading)
    stable = f"unstable ({n_unstable} multipliers outside the unit circle)" if n_unstable else "stable"
    if not n_unstable and step.points["stable"][0] != 1:
        stable = NEUTRAL if step.points["stable"][0] < 0 else "no multiplier outside the unit circle"
    text = f"{stable}, leading {shown or 'none'}"
    if np.isfinite(error):
        text += f", trivial multiplier off by {error:.1e}"
        if error > TRIVIAL_ERROR:
            text += " (WARNING: refine 'mesh', the multipliers are no better than that)"
    return text


def _describe_simulate(step: Step, ending: Reason) -> str:
    p, since = step.points, float(ending.values.get("since", 0.0))
    when = f" since t = {since:.10g}" if since else ""
    return f"reached t = {p['t_end'][0]:.10g} in {p['n_steps'][0]} steps with {p['n_events'][0]} events{when}"


def _describe_sweep(step: Step, ending: Reason) -> str:
    kinds = Counter(
        "failed" if not step.labels[i] else "periodic" if step.points["period"][i] else "without period"
        for i in range(len(step))
    )
    found = ", ".join(f"{n} {what}" for what, n in sorted(kinds.items()))
    return f"{ending.values['n_cells']} parameter points; attractors: {found}"


def _describe_basin(step: Step, ending: Reason) -> str:
    rows, shares, parts = find_attractors(step), estimate_shares(step), []
    for row in rows:
        share, low, high = shares[int(row)]
        percent = f"{100 * share:.2f} % ({100 * low:.2f} to {100 * high:.2f})"
        name = step.labels[row] or "none"
        what = name_motion(step, int(row)) if step.labels[row] else describe_reason(step.reason(int(row)))
        parts.append(f"{name} ({what}): {percent}")
    return f"{len(step.meta['x']) * len(step.meta['y'])} initial states; {'; '.join(parts)}"


def _describe_precision(step: Step, ending: Reason) -> str:
    return f"{len(step) - 1} settings against {describe_reference(step)}"


def count_unknown(step: Step, column: str) -> int:
    """Return at how many points ``stable`` or ``verified`` is unknown though it was asked for, as of equilibria."""
    is_asked = column in step.meta.get("asked", ()) or (column == "stable" and holds_equilibria(step))
    return int(np.sum(step.points[column] < 0)) if is_asked else 0


def describe_unstated(step: Step, number: int) -> str:
    """Return why it is not known whether so many points are stable."""
    return f"at {number} of the points {UNSTATED_ROOTS if holds_equilibria(step) else UNSTATED}"


def list_warnings(step: Step) -> list[str]:
    """Return what is not known, or wrong, at points of a branch."""
    unstated, undone = count_unknown(step, "stable"), count_unknown(step, "verified")
    wrong = int(np.sum(step.points["verified"] == 0)) if "verified" in step.points else 0
    found = [f"{wrong} of its orbits are no motions of the model: see the column 'verified'"] if wrong else []
    found += [f"{undone} of its orbits could not be verified by a simulation"] if undone else []
    found += list_doubts(step) if holds_equilibria(step) else []
    return found + ([describe_unstated(step, unstated)] if unstated else [])


def describe_done(step: Step) -> str:
    """Return what a step that is done came to, in one line."""
    texts = describe_endings(step)
    if step.kind in ("continue", "equilibria"):
        return _summarise_branch(step, texts)
    if step.kind == "precision":
        return f"{texts[0]}; cheapest for {describe_cheapest(step)[1]}"
    return "; ".join(texts)


def _summarise_branch(step: Step, texts: Sequence[str]) -> str:
    errors = step.points.get("trivial_error", np.empty(0))
    poor = bool(np.any(errors > TRIVIAL_ERROR))
    doubt = f"; WARNING: the trivial multiplier is off by up to {np.nanmax(errors):.1e}: refine 'mesh'" if poor else ""
    doubt += "".join(f"; WARNING: {warning}" for warning in list_warnings(step))
    special = ", ".join(sorted(label for label in step.labels if label)) or "none"
    return f"{len(step)} points; special: {special}; {'; '.join(texts)}{doubt}"


_BY_KIND: dict[str, Callable[[Step, Reason], str]] = {
    "continue": _describe_continue,
    "equilibria": describe_equilibrium_branch,
    "equilibrium": describe_equilibrium_step,
    "orbit": _describe_orbit,
    "simulate": _describe_simulate,
    "sweep": _describe_sweep,
    "basin": _describe_basin,
    "precision": _describe_precision,
    "explore": describe_exploration,
}
