"""Whether an orbit of another signature joins at the point where a signature ended, and is a motion of the model."""

from __future__ import annotations

import numpy as np

from pddecont.bifurcation.settings import BranchSettings
from pddecont.continuation import CurvePoint, NewtonSettings, correct, solve_adaptively
from pddecont.errors import ConvergenceError
from pddecont.orbit import Orbit, OrbitEvaluation, Verifier, measure_distance

# How far along the new branch an orbit is looked at, in lengths of the branch.
AHEAD = 1e-3
# The farthest that the first orbit may be from the last one: in its states, relative to their sizes, and in its
# parameters, relative to their ranges.
FAR, FAR_ALONG = 0.2, 0.05


def check_near(orbit: Orbit, last: Orbit) -> float:
    """Return how far an orbit is from the last one of another signature, relative to its size.

    Raises
    ------
    ConvergenceError
        If that is too far for the two to be one where the signature changes.
    """
    distance = measure_distance(orbit, last)
    if not distance <= FAR:
        raise ConvergenceError(f"does not join here: it is {distance:.2g} of the orbit's size away")
    return distance


def check_motion(orbit: Orbit, referee: Verifier, *, strict: bool = False) -> None:
    """Raise ConvergenceError if an orbit is no motion of the model; ``strict`` leaves no room for its errors."""
    verification = referee.verify(orbit, strict=strict)
    if verification.verified == 0:
        raise ConvergenceError(f"is no motion of the model ({verification.reason.code.replace('_', ' ')})")


def check_branch_joins(point: CurvePoint[OrbitEvaluation], last: Orbit, settings: BranchSettings) -> None:
    """Raise ConvergenceError if the branch that begins at ``point`` does not go on from the orbit ``last``.

    Its first orbits have to be near the last one, and motions of the model.
    """
    orbit = point.at.orbit
    check_near(orbit, last)
    if np.any(np.abs(orbit.free - last.free) > FAR_ALONG * np.array(settings.widths)):
        raise ConvergenceError("is far away in the parameter")
    if settings.referee is None:
        return
    try:
        ahead = _look_ahead(point)
    except ConvergenceError as exc:
        raise ConvergenceError(f"has no orbits a little further on: {exc}") from exc
    check_motion(ahead, settings.referee, strict=True)


def _look_ahead(point: CurvePoint[OrbitEvaluation]) -> Orbit:
    """Return the orbit a little further along the branch that begins at a point."""
    assert point.direction is not None, "where a branch begins it has a direction"
    predicted = point.x + AHEAD * point.direction
    _, solution = solve_adaptively(
        point.system,
        predicted,
        lambda on, guess, carried: correct(
            on, carried[0], on.scaling.normalise(carried[0] - carried[1]), NewtonSettings(), guess
        ),
        [predicted, point.x],
    )
    found: Orbit = solution.at.orbit
    return found
