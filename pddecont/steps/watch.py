"""What a ``continue`` step watches along its branch."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pddecont.bifurcation import codim2, grazing, period_doubling, tangency, user
from pddecont.bifurcation.census import branch_census
from pddecont.bifurcation.conditioned import SpecialCurve
from pddecont.continuation.branch import State
from pddecont.continuation.locate import Located
from pddecont.continuation.special import TestFunction, Watch
from pddecont.orbit.admissibility import objections, watched_events
from pddecont.orbit.monitors import Monitor
from pddecont.stability.multipliers import Known
from pddecont.steps.start import Task


def watch_of(task: Task, state: State) -> Watch:
    """Return the test functions and the census of the branch that goes on from ``state``, as far as the step asks for them.

    Where neither grazings nor vanishing segments are, orbits that cross what they should not are no reason to stop either.
    """
    asks = task.asks
    users = [TestFunction(user.KIND, _monitor(m), note=m.name) for m in task.users] if asks(user.KIND) else []
    if isinstance(state.problem, SpecialCurve):
        watch = codim2.watch_curve(state.problem, task.known, asks)
        kind = state.problem.condition.kind
        return Watch([*watch.tests, *(u for u in users if kind != user.KIND or u.note != followed(state.problem))], watch.census)
    tests = [
        *(_grazings(state) if asks(grazing.KIND) else ()),
        *(_vanishings(state) if asks(tangency.KIND) else ()),
        *(_collapse(task, state) if asks(period_doubling.KIND) else ()),
        *users,
    ]
    watch = Watch(tests, branch_census(task.known, asks))
    return replace(watch, objection=_not_admissible) if asks(grazing.KIND) or asks(tangency.KIND) else watch


def _not_admissible(at: Located) -> str:
    return next(iter(objections(at.problem.problem, at.x)), "")


def _vanishings(state: State) -> list[TestFunction]:
    """Return the tests for events that are only touched, and for events that meet."""
    rate = TestFunction(tangency.KIND, lambda at: tangency.crossing_rate(at.problem.problem, at.x), stops=True,
                        note="event turns tangential")  # fmt: skip
    return [rate, *_meetings(state)]


def _grazings(state: State) -> list[TestFunction]:
    """Return the test of each segment and event that it watches."""
    problem = state.problem.problem

    def value(s: int, event: str) -> Callable[[Located], float]:
        return lambda at: grazing.height(at.problem.problem, at.x, s, event)

    pairs = dict.fromkeys((s, event) for s in range(len(problem.segments)) for event, _, _ in watched_events(problem, s))
    return [TestFunction(grazing.KIND, value(*pair), stops=True) for pair in pairs]


def _meetings(state: State) -> list[TestFunction]:
    """Return the tests for events that come in where a segment begins or ends."""
    segments = state.problem.problem.segments

    def value(meeting: tangency.Meeting) -> Callable[[Located], float]:
        return lambda at: meeting.at(at.problem.problem, at.x)

    found = tangency.meetings(state.problem.problem)
    there = [segments[m.s if m.at_end else m.s - 1].event for m in found]
    return [TestFunction(tangency.KIND, value(m), stops=True, note=f"{other}{tangency.MEETS}{m.event}")
            for m, other in zip(found, there, strict=True)]  # fmt: skip


def _monitor(monitor: Monitor) -> Callable[[Located], float]:
    return lambda at: monitor.value(at.problem.problem, at.x)


def followed(special: SpecialCurve) -> str:
    """Return the name of the user function that a curve keeps at zero (empty for other curves)."""
    return special.condition.monitor.name if isinstance(special.condition, user.UserFunction) else ""


def _collapse(task: Task, state: State) -> list[TestFunction]:
    """Return the test for a doubled orbit that falls onto the single one: what differs most between its halves changes sign."""
    rule = task.context.rule_of(task.step)
    difference = period_doubling.halves(state.problem.problem, state.x, state.problem.metric())
    if not len(difference) or not np.any(difference):
        return []
    most = int(np.argmax(np.abs(difference)))

    def value(at: Located) -> float:
        # Near the single orbit a step may land on it: no difference is left, and no sign of it can be trusted.
        if period_doubling.equal_halves(at.problem.problem, at.x, at.problem.metric()):
            return 0.0
        return float(period_doubling.halves(at.problem.problem, at.x, at.problem.metric())[most])

    def meeting(a: Located, b: Located) -> Located | None:
        return period_doubling.collapsed(a, b, rule, task.known or Known())

    return [TestFunction(period_doubling.KIND, value, True, "halves become equal", meeting=meeting)]
