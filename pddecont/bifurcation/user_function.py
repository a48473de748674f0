"""User functions (UF): an expression over monitors that is zero."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pddecont.bifurcation.branch_start import StartError
from pddecont.bifurcation.extended_system import DefiningFunction, ExtendedEvaluation
from pddecont.bifurcation.kinds import CurveTest, OrbitTest, SpecialPointKind
from pddecont.bifurcation.settings import BranchSettings
from pddecont.continuation import CurvePoint, TestFunction
from pddecont.orbit import Monitor, OrbitEvaluation
from pddecont.reasons import Reason, make_reason

LABEL = "UF"
CODE = "user_function"


@dataclass(frozen=True, eq=False)
class UserFunction:
    """A monitor as a defining function."""

    monitor: Monitor
    kind: str = LABEL

    def evaluate(self, at: OrbitEvaluation) -> float:
        """Return the monitor at an orbit."""
        return self.monitor.evaluate(at.orbit)

    def update_at(self, at: OrbitEvaluation) -> UserFunction:
        """Return the same function."""
        return self


def _make_test(monitor: Monitor) -> TestFunction[Any]:
    def value(point: CurvePoint[Any]) -> float:
        return monitor.evaluate(point.at.orbit)

    return TestFunction(LABEL, value, reason=make_reason(CODE, name=monitor.name))


def _branch_tests(at: OrbitEvaluation, settings: BranchSettings) -> list[OrbitTest]:
    return [_make_test(m) for m in settings.user_functions]


def _curve_tests(at: ExtendedEvaluation, settings: BranchSettings) -> list[CurveTest]:
    own = at.system.defining.monitor.name if isinstance(at.system.defining, UserFunction) else ""
    return [_make_test(m) for m in settings.user_functions if m.name != own]


def _define(at: OrbitEvaluation, settings: BranchSettings, reason: Reason) -> DefiningFunction:
    name = reason.values.get("name", "")
    monitor = next((m for m in settings.user_functions if m.name == name), None)
    if monitor is None:
        raise StartError(f"it starts where the user function '{name}' is zero; give it in 'events_along' here too")
    return UserFunction(monitor)


USER_FUNCTION = SpecialPointKind(
    LABEL,
    "user function",
    on_branches=True,
    on_curves=True,
    branch_tests=_branch_tests,
    curve_tests=_curve_tests,
    define=_define,
)
