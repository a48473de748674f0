"""How a branch goes on where its signature ends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pddecont.bifurcation import grazing, period_doubling, signature, tangency
from pddecont.continuation.branch import Point, State
from pddecont.continuation.ending import End, Termination
from pddecont.errors import ConvergenceError
from pddecont.orbit.curve import Curve, settle
from pddecont.orbit.meshing import MeshRule

Array = NDArray[np.float64]


def go_on(end: Termination, last: Point, state: State, rule: MeshRule, emit: Callable[[Point], None], sign: int) -> State | None:
    """Return where the branch goes on after ``end``, with another signature; None where it really ends.

    Parameters
    ----------
    end
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
    curve = last.state.problem
    if not isinstance(curve, Curve):
        if end.end is End.IMPOSSIBLE:
            _vanished_on_curve(state, emit, sign)
        return None
    if end.end is End.IMPOSSIBLE:
        return _without(_vanished(last.state, rule, emit, sign), rule)
    if end.end is not End.SPECIAL:
        return None
    if last.kind == grazing.KIND:
        entered = signature.enter(curve, last.state.x, rule)
        return _from(last.state, state, entered.curve, entered.x, entered.tangent)
    if last.kind == tangency.KIND and tangency.MEETS in last.note:
        return None
    if last.kind == tangency.KIND:
        rates = tangency.crossing_rates(curve.problem, last.state.x)
        shorter, x = signature.without_segment(curve, last.state.x, rule, int(np.nanargmin(np.abs(rates))))
        shorter, x = _solved(shorter, x, rule)
        return _from(last.state, state, shorter, x, signature.away(shorter, x))
    if last.kind == period_doubling.KIND:
        # The single orbit goes on the way that the parameter went.
        forward = np.sign(state.tangent[state.problem.problem.layout.free.start]) or 1.0
        free = curve.problem.layout.free.start
        direction = last.state.tangent * forward * np.sign(last.state.tangent[free])
        return _from(last.state, state, curve, last.state.x, direction)
    return None


def _from(at: State, before: State, curve: Curve, x: Array, direction: Array) -> State:
    return replace(before, problem=curve, x=x, tangent=direction, arclength=at.arclength)


def _solved(curve: Curve, x: Array, rule: MeshRule) -> tuple[Curve, Array]:
    """Return the orbit near ``x`` with its free parameter kept."""
    free = curve.problem.free
    problem, guess = curve.problem.with_free(x, ())
    problem, solution = settle(problem, guess, rule)
    problem, x = problem.with_free(solution.x, free)
    return Curve(problem, curve.sizes, rule), x


def _vanished(state: State, rule: MeshRule, emit: Callable[[Point], None], sign: int) -> tuple[State, bool]:
    """Emit the point at which a segment vanishes; return it, and whether a shorter signature goes on from there."""
    curve = state.problem
    gone = signature.vanish(curve, state.x, rule)
    found = gone.curve
    assert isinstance(found, Curve)
    durations = state.x[curve.problem.layout.durations]
    away = float(np.min(durations)) / curve.sizes.period
    at = State(found, gone.solution.x, np.zeros(0), state.arclength + sign * away, state.step, state.n_points)
    emit(Point(at, tangency.KIND, gone.solution.n_iterations, gone.note))
    return at, gone.shorter


def _vanished_on_curve(state: State, emit: Callable[[Point], None], sign: int) -> None:
    """Emit the point of a curve of special points at which a segment has almost no duration left."""
    curve = state.problem
    special, solution, name = signature.shrink(curve, state.x)
    away = float(np.min(state.x[curve.problem.layout.durations])) / curve.metric().scale[curve.problem.layout.durations.start]
    at = State(special, solution.x, np.zeros(0), state.arclength + sign * away, state.step, state.n_points)
    emit(Point(at, tangency.KIND, solution.n_iterations, f"{name} vanishes"))


def _without(gone: tuple[State, bool], rule: MeshRule) -> State | None:
    at, shorter = gone
    if not shorter:
        return None
    curve = at.problem
    if not isinstance(curve, Curve):
        raise ConvergenceError("a segment vanishes here")
    return replace(at, tangent=signature.away(curve, at.x))
