"""What may grow without bound along a branch of orbits: the period, and how large each state becomes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.orbit.boundaries import AtOrbit
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.verdict import DRIFTS
from pddecont.reasons import Reason, Scalar, make_reason

Array = NDArray[np.float64]
# Code of the reason why a branch ends along an asymptote.
GROWS = "grows"
# A state that is smaller than this part of the largest does not count: one that grows without bound becomes that.
NEGLIGIBLE = 1e-6


@dataclass(frozen=True, eq=False)
class OrbitHorizon:
    """The period, then the largest modulus of each state at the base points, of a branch that began at ``origin``."""

    origin: Array

    def sizes(self, at: AtOrbit) -> Array:
        """Return the period and the states' largest moduli, shape (1 + n_states,); 0 for a negligible state."""
        largest = np.max(np.abs(at.orbit.values), axis=0)
        return np.append(at.orbit.period, np.where(largest > NEGLIGIBLE * np.max(largest), largest, 0.0))

    def rows(self, at: AtOrbit) -> Array:
        """Return the rows whose products with the unknowns they are, shape (1 + n_states, n_unknowns)."""
        orbit = at.orbit
        unknowns, values = orbit.problem.unknowns, orbit.values
        result = np.zeros((1 + values.shape[1], len(orbit.x)))
        result[0, unknowns.durations] = 1.0
        for state, place in enumerate(np.argmax(np.abs(values), axis=0).tolist()):
            result[1 + state, unknowns.value_index[place, state]] = np.sign(values[place, state])
        return result

    def find_parameters(self, at: AtOrbit) -> slice:
        """Return the places of the free parameters among the unknowns."""
        return at.orbit.problem.unknowns.free

    def is_lost(self, violation: Reason) -> bool:
        """Return whether a simulation only ends elsewhere: near a saddle it leaves every orbit in the end."""
        return violation.code == DRIFTS

    def reason(self, at: AtOrbit, k: int, limits: Array, errors: Array) -> Reason:
        """Return what grows, how large it is, and the limits of the free parameters with their errors."""
        orbit: Orbit = at.orbit
        what, name = ("state", orbit.numeric.model.states[k - 1]) if k else ("period", "")
        values: dict[str, Scalar] = {"what": what, "name": name, "value": float(self.sizes(at)[k])}
        for parameter, limit, error in zip(orbit.problem.free, limits.tolist(), errors.tolist(), strict=True):
            values |= {f"limit {parameter}": limit, f"error {parameter}": error}
        return make_reason(GROWS, **values)
