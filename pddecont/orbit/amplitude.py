"""Where orbits shrink to an equilibrium: what keeps a branch on this side of it.

An orbit without events or jumps in an autonomous model has no size that its equations know of. Through the Hopf point
at which its amplitude r is zero the branch goes on to -r, the same orbits half a period later, and at r = 0 its
equations are those of the equilibrium, with any period at all. So the amplitude is measured with a sign, along the
orbit that is the reference of the phase or, where an event fixes it, by the direction in which that is crossed; and a
branch comes no nearer to zero than a small part of the amplitude that it started with.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation import Approach, End
from pddecont.orbit.admissibility import SIGNS
from pddecont.orbit.boundaries import AtOrbit
from pddecont.orbit.error import measure_states
from pddecont.orbit.event_profiles import find_event_profile
from pddecont.orbit.orbit import Orbit
from pddecont.reasons import Reason, make_reason

Array = NDArray[np.float64]
# Amplitudes this small beside the one that a branch started with are on their way to zero: there the Hopf point is the
# orbit to four digits, and the orbit is still known to ten. On curves of special points conditions of the second order
# in the amplitude hold as well, of which rounding leaves too little there.
NEAR, NEAR_ON_CURVES = 1e-4, 1e-2
# Orbits whose event is crossed the wrong way lie beyond the equilibrium if they are this small beside the first; larger
# ones have met their event's surface with no speed.
SMALL = 0.2
# Code of the reason why a branch ends here.
SHRINKS = "shrinks"


@dataclass(frozen=True, eq=False)
class AmplitudeBoundary:
    """The amplitude of orbits that can shrink to an equilibrium stays above ``near`` times that of the ``first``.

    ``sizes`` (n_states,) are what states count by.
    """

    sizes: Array
    first: float
    near: float
    approach: Approach = Approach.TOWARDS
    end: str = End.SHRINKS

    @property
    def least(self) -> float:
        """The least amplitude."""
        return self.near * self.first

    def margins(self, at: AtOrbit) -> Array:
        """Return by how much the signed amplitude exceeds the least one; no margin for orbits that cannot shrink so."""
        rates = self._find_rates(at.orbit)
        return np.zeros(0) if rates is None else np.array([np.sum(rates * at.orbit.values) - self.least])

    def gradients(self, at: AtOrbit) -> Array:
        """Return its derivatives in the unknowns."""
        rates = self._find_rates(at.orbit)
        if rates is None:
            return np.zeros((0, len(at.orbit.x)))
        result = np.zeros((1, len(at.orbit.x)))
        result[0, at.orbit.problem.unknowns.values] = rates.ravel()
        return result

    def reason(self, at: AtOrbit, k: int) -> Reason:
        """Return that the orbit shrinks."""
        return make_reason(SHRINKS)

    def _find_rates(self, orbit: Orbit) -> Array | None:
        """Return the rates of the signed amplitude in the base values, shape (n_base, n_states)."""
        if not can_shrink(orbit):
            return None
        reference = orbit.problem.reference
        away = _centre(orbit.values if reference is None else reference, self.sizes)
        length = float(np.sqrt(np.mean(away**2)))
        small = reference is None and length < SMALL * self.first
        sign = -1.0 if small and _is_upside_down(orbit) else 1.0
        return sign * away / (away.size * (length or 1.0) * self.sizes)


def bound_amplitude(orbit: Orbit) -> AmplitudeBoundary:
    """Return the boundary of the branch, or with two free parameters of the curve, that starts with an orbit."""
    sizes, near = measure_states(orbit.values), NEAR if len(orbit.free) < 2 else NEAR_ON_CURVES
    return AmplitudeBoundary(sizes, measure_size(orbit, sizes), near)


def can_shrink(orbit: Orbit) -> bool:
    """Return whether an orbit is one of an autonomous model, whose events neither move a state nor change the field."""
    model = orbit.numeric.model
    jumps = any(model.resets[s.reset] != model.state_symbols for s in orbit.signature.segments if s.event)
    return not model.forced and not jumps and len({model.modes[s.mode] for s in orbit.signature.segments}) == 1


def measure_size(orbit: Orbit, sizes: Array) -> float:
    """Return an orbit's amplitude: the root mean square of its base values about their mean, in ``sizes``."""
    return float(np.sqrt(np.mean(_centre(orbit.values, sizes) ** 2)))


def _centre(values: Array, sizes: Array) -> Array:
    return np.asarray((values - np.mean(values, axis=0)) / sizes)


def _is_upside_down(orbit: Orbit) -> bool:
    """Return whether an event is crossed against its direction, as it is by orbits beyond the equilibrium."""
    for s, segment in enumerate(orbit.signature.segments):
        sign = SIGNS.get(segment.direction, 0)
        if segment.event and sign and orbit.numeric.model.events[segment.event].function is not None:
            return sign * find_event_profile(orbit, segment.event).end_slope(s) < 0.0
    return False
