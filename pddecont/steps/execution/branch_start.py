"""Where a ``continue`` step starts: the point that it names, and what is to be done from there."""

from __future__ import annotations

from pddecont.bifurcation import (
    BranchSettings,
    BranchStart,
    StartError,
    start_after_grazing,
    start_curve,
    start_on_orbit,
    start_other_branch,
)
from pddecont.errors import ConvergenceError, RunError, SignatureError
from pddecont.orbit import is_rotation
from pddecont.reasons import NO_REASON, Reason, reason_from_json
from pddecont.results import Step
from pddecont.runfile import PlannedStep
from pddecont.steps.context import Context
from pddecont.steps.continuation import ContinueSettings, in_range
from pddecont.steps.execution.equilibrium_start import start_from_hopf, starts_from_equilibrium
from pddecont.steps.execution.recorded_orbits import find_orbit, find_point

ADVICE = "the mesh and delay of the step that found the point, a finer mesh there, the other free parameter first"
ORBIT_ADVICE = "the mesh and delay of the step it comes from, a point farther from a fold or a grazing"


def start_step(
    context: Context, step: PlannedStep[ContinueSettings], settings: BranchSettings
) -> tuple[BranchStart, Reason]:
    """Return where the branch starts, its tangent towards larger values of the first free parameter.

    The reason is what is recorded of the point that it starts from.

    Raises
    ------
    RunError
        If a branch cannot start from that point, or it lies outside the range.
    ConvergenceError, SignatureError
        If the first point is not found, or has another signature than the one asked for.
    """
    assert step.source is not None, "a continue step's schema has a source"
    if starts_from_equilibrium(context, step):
        start = start_from_hopf(context, step, settings)
        _check_range(context, step, settings, start)
        return start, NO_REASON
    if step.settings.switches and len(settings.free) == 2:
        text = "'branch: switch' leads onto another branch of orbits in one free parameter; found two"
        raise RunError.at(context.plan.source, 0, 0, f"step '{step.name}': {text}")
    recorded, row = find_point(context, step.source)
    guess = find_orbit(context, step, step.source)
    found_on = str(recorded.meta.get("curve") or ""), _read_curve_reason(recorded)
    kind, reason, asked = recorded.kind_of(row), recorded.reason(row), step.settings.signature
    what, advice = "the orbit it starts from", ORBIT_ADVICE
    if len(settings.free) == 2:
        what, advice = f"the {kind or 'special'} point that it follows", ADVICE

        def begin() -> BranchStart:
            return start_curve(guess, kind, reason, settings, found_on)
    elif step.settings.switches:

        def begin() -> BranchStart:
            return start_other_branch(guess, kind, recorded.orbit(row)["tangent"], settings)
    elif asked is not None and not is_rotation(guess.signature.names, asked):
        what, advice = "the orbit after the grazing", ADVICE

        def begin() -> BranchStart:
            return start_after_grazing(guess, kind, asked, settings)
    else:

        def begin() -> BranchStart:
            return start_on_orbit(guess, settings)

    try:
        start = begin()
    except ConvergenceError as exc:
        text = f"step '{step.name}': {what} does not converge: {exc}. What usually helps: {advice}"
        raise ConvergenceError(text, exc.history) from exc
    except SignatureError as exc:
        raise SignatureError(f"step '{step.name}' {exc}") from exc
    except StartError as exc:
        raise RunError.at(context.plan.source, 0, 0, f"step '{step.name}': {exc}") from exc
    _check_range(context, step, settings, start)
    return start, reason


def _read_curve_reason(recorded: Step) -> Reason:
    """Return what is recorded of the special points that a curve follows; nothing of a branch."""
    text = str(recorded.meta.get("curve_reason") or "")
    return reason_from_json(text) if text else NO_REASON


def _check_range(
    context: Context, step: PlannedStep[ContinueSettings], settings: BranchSettings, start: BranchStart
) -> None:
    for name, (low, high), value in zip(settings.free, settings.ranges, start.point.at.orbit.free, strict=True):
        if not in_range(value, low, high):
            outside = f"starts at {name} = {value:g}, outside its range [{low:g}, {high:g}]; widen the range"
            raise RunError.at(context.plan.source, 0, 0, f"step '{step.name}' {outside}")
