"""How a branch goes on where its signature ends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from pddecont.bifurcation.extended_system import ExtendedEvaluation
from pddecont.bifurcation.registry import find_kind
from pddecont.bifurcation.settings import BranchSettings
from pddecont.bifurcation.signature_removal import VANISHING, find_way_off, shrink_segment, vanish_segment
from pddecont.bifurcation.vanishing import LABEL
from pddecont.continuation import BranchPoint, BranchState, End, Termination
from pddecont.reasons import make_reason

Emit = Callable[[BranchPoint[Any]], None]


def switch_signature(
    termination: Termination,
    last: BranchPoint[Any],
    state: BranchState[Any],
    settings: BranchSettings,
    emit: Emit,
    sign: int,
) -> BranchState[Any] | None:
    """Return where a branch goes on with another signature; None where it really ends.

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
    if termination.end == End.IMPOSSIBLE:
        return _vanish(last.state, settings, emit, sign)
    kind = find_kind(last.kind)
    if termination.end != End.SPECIAL or kind is None or kind.go_on is None:
        return None
    point = kind.go_on(last, state, settings)
    return None if point is None else replace(state, point=point, arclength=last.state.arclength)


def _vanish(state: BranchState[Any], settings: BranchSettings, emit: Emit, sign: int) -> BranchState[Any] | None:
    """Emit the point at which a segment vanishes; return it if a shorter signature goes on from there."""
    at = state.point.at
    gone = vanish_segment(state.point, settings.rule)
    away = float(at.orbit.durations.min()) / at.system.sizes.period
    arclength = state.arclength + sign * away
    n_iterations = gone.point.n_iterations
    found = replace(state, point=gone.point, arclength=arclength)
    emit(BranchPoint(found, LABEL, n_iterations, gone.reason))
    if not gone.shorter:
        return None
    system = gone.point.at.system
    return replace(found, point=replace(gone.point, direction=find_way_off(system, gone.point.at)))


def _vanish_on_curve(state: BranchState[Any], at: ExtendedEvaluation, emit: Emit, sign: int) -> None:
    """Emit the point of a curve of special points at which a segment has almost no duration left."""
    point, segment = shrink_segment(at)
    scale = at.system.scaling.scale[at.orbit.problem.unknowns.durations.start]
    away = float(at.orbit.durations.min()) / scale
    found = replace(state, point=point, arclength=state.arclength + sign * away)
    emit(BranchPoint(found, LABEL, point.n_iterations, make_reason(VANISHING, segment=segment)))
