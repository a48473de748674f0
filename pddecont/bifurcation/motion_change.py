"""Motion change (MC): an orbit of its signature ceases to be a motion of the model.

Beyond such a point the equations of the signature still have a solution, but the model does something else: it slides
along a surface, an event happens that the signature does not list, or one that it lists does not. Two of these have
test functions: the rate at which the motion leaves a surface falls to zero, and the time of a delayed event that did
nothing enters a mode that it ends. The orbit's simulation from its own past finds all others, and their points are
located by halving the step.
"""

from __future__ import annotations

from collections.abc import Callable

from pddecont.bifurcation.kinds import OrbitTest, SpecialPointKind
from pddecont.bifurcation.settings import BranchSettings
from pddecont.continuation import CurvePoint, End, TestFunction
from pddecont.orbit import (
    Clock,
    OrbitEvaluation,
    explain_sliding,
    find_leaving_rate,
    list_sliding_ends,
    list_unlisted_clocks,
)
from pddecont.reasons import Reason

LABEL = "MC"


def _branch_tests(at: OrbitEvaluation, settings: BranchSettings) -> list[OrbitTest]:
    """Return the tests for surfaces that a motion no longer leaves and for delayed events that begin to happen."""
    signature = at.orbit.signature
    tests: list[OrbitTest] = [
        TestFunction(LABEL, _leaving_rate_of(s), End.INVALID, explain_sliding(signature, s))
        for s in list_sliding_ends(signature)
    ]
    for clock in list_unlisted_clocks(at.orbit):
        tests.append(TestFunction(LABEL, _time_of(clock), End.INVALID, explain=_explanation_of(clock)))
    return tests


def _leaving_rate_of(s: int) -> Callable[[CurvePoint[OrbitEvaluation]], float]:
    return lambda point: find_leaving_rate(point.at.orbit, s)


def _time_of(clock: Clock) -> Callable[[CurvePoint[OrbitEvaluation]], float]:
    return lambda point: -clock.measure(point.at.orbit)


def _explanation_of(clock: Clock) -> Callable[[CurvePoint[OrbitEvaluation]], Reason]:
    return lambda point: clock.explain(point.at.orbit)


MOTION_CHANGE = SpecialPointKind(LABEL, "motion change", on_branches=True, branch_tests=_branch_tests)
