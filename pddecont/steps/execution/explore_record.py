"""What a results file keeps of an exploration: a row a lead, a row a motion that was compared with the branches."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pddecont.exploration import Place
from pddecont.reasons import Reason, Scalar, make_reason
from pddecont.results import Results
from pddecont.runfile import Plan
from pddecont.steps.execution.explore_diagram import Diagram, Entry
from pddecont.steps.execution.explore_looks import Look, LookCode
from pddecont.steps.execution.explore_tori import TorusPoint
from pddecont.tables import name_motion

# Labels of motions that lie on no branch: U1, U2, ...
KIND = "U"
# Labels that say nothing of what branches off or changes.
ENDS = "EP"
# The code of a row of what a torus has become.
ON_TORUS = "on_torus"
Row = tuple[dict[str, Any], Reason]


def entry_to_row(entry: Entry, plan: Plan) -> Row:
    """Return the row of a lead: where it is, and what became of it, with the branch in short."""
    motion, branch = entry.lead.motion, entry.branch
    parameters = np.full(len(plan.model.parameters), np.nan)
    values: dict[str, Scalar] = {"depth": entry.lead.depth}
    if branch is not None:
        step = branch.step
        parameters = step.points["parameters"][branch.rows[0]]
        labels = [step.labels[row] for row in branch.rows if step.labels[row] and step.kind_of(int(row)) != ENDS]
        values |= {
            "n_points": len(step),
            "low": float(np.min(branch.parameter)),
            "high": float(np.max(branch.parameter)),
            "n_stable": int(np.sum(step.points["stable"] == 1)),
            "special": " ".join(labels),
        }
        images = [one.describe(plan.model.states) for one in branch.list_images()]
        values |= {"images": "; ".join(images)} if images else {}
        if step.meta.get("curve"):
            values["curve"] = str(step.meta["curve"])
        for ending in step.endings:
            values["up" if ending.values.get("direction") == 1 else "down"] = ending.code
    points = {
        "kind": b"",
        "parameters": parameters,
        "period": motion.period,
        "lowest": motion.lowest,
        "highest": motion.highest,
        "lyapunov": np.nan,
        "lyapunov_error": np.nan,
    }
    return points, Reason(entry.reason.code, {**entry.reason.values, **values})


def look_to_row(look: Look, diagram: Diagram, number: int, states: Sequence[str]) -> Row:
    """Return the row of a motion: the branch that it lies on, or what it looks like; ``states`` are the model's."""
    place, n = find_place(look, diagram, number), len(states)
    found = place if place is not None and place.is_stable else None
    values: dict[str, Scalar] = {"sweep": look.sweep, "point": look.point, "look": str(look.code)}
    values |= {"detail": look.detail} if look.detail else {}
    motion = look.motion
    empty = np.full(n, np.nan)
    settles = motion is not None and look.code != LookCode.AWAY
    points = {
        "kind": KIND.encode() if found is None and settles else b"",
        "parameters": look.parameters,
        "period": np.nan if motion is None else motion.period,
        "lowest": empty if motion is None else motion.lowest,
        "highest": empty if motion is None else motion.highest,
        "lyapunov": look.exponent.value,
        "lyapunov_error": look.exponent.uncertainty,
    }
    if not settles:
        return points, make_reason("halted", **values)
    if place is not None:
        values |= {"branch": place.branch, "way": place.symmetry.describe(states)}
    if found is None:
        beside = {} if place is None else {"stable": "no" if place.is_stable is False else "unknown"}
        return points, make_reason("unexplained", **values, **beside)
    return points, make_reason("explained", **values)


def find_place(look: Look, diagram: Diagram, number: int) -> Place | None:
    """Return where on the branches a motion lies; None if it lies on none."""
    if look.motion is None or look.code not in (LookCode.PERIODIC, LookCode.REST):
        return None
    return diagram.find(look.motion, float(look.parameters[number]))


def find_explanation(look: Look, diagram: Diagram, number: int) -> Place | None:
    """Return where a motion lies on a branch that is stable there; None if it lies on none, or elsewhere.

    An attractor that lies on an unstable orbit is none of that branch, or the stability is wrong.
    """
    place = find_place(look, diagram, number)
    return place if place is not None and place.is_stable else None


def settled_to_row(look: Look, file: Results, states: Sequence[str]) -> Row:
    """Return the row of a motion at a place of the plane, with what it settles to in words of names and counts."""
    recorded = file.step(look.sweep)
    motion = name_motion(recorded, look.row) if look.can_start_orbit else str(look.code)
    points, reason = look_to_row(look, Diagram(), 0, states)
    values = {key: value for key, value in reason.values.items() if key not in ("branch", "way")}
    code = "halted" if reason.code == "halted" else "settled"
    return {**points, "kind": b""}, Reason(code, {**values, "motion": motion})


def torus_to_row(point: TorusPoint, states: Sequence[str]) -> Row:
    """Return the row of what a torus has become at a value of the parameter."""
    points, reason = look_to_row(point.look, Diagram(), 0, states)
    values = {**reason.values, "origin": point.origin}
    if point.rotation is not None:
        values |= {"rotation": point.rotation.value, "rotation_error": point.rotation.error}
    return {**points, "kind": b""}, Reason(ON_TORUS, values)


def make_ending(diagram: Diagram, curves: Sequence[Entry], looks: Sequence[Look], stopped: str, number: int) -> Reason:
    """Return how an exploration ended: what it counts, and what stopped it."""
    codes = [entry.reason.code for entry in diagram.entries]
    of_curves = [entry.reason.code for entry in curves]
    everything = [*diagram.entries, *curves]
    waiting = any(entry.reason.values.get("why") in ("time", "max_branches") for entry in everything)
    explained = [find_explanation(look, diagram, number) is not None for look in looks]
    settled = [look.motion is not None and look.code != LookCode.AWAY for look in looks]
    return make_reason(
        "explored",
        stopped=stopped if waiting or stopped == "time" else "",
        n_branches=codes.count("followed"),
        n_curves=of_curves.count("followed"),
        n_failed=[*codes, *of_curves].count("failed"),
        n_left=[*codes, *of_curves].count("left"),
        n_motions=sum(settled),
        n_explained=sum(explained),
        n_halted=len(looks) - sum(settled),
    )
