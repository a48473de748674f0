"""Whether a branch of another signature joins at the point where a signature ended."""

from __future__ import annotations

import numpy as np

from pddecont.bifurcation.settings import BranchSettings
from pddecont.continuation import CurvePoint, NewtonSettings, correct, solve_adaptively
from pddecont.errors import ConvergenceError
from pddecont.orbit import Orbit, OrbitEvaluation, measure_distance

# How far along the new branch an orbit is looked at, in lengths of the branch.
AHEAD = 1e-3
# The farthest that the first orbit may be from the last one: in its states, relative to their sizes, and in its
# parameters, relative to their ranges.
FAR, FAR_ALONG = 0.2, 0.05


def find_objection(point: CurvePoint[OrbitEvaluation], last: Orbit, settings: BranchSettings) -> str:
    """Return why the branch that begins at ``point`` does not go on from the orbit ``last``; empty if it does.

    Its first orbits have to be near the last one, and motions of the model.
    """
    orbit = point.at.orbit
    if measure_distance(orbit, last) > FAR:
        return "the orbit of the next signature does not join here"
    if np.any(np.abs(orbit.free - last.free) > FAR_ALONG * np.array(settings.widths)):
        return "the orbit of the next signature is far away in the parameter"
    if settings.referee is None:
        return ""
    try:
        ahead = _look_ahead(point)
    except ConvergenceError as exc:
        return f"the next signature has no orbits a little further on: {exc}"
    verification = settings.referee.verify(ahead, strict=True)
    if verification.verified == 0:
        what = verification.reason.code.replace("_", " ")
        return f"[{', '.join(ahead.signature.names)}] is no motion of the model there ({what})"
    return ""


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
