"""Guard points (GD): a condition that decides which mode follows an event begins or ceases to hold.

The test function is how far the condition is from changing in the states after the reset. Beyond the point the event
leads to another mode; the branch goes on there if what the motion does then joins.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pddecont.bifurcation.branch_start import StartError
from pddecont.bifurcation.extended_system import DefiningFunction, ExtendedEvaluation
from pddecont.bifurcation.kinds import CurveTest, OrbitTest, SpecialPointKind
from pddecont.bifurcation.settings import BranchSettings
from pddecont.continuation import BranchPoint, BranchState, CurvePoint, End, TestFunction
from pddecont.orbit import OrbitEvaluation, Signature, explain_guard, list_guarded, measure_guard, name_guard
from pddecont.reasons import Reason

LABEL = "GD"
# The code of reasons that name a condition.
CONDITION = "guard"


@dataclass(frozen=True)
class GuardFunction:
    """How far the condition of ``segment`` is from changing."""

    segment: int
    kind: str = LABEL

    def evaluate(self, at: OrbitEvaluation) -> float:
        """Return the distance, positive where the condition holds."""
        return measure_guard(at.orbit, self.segment)

    def update_at(self, at: OrbitEvaluation) -> GuardFunction:
        """Return the same function."""
        return self


def make_guard_test(signature: Signature, s: int, label: str) -> TestFunction[Any]:
    """Return the test of a condition, for points at which what changes with it has the label."""

    def value(point: CurvePoint[Any]) -> float:
        return measure_guard(point.at.orbit, s)

    def holds(point: CurvePoint[Any]) -> bool:
        return (name_guard(point.at.orbit, s) or LABEL) == label

    return TestFunction(label, value, End.SPECIAL, explain_guard(signature, s), holds=holds)


def _branch_tests(at: OrbitEvaluation, settings: BranchSettings) -> list[OrbitTest]:
    return [make_guard_test(at.orbit.signature, s, LABEL) for s in list_guarded(at.orbit.signature)]


def _curve_tests(at: ExtendedEvaluation, settings: BranchSettings) -> list[CurveTest]:
    """Return the tests for further conditions along a curve of special points."""
    defining = at.system.defining
    own = defining.segment if isinstance(defining, GuardFunction) else -1
    signature = at.orbit.signature
    return [make_guard_test(signature, s, LABEL) for s in list_guarded(signature) if s != own]


def _define(at: OrbitEvaluation, settings: BranchSettings, reason: Reason) -> DefiningFunction:
    number = int(reason.values.get("number", 0))
    if number - 1 not in list_guarded(at.orbit.signature):
        raise StartError("it is not recorded whose condition changes there; compute the branch again")
    return GuardFunction(number - 1)


def _good_side(defining: DefiningFunction) -> float:
    """Return that the orbit keeps its signature where the condition holds."""
    return 1.0


def _leave_to_motion(
    last: BranchPoint[OrbitEvaluation], state: BranchState[OrbitEvaluation], settings: BranchSettings
) -> CurvePoint[OrbitEvaluation] | None:
    """Return None: which segments follow in the other mode is what the motion says."""
    return None


GUARD = SpecialPointKind(
    LABEL,
    "guard",
    on_branches=True,
    on_curves=True,
    branch_tests=_branch_tests,
    curve_tests=_curve_tests,
    define=_define,
    good_side=_good_side,
    go_on=_leave_to_motion,
)
