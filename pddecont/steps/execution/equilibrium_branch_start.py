"""Where a branch or curve of equilibria starts: the point that its step names, and its direction there."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pddecont.continuation import CurvePoint, NewtonSettings, correct, find_tangent, tangent_at
from pddecont.equilibrium import (
    BOUNDARY,
    BOUNDARY_CODE,
    BRANCH,
    FOLD,
    HOPF,
    BoundaryCondition,
    CriticalEvaluation,
    Equilibrium,
    EquilibriumCurve,
    EquilibriumProblem,
    EquilibriumSystem,
    find_other_frequency,
    find_other_tangent,
    has_critical,
    make_critical_start,
    measure_sizes,
    solve_equilibrium,
)
from pddecont.errors import ConvergenceError, RunError
from pddecont.reasons import NO_REASON, Reason, make_reason
from pddecont.results import Step
from pddecont.runfile import PlannedStep
from pddecont.steps.context import Context
from pddecont.steps.continuation import ContinueSettings, in_range
from pddecont.steps.execution.equilibrium import find_equilibrium
from pddecont.steps.execution.equilibrium_rows import equilibrium_from_row, has_same_delays

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


@dataclass(frozen=True, eq=False)
class EquilibriumStart:
    """The first point of a branch or curve, with its tangent towards larger values of the first parameter that moves.

    It has the label ``kind`` of the point that it comes from, and its ``reason``, where that says of it what the branch
    or curve does not: that it has more roots on the imaginary axis.
    """

    point: CurvePoint[Any]
    kind: str = ""
    reason: Reason = NO_REASON


def find_start(context: Context, step: PlannedStep[ContinueSettings]) -> EquilibriumStart:
    """Return where a branch or curve of equilibria starts."""
    recorded, row = find_equilibrium(context, step)
    found = equilibrium_from_row(context.plan, step.delay, recorded, row)
    guess = replace(found, parameters=context.plan.set_parameters(step, found.parameters))
    if len(step.settings.free) == 2:
        start = _start_curve(context, step, recorded, row, guess)
    elif step.settings.switches:
        start = _start_crossing(context, step, recorded, row, guess)
    else:
        start = _start_along(context, step, guess)
    curve = start.at.system.critical.label if isinstance(start.at, CriticalEvaluation) else ""
    kind = recorded.kind_of(row)
    same = np.array_equal(guess.parameters, found.parameters) and has_same_delays(recorded, step)
    if not (same and has_critical(curve, kind)):
        return EquilibriumStart(start)
    return EquilibriumStart(start, kind, recorded.reason(row))


def _start_along(context: Context, step: PlannedStep[ContinueSettings], guess: Equilibrium) -> CurvePoint[Any]:
    """Return an equilibrium on its branch."""
    try:
        found, _, _ = solve_equilibrium(guess)
    except ConvergenceError as exc:
        text = f"step '{step.name}': the equilibrium it starts from does not converge: {exc}"
        raise ConvergenceError(text, exc.history) from exc
    _check_range(context, step, found)
    system = _make_system(context, step, found)
    at, towards = system.at(system.problem.join(found)), np.zeros(system.problem.n_unknowns)
    towards[-1] = 1.0
    return CurvePoint(EquilibriumCurve(system), at, None, find_tangent(at, system.scaling, towards))


def find_curve_reason(start: CurvePoint[Any]) -> str:
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
    return CurvePoint(EquilibriumCurve(system), system.at(x), None, forward * other)


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
