"""Doing a ``continue`` step."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from pddecont.bifurcation import (
    BranchSettings,
    BranchStart,
    ExtendedEvaluation,
    define_special_point,
    extend_system,
    find_good_side,
    find_kind,
    make_tests,
    switch_signature,
)
from pddecont.continuation import (
    END_POINT,
    BranchPoint,
    BranchState,
    CurvePoint,
    End,
    StepSettings,
    Termination,
    follow_branch,
)
from pddecont.errors import ConvergenceError
from pddecont.orbit import DelayBoundary, DurationBoundary, PeriodicOrbitSystem, RangeBoundary, orbit_from_rows
from pddecont.reasons import Reason, Scalar
from pddecont.results import CONTINUE, Step, StepWriter
from pddecont.runfile import PlannedStep
from pddecont.stability import Multipliers
from pddecont.steps.context import Context
from pddecont.steps.continuation import ContinueSettings
from pddecont.steps.execution.branch_start import start_step
from pddecont.steps.execution.ending import report_done
from pddecont.steps.execution.orbit_rows import make_multiplier_cache, make_orbit_meta, orbit_to_row
from pddecont.tables import UNRELIABLE

# Signatures that one direction goes through at most.
MAX_SIGNATURES = 100
# The kind of special point at which a signature ends without a test function: a segment vanishes.
VANISHING = "VS"


@dataclass(eq=False)
class _Branch:
    """A branch on its way into the results file."""

    context: Context
    step: PlannedStep[ContinueSettings]
    settings: BranchSettings
    writer: StepWriter
    last: BranchPoint[Any] | None = field(default=None)
    ordinary: BranchState[Any] | None = field(default=None)

    def record(self, point: BranchPoint[Any]) -> None:
        """Write a point to the file."""
        state, at = point.state, point.state.point.at
        side, kind = None, find_kind(point.kind)
        if isinstance(at, ExtendedEvaluation):
            kind = find_kind(at.system.defining.kind)
            side = find_good_side(at, None if kind is None else kind.good_side(at.system.defining))
        multipliers: Multipliers | None = None
        if self.settings.multipliers is not None:
            multipliers = self.settings.multipliers.find(at.orbit)
            if kind is not None:
                multipliers = replace(multipliers, nontrivial=kind.remove_critical(multipliers))
        points, rows = orbit_to_row(
            at.orbit,
            list(self.context.plan.monitors.values()),
            kind=point.kind,
            arclength=state.arclength,
            n_iterations=point.n_iterations,
            step=state.step,
            tangent=state.tangent,
            side=side,
            ranges=self.settings.widths,
            multipliers=multipliers,
        )
        self.writer.append(points, rows, point.reason)
        self.last = point
        if point.kind in ("", END_POINT):
            self.ordinary = state
        values = zip(self.settings.free, at.orbit.free, strict=True)
        shown = ", ".join(f"{name} = {value:.8g}" for name, value in values)
        self.context.reporter.progress(f"{self.writer.n} points, {shown}{f' {point.kind}' if point.kind else ''}")

    def follow(self, state: BranchState[Any], way: int) -> Reason:
        """Follow one direction through all its signatures; return how it ended."""
        steps, next_signature = self.step.settings, ""
        step_settings = StepSettings(steps.step_initial, steps.step_min, steps.step_max, steps.max_points)
        boundaries = (RangeBoundary(self.settings.ranges), DelayBoundary(), DurationBoundary())
        for _ in range(MAX_SIGNATURES):
            self.last, self.ordinary = BranchPoint(state, "", 0), state
            functions = make_tests(state.point.at, self.settings)
            end = follow_branch(state, boundaries, functions, step_settings, self.record, way)
            if not self._may_switch(end):
                break
            try:
                following = switch_signature(end, self.last, self.ordinary, self.settings, self.record, way)
            except ConvergenceError as exc:
                next_signature = str(exc)
                break
            if following is None:
                break
            # A signature may be short-lived: begin it as a branch is begun.
            state = replace(following, step=min(following.step, steps.step_initial))
        return _make_ending(end, way, next_signature)

    def _may_switch(self, end: Termination) -> bool:
        """Return whether a branch that ended so may go on with another signature."""
        if end.end not in (End.SPECIAL, End.IMPOSSIBLE) or not self.step.settings.follows_signatures:
            return False
        return end.end != End.IMPOSSIBLE or self.settings.wants(VANISHING)


def _make_ending(end: Termination, way: int, next_signature: str) -> Reason:
    values: dict[str, Scalar] = {"direction": way, "unexplained": end.n_unexplained}
    if end.detail:
        values |= {"detail": end.detail.code, **end.detail.values}
    return Reason(str(end.end), {**values, **({"next_signature": next_signature} if next_signature else {})})


def run_continue(context: Context, step: PlannedStep[ContinueSettings], recorded: Step | None) -> None:
    """Follow the branch in each direction asked for, from the start or from where ``recorded`` stopped."""
    plan, body = context.plan, step.settings
    settings = BranchSettings(
        body.free, body.ranges, step.rule, make_multiplier_cache(body.multipliers), body.user_functions, body.detect
    )
    start, reason = start_step(context, step, settings)
    if settings.multipliers is not None and settings.multipliers.find(start.point.at.orbit).unreliable:
        raise ConvergenceError(f"step '{step.name}': {UNRELIABLE}, or leave 'stability' out")
    ways = (1,) if start.one_way else body.ways
    first = BranchState(start.point, 0.0, body.step_initial, 1)
    states, ended, kept = {way: _turn(first, way) for way in ways}, set[int](), 0
    if recorded is not None and len(recorded):
        ended = {int(ending.values.get("direction", 0)) for ending in recorded.endings}
        way, row, kept = _find_unfinished(recorded, ways, ended)
        if row is not None:
            states[way] = _restore(step, settings, recorded, row, start, reason)
    meta: dict[str, Any] = {
        **make_orbit_meta(plan, step),
        "free": list(body.free),
        "directions": len(ways),
        "curve": start.kind,
        "curve_reason": reason.to_json() if start.kind else "",
    }
    with context.open_step(step, CONTINUE, meta, recorded=recorded, kept=kept) as writer:
        branch = _Branch(context, step, settings, writer)
        if writer.n == 0:
            branch.record(BranchPoint(first, "", 0))
        for place, way in enumerate(ways):
            if way not in ended:
                writer.terminate(branch.follow(states[way], way), place)
    report_done(context, step)


def _turn(start: BranchState[Any], way: int) -> BranchState[Any]:
    return replace(start, point=replace(start.point, direction=way * start.tangent))


def _find_unfinished(recorded: Step, ways: Sequence[int], ended: Collection[int]) -> tuple[int, int | None, int]:
    """Return the direction that was under way, its last ordinary row (None: there is none), and rows to keep."""
    arclength = recorded.points["arclength"]
    for way in ways:
        if way in ended:
            continue
        rows = np.flatnonzero(arclength * way > 0).tolist()
        while rows and recorded.kind_of(rows[-1]):
            rows.pop()
        if rows:
            return way, rows[-1], rows[-1] + 1
        return way, None, 1 + max(np.flatnonzero(arclength * way <= 0).tolist(), default=0)
    return 0, None, len(recorded)


def _restore(
    step: PlannedStep[ContinueSettings],
    settings: BranchSettings,
    recorded: Step,
    row: int,
    start: BranchStart,
    reason: Reason,
) -> BranchState[Any]:
    """Return the state that a recorded point left; ``reason`` is that of the special point that a curve follows."""
    of_start, rows, points = start.point.at.orbit, recorded.orbit(row), recorded.points
    orbit = orbit_from_rows(
        of_start.numeric,
        step.delay,
        points["parameters"][row],
        settings.free,
        rows,
        int(points["n_periods"][row]),
        float(points["phase"][row]),
    )
    of_branch: Any = start.point.system
    sizes = of_branch.inner.sizes if start.kind else of_branch.sizes
    system: Any = PeriodicOrbitSystem(orbit.problem, sizes, step.rule)
    if start.kind:
        system = extend_system(system, define_special_point(system.at(orbit.x), start.kind, reason, settings))
    arclength, way = float(points["arclength"][row]), np.sign(points["arclength"][row])
    before = (points["arclength"][: row + 1] * way > 0) & (points["kind"][: row + 1] == b"")
    point = CurvePoint(system, system.at(orbit.x), None, rows["tangent"])
    return BranchState(point, arclength, float(points["step"][row]), int(np.sum(before)) + 1)
