"""Doing a ``continue`` step that starts from an equilibrium: a branch of equilibria in one free parameter."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pddecont.continuation import BranchPoint, BranchState, CurvePoint, Home, StepSettings, follow_branch
from pddecont.equilibrium import (
    BOUNDARY,
    CURVE_NAMES,
    NAMES,
    BoundaryCondition,
    CriticalEvaluation,
    EquilibriumCurve,
    EquilibriumEvaluation,
    LagBoundary,
    WayOn,
    find_better_side,
    find_curve_values,
    find_special_values,
    find_way_on,
    make_curve_tests,
    make_tests,
    remove_critical,
)
from pddecont.memo import cached_property
from pddecont.orbit import DelayBoundary, RangeBoundary
from pddecont.reasons import Reason
from pddecont.results import EQUILIBRIA, RowWriter, Step
from pddecont.runfile import PlannedStep
from pddecont.steps.context import Context
from pddecont.steps.continuation import ContinueSettings
from pddecont.steps.execution.apart import follow_directions
from pddecont.steps.execution.branch_progress import RangeCovered
from pddecont.steps.execution.directions import find_unfinished, make_branch_ending
from pddecont.steps.execution.ending import report_done
from pddecont.steps.execution.equilibrium_branch_start import find_curve_reason, find_start
from pddecont.steps.execution.equilibrium_rows import add_doubts, equilibrium_to_row, make_equilibrium_meta

# How far ahead of its first point a branch sets out, in scaled unknowns, to be known again by its direction.
AHEAD = 1e-3
# Modes that one direction goes through at most.
MAX_MODES = 100


@dataclass(eq=False)
class _Branch:
    """A branch on its way into the results file."""

    context: Context
    step: PlannedStep[ContinueSettings]
    writer: RowWriter
    first: BranchState[Any]
    last: BranchPoint[Any] | None = None
    way_on: WayOn | None = None

    @cached_property
    def covered(self) -> RangeCovered:
        """What it has covered of its range."""
        return RangeCovered(self.step.settings.free, self.step.settings.ranges)

    def record(self, point: BranchPoint[Any]) -> None:
        """Write a point to the file."""
        state, at = point.state, point.state.point.at
        curve, roots = "", at.roots
        if isinstance(at, CriticalEvaluation):
            special, curve, roots = find_curve_values(point), at.system.critical.label, at.all_roots
        else:
            special = find_special_values(point, self.step.settings.free[0], state.point.system.scaling.scale[-1])
        reason = special.reason
        if point.kind == BOUNDARY and not isinstance(at, CriticalEvaluation):
            self.way_on = find_way_on(state.point, str(point.reason.values["event"]))
            reason = Reason(reason.code, {**reason.values, "nature": self.way_on.nature if self.way_on else ""})
        points, rows = equilibrium_to_row(
            at.equilibrium,
            roots,
            list(self.context.plan.monitors.values()),
            unknowns=at.x,
            kind=point.kind,
            arclength=state.arclength,
            step=state.step,
            tangent=state.tangent,
            n_iterations=point.n_iterations,
            error=_measure_error(state.point),
            frequency=special.frequency,
            coefficient=special.coefficient,
            n_unexplained=point.n_unexplained,
            side=find_better_side(at) if isinstance(at, CriticalEvaluation) else None,
            on_surface=_find_surface(point),
            others=remove_critical(at.roots, curve, point.kind),
        )
        self.writer.append(points, rows, add_doubts(reason, at.equilibrium, roots))
        self.last = point
        values = at.x[-len(self.step.settings.free) :]
        self.context.reporter.progress(*self.covered.describe(self.writer.n, values, point.kind))
        if not point.kind:
            self.context.budget.check()

    def follow(self, state: BranchState[Any], way: int, *, has_passed: bool = False) -> Reason:
        """Follow one direction through all its modes; return how it ended.

        ``has_passed`` says whether it has come through boundary equilibria already, from where it does not come home.
        """
        steps = self.step.settings
        settings = StepSettings(steps.step_initial, steps.step_min, steps.step_max, steps.max_points)
        home = None if has_passed else _make_home(replace(self.first, point=_turn(self.first.point, way)))
        for _ in range(MAX_MODES):
            at = state.point.at
            on_curve = isinstance(at, CriticalEvaluation)
            problem = at.system.problem if on_curve else at.problem
            delays = DelayBoundary(problem.motion.numeric, problem.parameters, problem.free)
            boundaries = (RangeBoundary(steps.free, steps.ranges), delays, LagBoundary(problem))
            functions = make_curve_tests(at, steps.detect) if on_curve else make_tests(at, steps.detect)
            self.way_on = None
            end = follow_branch(state, boundaries, functions, settings, self.record, way, home)
            if self.way_on is None or self.last is None or not steps.follows_signatures:
                break
            # A mode may be short-lived: begin it as a branch is begun.
            state = replace(
                self.last.state,
                point=self.way_on.point,
                step=min(self.last.state.step, steps.step_initial),
                is_start=True,
            )
            home = None
        return make_branch_ending(end, way)


def run_equilibrium_branch(context: Context, step: PlannedStep[ContinueSettings], recorded: Step | None) -> None:
    """Follow a branch of equilibria in each direction asked for, from the start or from where ``recorded`` stopped."""
    settings = step.settings
    begun = find_start(context, step)
    start = begun.point
    first = BranchState(start, 0.0, settings.step_initial, 1)
    states, kept = {way: replace(first, point=_turn(start, way)) for way in settings.ways}, 0
    endings: dict[int, Reason] = {}
    passed: set[int] = set()
    if recorded is not None and len(recorded):
        endings = {int(ending.values.get("direction", 0)): ending for ending in recorded.endings}
        way, row, kept = find_unfinished(recorded, settings.ways, endings)
        if row is not None:
            states[way] = _restore(start, recorded, row)
            passed = {way} if _has_passed(recorded, row) else passed
    meta: dict[str, Any] = {
        **make_equilibrium_meta(context.plan, step, {**NAMES, **CURVE_NAMES}),
        "free": list(settings.free),
        "directions": len(settings.ways),
        "curve": start.at.system.critical.label if isinstance(start.at, CriticalEvaluation) else "",
        "curve_reason": find_curve_reason(start),
    }
    with context.open_step(step, EQUILIBRIA, meta, recorded=recorded, kept=kept, at_once=not kept) as writer:
        branch = _Branch(context, step, writer, first)

        def follow_here(way: int) -> Reason:
            return branch.follow(states[way], way, has_passed=way in passed)

        if writer.n == 0:
            branch.record(BranchPoint(first, begun.kind, 0, reason=begun.reason))
        follow_directions(context, step, writer, settings.ways, endings, follow_here, follow_direction)
    report_done(context, step)


def follow_direction(context: Context, step: PlannedStep[ContinueSettings], writer: RowWriter, way: int) -> Reason:
    """Follow one direction of a branch of equilibria from its start; return how it ended."""
    start = find_start(context, step).point
    first = BranchState(start, 0.0, step.settings.step_initial, 1)
    return _Branch(context, step, writer, first).follow(replace(first, point=_turn(start, way)), way)


def _find_surface(point: BranchPoint[Any]) -> str:
    """Return the event on whose surface a point lies by its definition."""
    at = point.state.point.at
    if isinstance(at, CriticalEvaluation):
        critical = at.system.critical
        return critical.event if isinstance(critical, BoundaryCondition) else ""
    return str(point.reason.values["event"]) if point.kind == BOUNDARY else ""


def _measure_error(point: CurvePoint[Any]) -> float:
    """Return the largest error of an unknown relative to its size, as one more Newton step would change it."""
    least = float(np.finfo(float).eps)
    if point.solution is None:
        return least
    step = point.solution.solve(np.append(-point.at.residual, 0.0)) / point.system.scaling.scale
    return max(least, float(np.max(np.abs(step))))


def _turn(point: CurvePoint[Any], way: int) -> CurvePoint[Any]:
    return replace(point, direction=way * point.tangent)


def _make_home(start: BranchState[Any]) -> Home[Any]:
    """Return how the first equilibrium of a branch is known again."""
    ahead = start.x + AHEAD * start.tangent
    return Home(lambda at: [start.x], lambda at: [ahead], lambda at: float(np.finfo(float).eps))


def _restore(start: CurvePoint[Any], recorded: Step, row: int) -> BranchState[Any]:
    """Return the state that a recorded point left, in its mode."""
    rows, points = recorded.orbit(row), recorded.points
    arclength, way = float(points["arclength"][row]), np.sign(points["arclength"][row])
    before = (points["arclength"][: row + 1] * way > 0) & (points["kind"][: row + 1] == b"")
    system = start.system
    if isinstance(start.at, EquilibriumEvaluation):
        assert isinstance(system, EquilibriumCurve), "it has no mesh"
        system = EquilibriumCurve(system.inner.enter(rows["signature"].tobytes().decode()))
    point = replace(start, system=system, at=system.at(np.array(rows["unknowns"])), direction=np.array(rows["tangent"]))
    return BranchState(point, arclength, float(points["step"][row]), int(np.sum(before)) + 1, is_start=False)


def _has_passed(recorded: Step, row: int) -> bool:
    """Return whether a recorded branch has come to a point through boundary equilibria."""
    points, way = recorded.points, np.sign(recorded.points["arclength"][row])
    passed = (points["arclength"][:row] * way > 0) & (points["kind"][:row] == BOUNDARY.encode())
    return bool(np.any(passed))
