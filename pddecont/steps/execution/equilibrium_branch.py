"""Doing a ``continue`` step that starts from an equilibrium: a branch of equilibria in one free parameter."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pddecont.continuation import (
    BranchPoint,
    BranchState,
    CurvePoint,
    FixedUnknowns,
    Home,
    NewtonSettings,
    StepSettings,
    correct,
    find_tangent,
    follow_branch,
    tangent_at,
)
from pddecont.equilibrium import (
    BOUNDARY,
    BOUNDARY_CODE,
    BRANCH,
    CURVE_NAMES,
    FOLD,
    HOPF,
    NAMES,
    BoundaryCondition,
    CriticalEvaluation,
    Equilibrium,
    EquilibriumProblem,
    EquilibriumSystem,
    WayOn,
    find_better_side,
    find_curve_values,
    find_other_frequency,
    find_other_tangent,
    find_special_values,
    find_way_on,
    make_critical_start,
    make_curve_tests,
    make_tests,
    measure_sizes,
    solve_equilibrium,
)
from pddecont.errors import ConvergenceError, RunError
from pddecont.orbit import DelayBoundary, RangeBoundary
from pddecont.reasons import Reason, make_reason
from pddecont.results import EQUILIBRIA, Step, StepWriter
from pddecont.runfile import PlannedStep
from pddecont.steps.context import Context
from pddecont.steps.continuation import ContinueSettings, in_range
from pddecont.steps.execution.directions import find_unfinished, make_branch_ending
from pddecont.steps.execution.ending import report_done
from pddecont.steps.execution.equilibrium import find_equilibrium
from pddecont.steps.execution.equilibrium_rows import equilibrium_from_row, equilibrium_to_row, make_equilibrium_meta

# How far ahead of its first point a branch sets out, in scaled unknowns, to be known again by its direction.
AHEAD = 1e-3
# Modes that one direction goes through at most.
MAX_MODES = 100
# Special points that are followed in two parameters.
FOLLOWED = (FOLD, HOPF, BOUNDARY)
# What curve is followed from a point of codimension two, by the curve that it was found on: the other one through it.
TAKENS, DOUBLE_HOPF = "BT", "HH"
THROUGH = {
    ("CP", FOLD): FOLD,
    ("GH", HOPF): HOPF,
    (TAKENS, FOLD): HOPF,
    (TAKENS, HOPF): FOLD,
    ("ZH", FOLD): HOPF,
    ("ZH", HOPF): FOLD,
    (DOUBLE_HOPF, HOPF): HOPF,
}
# A parameter that moves less than this part of what another does stays, where it is asked which way a curve goes.
STILL = 1e-6


@dataclass(eq=False)
class _Branch:
    """A branch on its way into the results file."""

    context: Context
    step: PlannedStep[ContinueSettings]
    writer: StepWriter
    first: BranchState[Any]
    last: BranchPoint[Any] | None = None
    way_on: WayOn | None = None

    def record(self, point: BranchPoint[Any]) -> None:
        """Write a point to the file."""
        state, at = point.state, point.state.point.at
        if isinstance(at, CriticalEvaluation):
            special = find_curve_values(at, point.reason)
        else:
            special = find_special_values(point, self.step.settings.free[0], state.point.system.scaling.scale[-1])
        reason = special.reason
        if point.kind == BOUNDARY and not isinstance(at, CriticalEvaluation):
            self.way_on = find_way_on(state.point, str(point.reason.values["event"]))
            reason = Reason(reason.code, {**reason.values, "nature": self.way_on.nature if self.way_on else ""})
        points, rows = equilibrium_to_row(
            at.equilibrium,
            at.roots,
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
        )
        self.writer.append(points, rows, reason)
        self.last = point
        values = zip(self.step.settings.free, at.x[-len(self.step.settings.free) :], strict=True)
        shown = ", ".join(f"{name} = {value:.8g}" for name, value in values)
        self.context.reporter.progress(f"{self.writer.n} points, {shown}{f' {point.kind}' if point.kind else ''}")

    def follow(self, state: BranchState[Any], way: int) -> Reason:
        """Follow one direction through all its modes; return how it ended."""
        steps = self.step.settings
        settings = StepSettings(steps.step_initial, steps.step_min, steps.step_max, steps.max_points)
        home = _make_home(replace(self.first, point=_turn(self.first.point, way)))
        for _ in range(MAX_MODES):
            at = state.point.at
            on_curve = isinstance(at, CriticalEvaluation)
            problem = at.system.problem if on_curve else at.problem
            delays = DelayBoundary(problem.motion.numeric, problem.parameters, problem.free)
            boundaries = (RangeBoundary(steps.free, steps.ranges), delays)
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
    start = _find_start(context, step)
    first = BranchState(start, 0.0, settings.step_initial, 1)
    states, kept = {way: replace(first, point=_turn(start, way)) for way in settings.ways}, 0
    endings: dict[int, Reason] = {}
    if recorded is not None and len(recorded):
        endings = {int(ending.values.get("direction", 0)): ending for ending in recorded.endings}
        way, row, kept = find_unfinished(recorded, settings.ways, endings)
        if row is not None:
            states[way] = _restore(start, recorded, row)
    meta: dict[str, Any] = {
        **make_equilibrium_meta(context.plan, {**NAMES, **CURVE_NAMES}),
        "free": list(settings.free),
        "directions": len(settings.ways),
        "curve": start.at.system.critical.label if isinstance(start.at, CriticalEvaluation) else "",
        "curve_reason": _find_curve_reason(start),
    }
    with context.open_step(step, EQUILIBRIA, meta, recorded=recorded, kept=kept) as writer:
        branch = _Branch(context, step, writer, first)
        if writer.n == 0:
            branch.record(BranchPoint(first, "", 0))
        for place, way in enumerate(settings.ways):
            if way not in endings:
                endings[way] = branch.follow(states[way], way)
                writer.terminate(endings[way], place)
    report_done(context, step)


def _find_start(context: Context, step: PlannedStep[ContinueSettings]) -> CurvePoint[Any]:
    """Return the first point, with its tangent towards larger values of the free parameter."""
    recorded, row = find_equilibrium(context, step)
    plan, settings = context.plan, step.settings
    guess = equilibrium_from_row(plan, step.delay, recorded, row)
    guess = replace(guess, parameters=plan.set_parameters(step, guess.parameters))
    if len(settings.free) == 2:
        return _start_curve(context, step, recorded, row, guess)
    if settings.switches:
        return _start_crossing(context, step, recorded, row, guess)
    try:
        found, _, _ = solve_equilibrium(guess)
    except ConvergenceError as exc:
        text = f"step '{step.name}': the equilibrium it starts from does not converge: {exc}"
        raise ConvergenceError(text, exc.history) from exc
    _check_range(context, step, found)
    system = _make_system(context, step, found)
    at, towards = system.at(system.problem.join(found)), np.zeros(system.problem.n_unknowns)
    towards[-1] = 1.0
    return CurvePoint(FixedUnknowns(system), at, None, find_tangent(at, system.scaling, towards))


def _find_curve_reason(start: CurvePoint[Any]) -> str:
    """Return, as JSON, the event whose boundary equilibria are followed; nothing of other curves."""
    critical = start.at.system.critical if isinstance(start.at, CriticalEvaluation) else None
    if not isinstance(critical, BoundaryCondition):
        return ""
    return make_reason(BOUNDARY_CODE, event=critical.event).to_json()


def _start_crossing(
    context: Context, step: PlannedStep[ContinueSettings], recorded: Step, row: int, at: Equilibrium
) -> CurvePoint[Any]:
    """Return a branch point with the tangent of the other branch, towards larger values of the free parameter."""
    kind, tangent = recorded.kind_of(row), np.array(recorded.orbit(row)["tangent"])
    if kind != BRANCH:
        raise RunError.at(
            context.plan.source,
            0,
            0,
            f"step '{step.name}': 'branch: switch' leads from an HB point to orbits and from a BP point to the other "
            f"equilibria; found {f'a {kind} point' if kind else 'an ordinary point'}",
        )
    system = _make_system(context, step, at)
    x = system.problem.join(at)
    _check_range(context, step, at)
    if len(tangent) != len(x):
        raise ConvergenceError(f"step '{step.name}': the branch that the point was found on has other unknowns")
    other = find_other_tangent(system, x, tangent)
    forward = float(np.sign(other[-1])) or 1.0
    return CurvePoint(FixedUnknowns(system), system.at(x), None, forward * other)


def _find_surface(point: BranchPoint[Any]) -> str:
    """Return the event on whose surface a point lies by its definition."""
    at = point.state.point.at
    if isinstance(at, CriticalEvaluation):
        critical = at.system.critical
        return critical.event if isinstance(critical, BoundaryCondition) else ""
    return str(point.reason.values["event"]) if point.kind == BOUNDARY else ""


def _make_system(context: Context, step: PlannedStep[ContinueSettings], at: Equilibrium) -> EquilibriumSystem:
    settings = step.settings
    free = tuple(context.plan.numeric.parameter_index(name) for name in settings.free)
    problem = EquilibriumProblem(at.motion, at.parameters, free)
    widths = tuple(high - low for low, high in settings.ranges)
    return EquilibriumSystem(problem, measure_sizes(at.states), widths)


def _start_curve(
    context: Context, step: PlannedStep[ContinueSettings], recorded: Step, row: int, guess: Equilibrium
) -> CurvePoint[Any]:
    """Return the first point of a curve of special points, towards larger values of the first parameter that moves."""
    kind, own = recorded.kind_of(row), str(recorded.meta.get("curve", ""))
    label = kind if kind in FOLLOWED else THROUGH.get((kind, own), "")
    if not label:
        raise RunError.at(
            context.plan.source,
            0,
            0,
            f"step '{step.name}': it has two free parameters: it follows a special point ({', '.join(FOLLOWED)}) and "
            f"cannot start from {f'a {kind} point' if kind else 'an ordinary point'}",
        )
    frequency = None
    if kind == DOUBLE_HOPF:
        frequency = find_other_frequency(guess, float(recorded.points["frequency"][row]))
    elif kind == TAKENS:
        frequency = 0.0
    system = _make_system(context, step, guess)
    event = str((recorded.curve_reason if own else recorded.reason(row)).values.get("event", ""))
    critical, start = make_critical_start(system, label, event, guess, frequency)
    scale = critical.scaling.scale
    null = np.linalg.svd(critical.at(start).jacobian() * scale)[2][-1] * scale
    try:
        solution = correct(critical, start, null, NewtonSettings())
    except ConvergenceError as exc:
        text = f"step '{step.name}': the {kind} point that it follows does not converge: {exc}"
        raise ConvergenceError(text, exc.history) from exc
    _check_range(context, step, solution.at.equilibrium)
    direction = tangent_at(solution, critical.scaling, null)
    moves = direction[-2:] / np.array(system.widths)
    forward = next((float(np.sign(m)) for m in moves if abs(m) > STILL * np.max(np.abs(moves))), 1.0)
    return CurvePoint(critical, solution.at, None, forward * direction)


def _check_range(context: Context, step: PlannedStep[ContinueSettings], found: Equilibrium) -> None:
    plan, settings = context.plan, step.settings
    for name, (low, high) in zip(settings.free, settings.ranges, strict=True):
        value = float(found.parameters[plan.numeric.parameter_index(name)])
        if not in_range(value, low, high):
            outside = f"starts at {name} = {value:g}, outside its range [{low:g}, {high:g}]; widen the range"
            raise RunError.at(plan.source, 0, 0, f"step '{step.name}' {outside}")


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
    """Return the state that a recorded point left."""
    rows, points = recorded.orbit(row), recorded.points
    arclength, way = float(points["arclength"][row]), np.sign(points["arclength"][row])
    before = (points["arclength"][: row + 1] * way > 0) & (points["kind"][: row + 1] == b"")
    point = replace(start, at=start.system.at(np.array(rows["unknowns"])), direction=np.array(rows["tangent"]))
    return BranchState(point, arclength, float(points["step"][row]), int(np.sum(before)) + 1, is_start=False)
