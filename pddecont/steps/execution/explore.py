"""Doing an ``explore`` step: it plans ordinary steps, one after another, and sees to it that they are done.

What is planned next depends on nothing but what the file holds, so that a run that was broken off goes on where it was.
"""

from __future__ import annotations

import contextlib
from typing import Any

import numpy as np

from pddecont.exploration import find_symmetries, fly_pilots, make_survey
from pddecont.results import EXPLORE, Step
from pddecont.runfile import PlannedStep
from pddecont.simulate import Method
from pddecont.steps.budget import OutOfTimeError
from pddecont.steps.context import Context
from pddecont.steps.execution.ending import report_done
from pddecont.steps.execution.explore_ahead import LeadsAhead
from pddecont.steps.execution.explore_curves import find_meetings
from pddecont.steps.execution.explore_leads import list_own_states
from pddecont.steps.execution.explore_pilots import choose_slice, list_pilots
from pddecont.steps.execution.explore_plane import explore_plane
from pddecont.steps.execution.explore_record import entry_to_row, look_to_row, make_ending, settled_to_row, torus_to_row
from pddecont.steps.execution.explore_under_way import Exploration
from pddecont.steps.explore import ExploreSettings


def run_explore(context: Context, step: PlannedStep[ExploreSettings], recorded: Step | None) -> None:
    """Explore, and record what came of it: a row a lead that was followed, a row a motion that was looked at."""
    if recorded is not None:
        context.drop_step(step.name)
    before = context.plan
    try:
        exploration = _begin(context, step)
        # The report says that the time was over, and of leads that they were left.
        with contextlib.suppress(OutOfTimeError), exploration.ahead.begin_as_places_get_free():
            exploration.explore()
            if len(step.settings.over) == 2:
                explore_plane(exploration)
    finally:
        context.plan = before
    _record(context, step, exploration)
    report_done(context, step)


def _begin(context: Context, step: PlannedStep[ExploreSettings]) -> Exploration:
    plan, settings = context.plan, step.settings
    states = [plan.model.states.index(name) for name in list_own_states(plan)]
    free = [plan.numeric.parameter_index(name) for name in settings.over]
    body = settings.body
    method = Method(body.rtol, body.atol, body.method == "stiff", dict(body.stick))
    at = choose_slice(plan, step)
    points = list(list_pilots(plan, step, at))
    pilots = fly_pilots(plan.numeric, step.delay, method, points, states)
    survey = make_survey(plan.numeric, pilots, free[:1], states)
    n_explorations = sum(other.kind == step.kind for other in plan.steps)
    prefix = f"{step.name}_" if n_explorations > 1 or len(plan.steps) > 1 else ""
    symmetries = find_symmetries(plan.numeric, np.array(points), survey.low, survey.high)
    own = {name: value for name, value in step.fields["set"].items() if name not in settings.over}
    ahead = LeadsAhead(context, prefix)
    return Exploration(context, settings, survey, symmetries, prefix, own, own | at, ahead)


def _record(context: Context, step: PlannedStep[ExploreSettings], exploration: Exploration) -> None:
    """Write what came of an exploration; one whose budget was spent is not done, and goes on when it is resumed."""
    # Those who listen hear of this step again, after those that it planned.
    context.reporter.step(step.name, step.kind)
    ending = make_ending(
        exploration.diagram, exploration.curve_entries, exploration.looks, exploration.stopped, exploration.number
    )
    meta: dict[str, Any] = {"free": list(step.settings.over), "directions": 2 if ending.values["stopped"] else 1}
    entries = [*exploration.diagram.entries, *exploration.curve_entries]
    meta["symmetries"] = [one.describe(context.plan.model.states) for one in exploration.symmetries[1:]]
    meta["meetings"] = [list(meeting.points) for meeting in find_meetings(exploration.curves)]
    rows = [entry_to_row(entry, context.plan) for entry in entries]
    states, number = context.plan.model.states, exploration.number
    rows += [look_to_row(look, exploration.diagram, number, states) for look in exploration.looks]
    rows += [torus_to_row(point, states) for point in exploration.tori]
    assert context.file is not None, "a run has a file"
    rows += [settled_to_row(look, context.file, states) for look in exploration.plane]
    with context.open_step(step, EXPLORE, meta, capacity=max(1, len(rows))) as writer:
        for points, reason in rows:
            writer.append(points, {}, reason)
        writer.terminate(ending)
