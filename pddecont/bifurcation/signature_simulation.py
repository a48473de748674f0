"""The next signature from a simulation, where no rule gives it.

From the orbit at the point where its signature ceases to hold, or one a little beyond, the model is simulated at
parameters a little beyond for as long as delays reach and a period more. What it does then is solved as an orbit,
beyond the point or, where the branch turns back, before it. It has to be a motion of the model and to come nearer to
the orbit at the point as its parameters do.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from pddecont.bifurcation.settings import BranchSettings
from pddecont.bifurcation.signature_joining import check_motion, check_near
from pddecont.continuation import BranchPoint, BranchState, CurvePoint, find_tangent
from pddecont.errors import ConvergenceError, SignatureError
from pddecont.orbit import (
    Orbit,
    OrbitEvaluation,
    Referee,
    Verifier,
    find_still_states,
    guess_from_motion,
    measure_distance,
    solve_orbit,
)

Array = NDArray[np.float64]
# How far beyond the point the motion is simulated, in lengths of the branch: ranges of parameters count as one.
BEYOND = (1e-3, 1e-4, 1e-2)
# For how many periods, and as long as delays reach: an unstable orbit leaves soon, a new one may need longer to show.
TURNS = (1.6, 4.6)
# By what factor the distance of the first orbit from the one at the point has to fall when the way in the parameter
# falls by CLOSER.
NEARER, CLOSER = 0.6, 1.0 / 16.0
# Below this distance the two are one.
SAME = 1e-4


def enter_simulated_signature(
    last: BranchPoint[OrbitEvaluation], before: BranchState[OrbitEvaluation], settings: BranchSettings
) -> CurvePoint[OrbitEvaluation]:
    """Return the first orbit of the signature that the motion has beyond a point, with the direction away from it.

    Raises
    ------
    ConvergenceError
        If what the motion does there is not found, or does not join at the point.
    """
    at = last.state.point.at.orbit
    referee = settings.referee or Referee(at.numeric, at.problem.delay)
    forward = _find_forward(last, before)
    reasons: dict[str, str] = {}
    for turns, length in product(TURNS, BEYOND):
        beyond = _move(last, forward, length)
        try:
            guess = guess_from_motion(beyond, turns, settings.rule)
        except (ConvergenceError, SignatureError) as exc:
            reasons.setdefault("", str(exc))
            continue
        for way in (1.0, -1.0):
            try:
                orbit = _solve_at(guess, at, way * length * forward, settings)
                _check_joins(orbit, at, way * length * forward, settings, referee)
            except (ConvergenceError, SignatureError) as exc:
                names = ", ".join(guess.signature.names)
                reasons.setdefault(names, f"it runs through [{names}], but that {_shorten(exc)}")
                continue
            return _begin(orbit, last.state.point.at, way * forward, settings)
    # What was found of a signature says more than that none was found.
    raise ConvergenceError("; ".join(why for names, why in reasons.items() if names or len(reasons) == 1))


def _shorten(exc: Exception) -> str:
    """Return why an orbit was not taken, in a few words."""
    return "has no orbit near this one" if isinstance(exc, ConvergenceError) and exc.history else str(exc)


def _find_forward(last: BranchPoint[OrbitEvaluation], before: BranchState[OrbitEvaluation]) -> Array:
    """Return the change of the free parameters along the branch at its end, for one length of it; never zero."""
    direction = last.state.point.direction
    point = last.state.point if direction is not None and len(direction) else before.point
    change = point.tangent[point.at.orbit.problem.unknowns.free]
    widths = np.asarray(point.system.scaling.scale[point.at.orbit.problem.unknowns.free])
    # Along a branch that hardly moves in its parameter, a length is one of the parameter all the same.
    sign = np.where(change < 0.0, -1.0, 1.0)
    return np.where(np.abs(change) < 0.1 * widths, 0.1 * sign * widths, change)


def _move(last: BranchPoint[OrbitEvaluation], forward: Array, length: float) -> Orbit:
    """Return the orbit a ``length`` beyond a point where it has one, else the orbit there at parameters beyond."""
    point = last.state.point
    orbit = point.at.orbit
    x = orbit.x.copy()
    if point.direction is not None and len(point.direction) == len(x):
        moved = x + length * point.direction
        if np.all(Orbit(orbit.problem, moved).durations > 0.0):
            x = moved
    x[orbit.problem.unknowns.free] = orbit.free + length * forward
    return Orbit(orbit.problem, x)


def _solve_at(guess: Orbit, at: Orbit, change: Array, settings: BranchSettings) -> Orbit:
    """Return the orbit near a guess, its free parameters ``change`` away from those of the orbit ``at`` the point."""
    p = guess.parameters.copy()
    p[list(at.problem.free_index)] = at.free + change
    return solve_orbit(Orbit(replace(guess.problem, parameters=p), guess.x), settings.rule).at.orbit


def _check_joins(orbit: Orbit, at: Orbit, change: Array, settings: BranchSettings, referee: Verifier) -> None:
    """Raise ConvergenceError if an orbit is no motion, or does not come nearer to the one ``at`` the point."""
    distance = check_near(orbit, at)
    check_motion(orbit, referee)
    if distance <= SAME:
        return
    nearer = measure_distance(_solve_at(orbit, at, CLOSER * change, settings), at)
    if nearer > max(NEARER * distance, SAME):
        raise ConvergenceError(f"does not join here: it stays {nearer:.2g} of the orbit's size away")


def _begin(
    orbit: Orbit, last: OrbitEvaluation, forward: Array, settings: BranchSettings
) -> CurvePoint[OrbitEvaluation]:
    """Return where the branch goes on; states that have just begun to move keep the size that they had."""
    system, free = settings.make_system(orbit)
    moves, before = ~find_still_states(last.orbit.values), last.system.sizes.states
    states = np.where(moves, system.sizes.states, np.maximum(before, system.sizes.states))
    sizes = replace(system.sizes, states=states)
    system = replace(system, sizes=sizes)
    found = system.at(free.x)
    towards = np.zeros(len(free.x))
    towards[free.problem.unknowns.free] = forward
    return CurvePoint(system, found, None, find_tangent(found, system.scaling, towards))
