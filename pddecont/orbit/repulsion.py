"""Surfaces that an orbit is put on: where the field beyond points away too, nothing decides how the motion goes on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.model import ABOVE, BELOW, DerivedModes
from pddecont.orbit.guards import evaluate_after
from pddecont.orbit.orbit import Orbit
from pddecont.reasons import Reason, make_reason

Array = NDArray[np.float64]
# A function below this part of what it changes by along the orbit is zero.
RELATIVE_ZERO = 1e-9


@dataclass(frozen=True)
class Repeller:
    """The surface of switch ``switch``, which segment ``s`` puts an orbit on that then goes on beside it."""

    derived: DerivedModes
    s: int
    switch: int

    def measure(self, orbit: Orbit) -> float:
        """Return how fast the field on the other side leads to the surface: negative where it points away too."""
        (below, above), (size_below, size_above) = self._find_rates(orbit)
        is_above = self.derived.find_digits(self._find_mode(orbit))[self.switch] == ABOVE
        return float(below / size_below if is_above else -above / size_above)

    def explain(self, orbit: Orbit) -> Reason:
        """Return the reason that says that both fields point away."""
        (below, above), _ = self._find_rates(orbit)
        digits = self.derived.find_digits(self._find_mode(orbit)) or ()
        return make_reason(
            "repels",
            number=self.s + 1,
            segment=orbit.signature.segments[self.s].name,
            switch=self.derived.equations.switches[self.switch].name,
            surface=str(self.derived.surfaces.find_function(self.switch, digits)),
            time=float(orbit.event_times[self.s + 1]),
            below=float(below),
            above=float(above),
        )

    def _find_mode(self, orbit: Orbit) -> str:
        return orbit.signature.segments[self.s].to

    def _find_rates(self, orbit: Orbit) -> tuple[Array, Array]:
        """Return du/dt along the fields below and above the surface, and their sizes."""
        digits = self.derived.find_digits(self._find_mode(orbit)) or ()
        values, sizes = evaluate_after(orbit, [self.s], self.derived.surfaces.find_bounds(self.switch, digits))
        return values[:, 0], sizes[:, 0]


def list_repellers(orbit: Orbit) -> list[Repeller]:
    """Return the surfaces that events put an orbit on, and that it neither crosses nor slides along."""
    derived, found = orbit.numeric.model.derived, []
    for s, segment in enumerate(orbit.signature.segments if derived is not None else ()):
        assert derived is not None, "there are segments"
        for k in segment.anew:
            digits = derived.find_digits(segment.to) or ()
            if digits[k] in (ABOVE, BELOW):
                u = derived.surfaces.find_function(k, digits)
                values, sizes = evaluate_after(orbit, [s], (u,))
                if abs(values[0, 0]) <= RELATIVE_ZERO * sizes[0, 0]:
                    found.append(Repeller(derived, s, k))
    return found
