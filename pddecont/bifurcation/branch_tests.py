"""What is evaluated along a branch of orbits, or along a curve of special points."""

from __future__ import annotations

from functools import partial
from typing import Any

from pddecont.bifurcation.extended_system import ExtendedEvaluation
from pddecont.bifurcation.grazing import LABEL as GRAZING
from pddecont.bifurcation.motion_change import LABEL as MOTION_CHANGE
from pddecont.bifurcation.multiplier_counts import count_on_branch, count_on_curve
from pddecont.bifurcation.registry import find_kind, list_kinds
from pddecont.bifurcation.settings import BranchSettings
from pddecont.bifurcation.vanishing import LABEL as VANISHING
from pddecont.continuation import CurvePoint, TestFunctions
from pddecont.orbit import OrbitEvaluation, find_violation
from pddecont.reasons import NO_REASON, Reason


def make_branch_tests(at: OrbitEvaluation, settings: BranchSettings) -> TestFunctions[OrbitEvaluation]:
    """Return the test functions and counts of the branch of orbits that goes on from ``at``, as far as wanted."""
    tests = [test for kind in list_kinds() if settings.wants(kind.label) for test in kind.branch_tests(at, settings)]
    counts = count_on_branch(settings)
    kind = MOTION_CHANGE if settings.wants(MOTION_CHANGE) else ""
    find, find_first = (partial(_find_violation, settings=settings, strict=strict) for strict in (False, True))
    return TestFunctions(tests, counts, find, kind, find_first)


def make_curve_tests(at: ExtendedEvaluation, settings: BranchSettings) -> TestFunctions[ExtendedEvaluation]:
    """Return the test functions and counts of a curve of special points, as far as wanted."""
    tests = [test for kind in list_kinds() if settings.wants(kind.label) for test in kind.curve_tests(at, settings)]
    kind = find_kind(at.system.defining.kind)
    counts = None if kind is None else count_on_curve(kind, settings)
    return TestFunctions(tests, counts, depend_on_reference=True)


def make_tests(at: Any, settings: BranchSettings) -> TestFunctions[Any]:
    """Return what is evaluated along the branch or the curve that goes on from ``at``."""
    return make_curve_tests(at, settings) if isinstance(at, ExtendedEvaluation) else make_branch_tests(at, settings)


def _find_violation(point: CurvePoint[OrbitEvaluation], settings: BranchSettings, *, strict: bool) -> Reason:
    """Return why an orbit is no motion of the model: it crosses what it should not, or its simulation goes another way.

    Where none of the points that end signatures is looked for, it is no reason.
    """
    orbit = point.at.orbit
    if settings.wants(GRAZING) or settings.wants(VANISHING) or settings.wants(MOTION_CHANGE):
        return find_violation(orbit, settings.referee if settings.wants(MOTION_CHANGE) else None, strict=strict)
    return NO_REASON
