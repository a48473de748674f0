"""How a branch goes on where its signature ends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from pddecont.bifurcation.extended_system import ExtendedEvaluation
from pddecont.bifurcation.motion_change import LABEL as MOTION_CHANGE
from pddecont.bifurcation.registry import find_kind
from pddecont.bifurcation.settings import BranchSettings
from pddecont.bifurcation.signature_joining import check_branch_joins
from pddecont.bifurcation.signature_removal import RELEASED, VANISHING, find_way_off, shrink_segment, vanish_segment
from pddecont.bifurcation.vanishing import LABEL
from pddecont.continuation import BranchPoint, BranchState, End, Termination
from pddecont.errors import ConvergenceError
from pddecont.orbit import find_shortest, name_vanishing
from pddecont.reasons import make_reason

Emit = Callable[[BranchPoint[Any]], object]


def switch_signature(
    termination: Termination,
    last: BranchPoint[Any],
    state: BranchState[Any],
    settings: BranchSettings,
    emit: Emit,
    sign: int,
) -> BranchState[Any] | None:
    """Return where a branch goes on with another signature; None where it really ends.

    What a rule gives has to join at the point and to be a motion of the model. Where no rule gives it, or not that, the
    next signature is what a simulation does beyond the point.

    Parameters
    ----------
    termination
        How the branch ended with its present signature.
    last
        The last point that was found, a special one if the branch ended there.
    state
        The last ordinary point.
    emit
        Takes the point at which a segment vanishes.
    sign
        Sign of this direction's arclengths.

    Raises
    ------
    ConvergenceError
        If the orbit of the other signature cannot be found.
    """
    at = last.state.point.at
    if isinstance(at, ExtendedEvaluation):
        if termination.end == End.IMPOSSIBLE:
            _vanish_on_curve(last.state, at, emit, sign)
        return None
    if not _may_go_on(termination, last):
        return None
    following, why = None, ""
    try:
        if termination.end == End.IMPOSSIBLE:
            last, following = _vanish(last.state, settings, emit, sign)
            if last.reason.code == RELEASED:
                # The nearer to the point, the more impacts follow beyond it: no signature is the next one.
                return None
        elif termination.end == End.SPECIAL:
            following = _apply_rule(last, state, settings)
    except ConvergenceError as exc:
        why = str(exc)
    if following is not None:
        try:
            check_branch_joins(following.point, last.state.point.at.orbit, settings)
        except ConvergenceError as exc:
            why = f"[{', '.join(following.point.at.orbit.signature.names)}] {exc}"
        else:
            return following
    # What simulates is imported where it is asked.
    from pddecont.bifurcation.signature_simulation import enter_simulated_signature

    try:
        point = enter_simulated_signature(last, state, settings)
    except ConvergenceError as exc:
        raise ConvergenceError("; ".join(filter(None, (why, f"beyond, as the motion goes on: {exc}")))) from exc
    return replace(state, point=point, arclength=last.state.arclength)


def _may_go_on(termination: Termination, last: BranchPoint[Any]) -> bool:
    """Return whether a branch that ended so may have another signature beyond."""
    if termination.end == End.INVALID:
        return last.kind == MOTION_CHANGE
    kind = find_kind(last.kind)
    return termination.end == End.IMPOSSIBLE or (
        termination.end == End.SPECIAL and kind is not None and kind.go_on is not None
    )


def _apply_rule(last: BranchPoint[Any], state: BranchState[Any], settings: BranchSettings) -> BranchState[Any] | None:
    """Return where a branch goes on by the rule for the kind of point that ended it; None where there is none."""
    kind = find_kind(last.kind)
    point = None if kind is None or kind.go_on is None else kind.go_on(last, state, settings)
    return None if point is None else replace(state, point=point, arclength=last.state.arclength)


def _vanish(
    state: BranchState[Any], settings: BranchSettings, emit: Emit, sign: int
) -> tuple[BranchPoint[Any], BranchState[Any] | None]:
    """Emit the point at which a segment vanishes; return it, and where a shorter signature goes on if one does."""
    at = state.point.at
    gone = vanish_segment(state.point, settings.rule)
    shortest = find_shortest(at.orbit)
    away = float(at.orbit.durations[shortest]) / at.system.sizes.period
    arclength = state.arclength + sign * away
    n_iterations = gone.point.n_iterations
    found = replace(state, point=gone.point, arclength=arclength)
    label = name_vanishing(at.orbit.signature, shortest) or LABEL
    special = BranchPoint(found, label, n_iterations, gone.reason)
    emit(special)
    if not gone.shorter:
        return special, None
    system = gone.point.at.system
    return special, replace(found, point=replace(gone.point, direction=find_way_off(system, gone.point.at)))


def _vanish_on_curve(state: BranchState[Any], at: ExtendedEvaluation, emit: Emit, sign: int) -> None:
    """Emit the point of a curve of special points at which a segment has almost no duration left."""
    point, segment = shrink_segment(at)
    scale = at.system.scaling.scale[at.orbit.problem.unknowns.durations.start]
    away = float(at.orbit.durations[find_shortest(at.orbit)]) / scale
    found = replace(state, point=point, arclength=state.arclength + sign * away)
    emit(BranchPoint(found, LABEL, point.n_iterations, make_reason(VANISHING, segment=segment)))
