"""Sliding bifurcations: where pieces of an orbit begin to slide along a switching surface, or cease to.

CS crossing-sliding, GS grazing-sliding, SS switching-sliding, AS adding-sliding. Each is a condition that changes, a
grazing or a segment that vanishes, with a name of its own; it is defined and gone through as that.

Reference: di Bernardo, Budd, Champneys, Kowalczyk, Piecewise-smooth Dynamical Systems (2008), chapter 8.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, cast

from pddecont.bifurcation.extended_system import DefiningFunction
from pddecont.bifurcation.grazing import GRAZING, GrazingFunction, make_grazing_tests
from pddecont.bifurcation.guard import CONDITION, GUARD, GuardFunction, make_guard_test
from pddecont.bifurcation.kinds import OrbitTest, SpecialPointKind
from pddecont.bifurcation.settings import BranchSettings
from pddecont.bifurcation.vanishing import VANISHING
from pddecont.continuation import BranchPoint, BranchState, CurvePoint
from pddecont.orbit import OrbitEvaluation, list_guarded
from pddecont.reasons import Reason


def _find_nature(reason: Reason) -> SpecialPointKind:
    """Return the kind of point as which a sliding bifurcation was found, from what is recorded of it."""
    if reason.code == CONDITION:
        return GUARD
    return VANISHING if reason.code else GRAZING


def _good_side(defining: DefiningFunction) -> float | None:
    nature = GUARD if isinstance(defining, GuardFunction) else GRAZING
    return (nature if isinstance(defining, GuardFunction | GrazingFunction) else VANISHING).good_side(defining)


def _go_on(
    last: BranchPoint[OrbitEvaluation], state: BranchState[OrbitEvaluation], settings: BranchSettings
) -> CurvePoint[OrbitEvaluation] | None:
    go_on = _find_nature(last.reason).go_on
    assert go_on is not None
    return go_on(last, state, settings)


def _make_kind(label: str, name: str, *, is_guard: bool, is_grazing: bool) -> SpecialPointKind:
    def branch_tests(at: OrbitEvaluation, settings: BranchSettings) -> list[OrbitTest]:
        if at.orbit.numeric.model.derived is None:
            return []
        signature = at.orbit.signature
        guards = [make_guard_test(signature, s, label) for s in list_guarded(signature)] if is_guard else []
        return guards + (make_grazing_tests(at, label) if is_grazing else [])

    def define(at: OrbitEvaluation, settings: BranchSettings, reason: Reason) -> DefiningFunction:
        natural = _find_nature(reason).define
        assert natural is not None
        return cast(DefiningFunction, replace(cast(Any, natural(at, settings, reason)), kind=label))

    return SpecialPointKind(
        label, name, on_branches=True, branch_tests=branch_tests, define=define, good_side=_good_side, go_on=_go_on
    )


SLIDING = (
    _make_kind("CS", "crossing-sliding", is_guard=True, is_grazing=False),
    _make_kind("GS", "grazing-sliding", is_guard=False, is_grazing=True),
    _make_kind("SS", "switching-sliding", is_guard=True, is_grazing=False),
    _make_kind("AS", "adding-sliding", is_guard=False, is_grazing=True),
)
