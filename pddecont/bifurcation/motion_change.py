"""Motion change (MC): an orbit of its signature ceases to be a motion of the model.

Beyond such a point the equations of the signature still have a solution, but the model does something else: it slides
along a surface, an event happens that the signature does not list, or one that it lists does not. Most of these have
test functions: the rate at which the motion leaves a surface falls to zero; the time of a delayed event that did
nothing enters a mode that it ends; a jump that comes back begins, or ceases, to carry an event function over its zero;
both fields begin to point away from a surface that a jump puts the orbit on.
The orbit's simulation from its own past finds all others, and their points are located by halving the step.
"""

from __future__ import annotations

from pddecont.bifurcation.kinds import OrbitTest, SpecialPointKind
from pddecont.bifurcation.settings import BranchSettings
from pddecont.continuation import CurvePoint, End, TestFunction
from pddecont.orbit import (
    CarriedEvent,
    Clock,
    OrbitEvaluation,
    Repeller,
    Signature,
    explain_sliding,
    find_leaving_rate,
    list_carried_events,
    list_repellers,
    list_sliding_ends,
    list_unlisted_carried_events,
    list_unlisted_clocks,
)
from pddecont.reasons import Reason

LABEL = "MC"


def _branch_tests(at: OrbitEvaluation, settings: BranchSettings) -> list[OrbitTest]:
    """Return the tests for surfaces that hold a motion, and for events that begin or cease to happen."""
    orbit = at.orbit
    return [
        *(_test_leaving(orbit.signature, s) for s in list_sliding_ends(orbit.signature)),
        *(_test_event(clock, -1.0) for clock in list_unlisted_clocks(orbit)),
        *(_test_event(carried, 1.0) for carried in list_carried_events(orbit)),
        *(_test_event(carried, -1.0) for carried in list_unlisted_carried_events(orbit)),
        *(_test_event(repeller, 1.0) for repeller in list_repellers(orbit)),
    ]


def _test_leaving(signature: Signature, s: int) -> OrbitTest:
    """Return the test for the surface that segment ``s`` ends at."""

    def rate(point: CurvePoint[OrbitEvaluation]) -> float:
        return find_leaving_rate(point.at.orbit, s)

    return TestFunction(LABEL, rate, End.INVALID, explain_sliding(signature, s))


def _test_event(event: Clock | CarriedEvent | Repeller, sign: float) -> OrbitTest:
    """Return the test for an event, positive with ``sign`` 1 where it happens and -1 where it does not.

    A surface that repels counts as one that happens as long as the field beyond leads to it.
    """

    def measure(point: CurvePoint[OrbitEvaluation]) -> float:
        return sign * event.measure(point.at.orbit)

    def explain(point: CurvePoint[OrbitEvaluation]) -> Reason:
        return event.explain(point.at.orbit)

    return TestFunction(LABEL, measure, End.INVALID, explain=explain)


MOTION_CHANGE = SpecialPointKind(LABEL, "motion change", on_branches=True, branch_tests=_branch_tests)
