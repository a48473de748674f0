"""Whether an orbit that was solved for is one: not an equilibrium, and not a shorter one several times over."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.orbit.amplitude import can_shrink, measure_size
from pddecont.orbit.error import measure_states
from pddecont.orbit.orbit import Orbit

Array = NDArray[np.float64]
# An orbit this small beside the guess is an equilibrium, to what Newton's method leaves.
AT_REST = 1e-6
# Parts of an orbit that differ by less than this, relative to its size, are equal.
EQUAL = 1e-5
# Parts that an orbit without events is looked at for.
MAX_PARTS = 16
# Where in a segment orbits are compared: parts that no symmetry makes special.
PLACES = (0.1213, 0.4789, 0.8331)


def is_at_rest(orbit: Orbit, guess: Orbit) -> bool:
    """Return whether an orbit does not move, beside the guess that it was solved from."""
    sizes = measure_states(guess.values)
    return can_shrink(orbit) and measure_size(orbit, sizes) < AT_REST * measure_size(guess, sizes)


def count_repetitions(orbit: Orbit) -> int:
    """Return how many times an orbit repeats itself in its period."""
    signature = orbit.signature
    most = len(signature) if signature.has_events else MAX_PARTS
    forced = orbit.numeric.model.forced
    parts = [k for k in range(2, most + 1) if not (forced and orbit.problem.n_periods % k)]
    return max((k for k in parts if _repeats(orbit, k)), default=1)


def _repeats(orbit: Orbit, k: int) -> bool:
    """Return whether an orbit is the same in each of ``k`` parts of its period."""
    names, period = orbit.signature.names, orbit.period
    if orbit.signature.has_events:
        shift, rest = divmod(len(names), k)
        if rest or names != [*names[shift:], *names[:shift]]:
            return False
        times = (orbit.event_times[:-1, None] + np.array(PLACES) * orbit.durations[:, None]).ravel()
    else:
        times = (np.arange(MAX_PARTS)[:, None] + np.array(PLACES)).ravel() * period / MAX_PARTS
    here, there = (_read(orbit, t) for t in (times, times + period / k))
    return float(np.max(np.abs(here - there) / measure_states(orbit.values))) < EQUAL


def _read(orbit: Orbit, times: Array) -> Array:
    points, _ = orbit.mesh.locate(orbit.theta, times)
    return orbit.mesh.interpolate(orbit.values, points.clipped())
