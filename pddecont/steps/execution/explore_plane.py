"""An exploration in the plane of two parameters: curves of special points, and what motions settle to between them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.reasons import make_reason
from pddecont.steps.budget import OutOfTimeError
from pddecont.steps.execution.explore_ahead import may_be_one_curve
from pddecont.steps.execution.explore_curves import (
    MEETING,
    list_curve_leads,
    list_meeting_leads,
    plan_curve,
    read_curve,
)
from pddecont.steps.execution.explore_diagram import Entry
from pddecont.steps.execution.explore_leads import Lead, plan_sweep
from pddecont.steps.execution.explore_looks import look_at_sweep
from pddecont.steps.execution.explore_under_way import Exploration
from pddecont.tables import find_signature

Array = NDArray[np.float64]
# A special point, its place in the plane in parts of the ranges (2,), and whether its curve is asked for by a switch.
PlaneLead = tuple[Lead, Array, bool]


def explore_plane(exploration: Exploration) -> None:
    """Do all that there is to do in two parameters when all is done in one."""
    _follow_curves(exploration)
    if exploration.settings.body.check and exploration.stopped != "time":
        _look_at_plane(exploration)


def _follow_curves(exploration: Exploration) -> None:
    """Follow special points of all branches in two parameters, and what goes on where curves meet."""
    waiting: list[PlaneLead] = [
        (lead, place, False)
        for entry in exploration.diagram.entries
        if entry.branch is not None
        for lead, place in list_curve_leads(entry.branch, exploration.settings, entry.lead.depth)
    ]
    waiting.sort(key=lambda one: one[0].depth)
    while waiting:
        lead, place, switch = waiting.pop(0)
        if _is_followed(exploration, lead, place):
            exploration.ahead.forget(lead)
            continue
        if exploration.stopped:
            left = make_reason("left", origin=lead.origin, why=exploration.stopped)
            exploration.curve_entries.append(Entry(lead, left))
            continue
        _offer(exploration, lead, waiting)
        waiting += _follow_curve(exploration, lead, switch)


def _look_at_plane(exploration: Exploration) -> None:
    """See what motions settle to at random places of the plane."""
    settings, body = exploration.settings, exploration.settings.body
    name, number = f"{exploration.prefix}plane", 2 * body.check
    recorded = exploration.do(
        plan_sweep(exploration.plan, settings, exploration.survey, name, exploration.own, number, body.seed + 2)
    )
    exploration.plane = look_at_sweep(exploration.plan, recorded, exploration.survey)


def _is_followed(exploration: Exploration, lead: Lead, place: Array) -> bool:
    """Return whether the curve of a special point, or of its image by a symmetry, is there."""
    if lead.label in MEETING:
        return any(curve.step.name != lead.step and curve.passes(place) for curve in exploration.curves)
    images = [lead.motion.apply(symmetry) for symmetry in exploration.symmetries]
    found_on = next((curve for curve in exploration.curves if curve.step.name == lead.step), None)
    others = [curve for curve in exploration.curves if curve.kind == lead.label and curve is not found_on]
    if found_on is not None and found_on.kind == lead.label:
        # Where two curves of one kind meet, those of other orbits end, which run through what begins there.
        through = find_signature(found_on.step, found_on.step.labels.index(lead.point))
        others = [curve for curve in others if find_signature(curve.step, int(curve.rows[0])) == through]
    return any(curve.holds(image, place, exploration.scale) for curve in others for image in images)


def _offer(exploration: Exploration, lead: Lead, waiting: Sequence[PlaneLead]) -> None:
    """Say which special points may be followed elsewhere while one is here."""
    switches = {one: switch for one, _, switch in waiting}
    unknown = (one for one, place, _ in waiting if not _is_followed(exploration, one, place))

    def plan_steps(one: Lead, name: str) -> list[dict[str, Any]]:
        return [plan_curve(exploration.settings, one, f"{name}_curve", switch=switches[one])]

    exploration.ahead.offer(lead, unknown, may_be_one_curve, plan_steps)


def _follow_curve(exploration: Exploration, lead: Lead, switch: bool) -> Iterator[PlaneLead]:
    """Follow a special point in two parameters; return what goes on from its curve."""
    exploration.n_begun += 1
    name = f"{exploration.prefix}curve_{exploration.n_begun}"
    fields = plan_curve(exploration.settings, lead, name, switch=switch)
    try:
        recorded = exploration.try_to_do(fields, exploration.ahead.take(lead, [fields]).get(name))
    except OutOfTimeError:
        left = make_reason("left", origin=lead.origin, why=exploration.stopped)
        exploration.curve_entries.append(Entry(lead, left))
        return iter(())
    if recorded is None:
        failed = make_reason("failed", step=name, origin=lead.origin, why=exploration.failures[-1])
        exploration.curve_entries.append(Entry(lead, failed))
        return iter(())
    branch = exploration.read_branch(recorded)
    curve = read_curve(branch, exploration.settings)
    exploration.curves.append(curve)
    followed = make_reason("followed", step=name, origin=lead.origin)
    exploration.curve_entries.append(Entry(lead, followed, branch))
    return list_meeting_leads(curve, branch)
