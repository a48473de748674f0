"""Where impacts that accumulate cease to end before the motion is released.

Shortly before the release, s before it, the motion is pressed on the surface with an acceleration c s. An impact with
speed w c s^2 after it is followed by a flight that takes the part x of the time left,

    w = x/2 - x^2/6,      w' = r (x/2 - x^2/3) / (1 - x)^2,

so that the part x for which w' = w is the same from impact to impact, and speeds and times left fall to zero together.
With a smaller part the impacts accumulate before the release, with a larger one they do not. The orbit whose last
flight takes just this part is therefore the last one that comes to rest; the impacts that it does not follow change its
parameter by less than they change w.
"""

from __future__ import annotations

from scipy.optimize import brentq

from pddecont.bifurcation.signature_insertion import set_duration
from pddecont.continuation import CurvePoint
from pddecont.errors import ConvergenceError
from pddecont.orbit import Orbit, OrbitEvaluation, Signature, find_event_profile

# By what factor the time at rest is shortened: as fast, or as much more slowly, as Newton's method can follow.
SHRINK = (0.5, 0.8, 0.95)
# How near the part has to come, and after so many steps at the latest: parameters hardly depend on it there.
SAME_PART, MAX_STEPS = 1e-6, 400


def is_rest(signature: Signature, s: int) -> bool:
    """Return whether segment ``s`` is the rest after impacts that accumulate, two at least."""
    return signature.segments[s - 1].rests and (s - 1) % len(signature) in signature.trailing


def end_rest(point: CurvePoint[OrbitEvaluation], s: int) -> CurvePoint[OrbitEvaluation]:
    """Return the point at which impacts accumulate just as the motion is released, where segment ``s`` was its rest.

    Raises
    ------
    ConvergenceError
        If it cannot be reached.
    """
    wanted = find_last_part(_find_restitution(point.at.orbit, s))
    for _ in range(MAX_STEPS):
        durations = point.at.orbit.durations
        part = durations[s - 1] / (durations[s - 1] + durations[s])
        if abs(part - wanted) <= SAME_PART:
            return point
        point = _shorten(point, s, float(durations[s - 1]) * (1.0 / wanted - 1.0))
    raise ConvergenceError("the impacts that accumulate are not followed to where the motion is released")


def find_last_part(restitution: float) -> float:
    """Return the part x of the time left that each flight takes where impacts accumulate just at the release."""

    def gain(x: float) -> float:
        return (0.5 - x / 6.0) * (1.0 - x) ** 2 - restitution * (0.5 - x / 3.0)

    return float(brentq(gain, 0.0, 1.0))


def _find_restitution(orbit: Orbit, s: int) -> float:
    """Return how fast the motion flies off after one of the last impacts, relative to how fast it came."""
    profile = find_event_profile(orbit, orbit.signature.segments[s - 1].event)
    return abs(profile.start_slope((s - 1) % len(orbit.signature)) / profile.end_slope((s - 2) % len(orbit.signature)))


def _shorten(point: CurvePoint[OrbitEvaluation], s: int, wanted: float) -> CurvePoint[OrbitEvaluation]:
    """Return the orbit with a rest of the duration ``wanted``, or on the way to it as far as it can be followed."""
    now = float(point.at.orbit.durations[s])
    for factor in SHRINK:
        duration = min(max(wanted, factor * now), now / factor)
        try:
            return set_duration(point.at.system, point.x, s, duration)
        except ConvergenceError:
            if factor == SHRINK[-1]:
                raise
    raise AssertionError("a factor is tried at least")
