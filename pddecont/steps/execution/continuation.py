"""Doing a ``continue`` step."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from pddecont.bifurcation import (
    BranchSettings,
    BranchStart,
    ExtendedEvaluation,
    define_special_point,
    end_at_equilibrium,
    extend_system,
    find_good_side,
    find_kind,
    make_tests,
    switch_signature,
)
from pddecont.continuation import (
    END_POINT,
    Boundary,
    BranchPoint,
    BranchState,
    CurvePoint,
    End,
    ErrorControl,
    Home,
    StepSettings,
    Termination,
    follow_branch,
)
from pddecont.errors import ConvergenceError, RunError
from pddecont.memo import cached_property
from pddecont.orbit import (
    DelayBoundary,
    DurationBoundary,
    Orbit,
    OrbitHorizon,
    PeriodicOrbitSystem,
    RangeBoundary,
    VaryingDelayBoundary,
    bound_amplitude,
    estimate_error,
    list_images,
    orbit_from_rows,
)
from pddecont.reasons import NO_REASON, Reason
from pddecont.results import CONTINUE, RowWriter, Step
from pddecont.runfile import PlannedStep
from pddecont.stability import Multipliers
from pddecont.steps.context import Context
from pddecont.steps.continuation import ContinueSettings
from pddecont.steps.execution.apart import follow_directions
from pddecont.steps.execution.branch_progress import RangeCovered
from pddecont.steps.execution.branch_start import start_step
from pddecont.steps.execution.directions import find_unfinished, make_branch_ending
from pddecont.steps.execution.ending import report_done
from pddecont.steps.execution.equilibrium_branch import run_equilibrium_branch
from pddecont.steps.execution.equilibrium_start import follows_equilibria
from pddecont.steps.execution.orbit_rows import make_multiplier_cache, make_orbit_meta, make_referee, orbit_to_row
from pddecont.tables import UNRELIABLE

# Signatures that one direction goes through at most.
MAX_SIGNATURES = 100
# The kind of special point at which a signature ends without a test function: a segment vanishes.
VANISHING = "VS"
# The kind of special point at which both halves of an orbit become equal.
HALVING = "PD"
# How far ahead of its first point a branch sets out, in scaled unknowns, to be known again by its direction.
AHEAD = 1e-3
# How a direction ended that need not be followed.
ALL_ROUND = Termination(End.CLOSED)


@dataclass(eq=False)
class _Branch:
    """A branch on its way into the results file."""

    context: Context
    step: PlannedStep[ContinueSettings]
    settings: BranchSettings
    writer: RowWriter
    first: BranchState[Any]
    last: BranchPoint[Any] | None = field(default=None)
    ordinary: BranchState[Any] | None = field(default=None)

    @cached_property
    def covered(self) -> RangeCovered:
        """What it has covered of its range."""
        return RangeCovered(self.settings.free, self.settings.ranges)

    def record(self, point: BranchPoint[Any]) -> float:
        """Write a point to the file; return its estimated error."""
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
        error = self._measure_error(state.point) if point.error is None else point.error
        points, rows = orbit_to_row(
            at.orbit,
            list(self.context.plan.monitors.values()),
            self.writer.meta["events"],
            kind=point.kind,
            arclength=state.arclength,
            n_iterations=point.n_iterations,
            step=state.step,
            tangent=state.tangent,
            side=side,
            referee=self.settings.referee,
            multipliers=multipliers,
            error=error,
            n_shown=self.step.settings.multipliers.number,
        )
        self.writer.append({**points, "unexplained": point.n_unexplained}, rows, point.reason)
        self.last = point
        if point.kind in ("", END_POINT):
            self.ordinary = state
        self.context.reporter.progress(*self.covered.describe(self.writer.n, at.orbit.free, point.kind))
        if not point.kind:
            self.context.budget.check()
        return error

    def follow(self, state: BranchState[Any], way: int, n_unexplained: int) -> Reason:
        """Follow one direction through all its signatures; return how it ended.

        ``n_unexplained`` counts the changes so far that no special point accounts for.
        """
        steps, next_signature = self.step.settings, ""
        amplitude = bound_amplitude(self.first.point.at.orbit)
        first = self.first.point.at.orbit
        delays = DelayBoundary(first.numeric, first.parameters, first.problem.free_index)
        varying = [VaryingDelayBoundary(first.numeric)] if first.numeric.model.varying else []
        boundaries: list[Boundary[Any]] = [
            RangeBoundary(self.settings.free, self.settings.ranges),
            delays,
            *varying,
            DurationBoundary(),
            amplitude,
        ]
        home = _make_home(_turn(self.first, way), self.settings.widths)
        horizon = OrbitHorizon(self.first.point.at.orbit.free)
        for _ in range(MAX_SIGNATURES):
            self.last, self.ordinary = BranchPoint(state, "", 0), state
            functions = make_tests(state.point.at, self.settings)
            end = follow_branch(state, boundaries, functions, self.step_settings, self.record, way, home, horizon)
            n_unexplained += end.n_unexplained
            if self._is_halved(end) and not steps.follows_halving:
                end = replace(end, end=End.HALVED, detail=NO_REASON)
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
            state = replace(following, step=min(following.step, steps.step_initial), is_start=True)
        if end.end == End.SHRINKS and self.ordinary is not None:
            end = end_at_equilibrium(end, self.ordinary, self.settings, self.record, way)
        return make_branch_ending(replace(end, n_unexplained=n_unexplained), way, next_signature)

    @cached_property
    def step_settings(self) -> StepSettings:
        """How long its steps are, and within what the estimated errors of its points stay."""
        asked, tol = self.step.settings, self.step.rule.tol
        control = None if tol is None else ErrorControl(self._measure_error, tol)
        return StepSettings(asked.step_initial, asked.step_min, asked.step_max, asked.max_points, control=control)

    def _measure_error(self, point: CurvePoint[Any]) -> float:
        """Return the estimated error of a corrected point."""
        if isinstance(point.at, ExtendedEvaluation):
            return estimate_error(point.at.orbit, self.settings.widths)
        return estimate_error(point.at.orbit, self.settings.widths, point.solve_nearly, point.tangent)

    def _is_halved(self, end: Termination) -> bool:
        """Return whether a branch ended where both halves of its orbits become equal."""
        return end.end == End.SPECIAL and self.last is not None and self.last.kind == HALVING

    def _may_switch(self, end: Termination) -> bool:
        """Return whether a branch that ended so may go on with another signature."""
        if end.end not in (End.SPECIAL, End.IMPOSSIBLE, End.INVALID) or not self.step.settings.follows_signatures:
            return False
        return end.end != End.IMPOSSIBLE or self.settings.wants(VANISHING)


def run_continue(context: Context, step: PlannedStep[ContinueSettings], recorded: Step | None) -> None:
    """Follow the branch in each direction asked for, from the start or from where ``recorded`` stopped."""
    plan, body = context.plan, step.settings
    if follows_equilibria(context, step):
        run_equilibrium_branch(context, step, recorded)
        return
    settings, start, reason = _begin(context, step)
    ways = (1,) if start.one_way else body.ways
    first = BranchState(start.point, 0.0, body.step_initial, 1)
    states, kept = {way: _turn(first, way) for way in ways}, 0
    endings: dict[int, Reason] = {}
    n_unexplained = dict.fromkeys(ways, 0)
    if recorded is not None and len(recorded):
        endings = {int(ending.values.get("direction", 0)): ending for ending in recorded.endings}
        way, row, kept = find_unfinished(recorded, ways, endings)
        if row is not None:
            states[way] = _restore(step, settings, recorded, row, start, reason)
            n_unexplained[way] = _count_unexplained(recorded, way, kept)
    meta: dict[str, Any] = {
        **make_orbit_meta(plan, step, recorded),
        "free": list(body.free),
        "directions": len(ways),
        "curve": start.kind,
        "curve_reason": reason.to_json() if start.kind else "",
    }
    with context.open_step(step, CONTINUE, meta, recorded=recorded, kept=kept, at_once=not kept) as writer:
        branch = _Branch(context, step, settings, writer, first)

        def follow_here(way: int) -> Reason:
            return branch.follow(states[way], way, n_unexplained[way])

        if writer.n == 0:
            branch.record(BranchPoint(first, "", 0))
        follow_directions(context, step, writer, ways, endings, follow_here, follow_direction, _find_ending)
    report_done(context, step)


def _begin(context: Context, step: PlannedStep[ContinueSettings]) -> tuple[BranchSettings, BranchStart, Reason]:
    """Return what a branch is followed with, where it starts, and what is recorded of the point that it starts from."""
    _check_detect(context, step)
    body = step.settings
    settings = BranchSettings(
        body.free,
        body.ranges,
        step.rule,
        make_multiplier_cache(body.multipliers),
        body.user_functions,
        body.detect,
        make_referee(context.plan, step),
    )
    start, reason = start_step(context, step, settings)
    if settings.multipliers is not None and settings.multipliers.find(start.point.at.orbit).unreliable:
        raise ConvergenceError(f"step '{step.name}': {UNRELIABLE}, or leave 'stability' out")
    return settings, start, reason


def follow_direction(context: Context, step: PlannedStep[ContinueSettings], writer: RowWriter, way: int) -> Reason:
    """Follow one direction of a branch from its start; return how it ended."""
    settings, start, _ = _begin(context, step)
    first = BranchState(start.point, 0.0, step.settings.step_initial, 1)
    return _Branch(context, step, settings, writer, first).follow(_turn(first, way), way, 0)


def _find_ending(way: int, endings: Collection[Reason]) -> Reason | None:
    """Return how a direction ends that need not be followed: a closed branch is all there, whichever way it goes."""
    return make_branch_ending(ALL_ROUND, way) if any(ending.code == End.CLOSED for ending in endings) else None


def _make_home(start: BranchState[Any], widths: tuple[float, ...]) -> Home[Any]:
    """Return how the first orbit of a branch, followed on from ``start``, is known again."""
    orbit = start.point.at.orbit
    ahead = Orbit(orbit.problem, start.x + AHEAD * start.tangent)
    return Home(
        lambda at: list_images(orbit, at.orbit),
        lambda at: list_images(ahead, at.orbit),
        lambda at: estimate_error(orbit, widths) + estimate_error(at.orbit, widths),
    )


def _turn(start: BranchState[Any], way: int) -> BranchState[Any]:
    return replace(start, point=replace(start.point, direction=way * start.tangent))


def _check_detect(context: Context, step: PlannedStep[ContinueSettings]) -> None:
    """Check that orbits have the multipliers from which special points are seen: known once the start is one."""
    for label in step.settings.detect or ():
        kind = find_kind(label)
        if kind is not None and kind.needs_multipliers and not step.settings.multipliers.wanted:
            text = (
                f"step '{step.name}': '{label}' is seen from multipliers of orbits; add 'stability: true' to this step"
            )
            raise RunError.at(context.plan.source, 0, 0, text)


def _count_unexplained(recorded: Step, way: int, kept: int) -> int:
    """Return how many changes no special point accounts for in a direction, in the first ``kept`` rows."""
    if "unexplained" not in recorded.points:
        return 0  # a file of an earlier version
    along = recorded.points["arclength"][:kept] * way > 0
    return int(np.sum(recorded.points["unexplained"][:kept][along]))


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
    step_length, error = float(points["step"][row]), float(points["error_estimate"][row])
    return BranchState(point, arclength, step_length, int(np.sum(before)) + 1, is_start=False, error=error)
