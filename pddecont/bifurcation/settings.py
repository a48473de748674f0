"""What a branch is followed with, as special points need to know it."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from pddecont.collocation import MeshRule
from pddecont.orbit import Monitor, Orbit, PeriodicOrbitSystem, Verifier, measure_orbit
from pddecont.stability import MultiplierCache


@dataclass(frozen=True, eq=False)
class BranchSettings:
    """Free parameters with their ranges, how meshes are made, multipliers if wanted, and what is looked for.

    ``user_functions`` are monitors whose zeros are special points; ``detect`` holds the labels of the kinds of special
    points that are looked for (None: all). ``referee`` simulates orbits to see whether they are motions of the model
    (None: nobody asks).
    """

    free: tuple[str, ...]
    ranges: tuple[tuple[float, float], ...]
    rule: MeshRule
    multipliers: MultiplierCache | None = None
    user_functions: tuple[Monitor, ...] = ()
    detect: Collection[str] | None = None
    referee: Verifier | None = None

    @property
    def widths(self) -> tuple[float, ...]:
        """Widths of the free parameters' ranges."""
        return tuple(high - low for low, high in self.ranges)

    def wants(self, kind: str) -> bool:
        """Return whether special points of ``kind`` are looked for."""
        return self.detect is None or kind in self.detect

    def find_multipliers(self) -> MultiplierCache:
        """Return what finds multipliers, where special points need them whatever was asked for."""
        return self.multipliers or MultiplierCache()

    def make_system(self, orbit: Orbit) -> tuple[PeriodicOrbitSystem, Orbit]:
        """Return the system of orbits with this branch's free parameters, and ``orbit`` in its unknowns."""
        orbit = orbit.with_free(self.free)
        return PeriodicOrbitSystem(orbit.problem, measure_orbit(orbit, self.widths), self.rule), orbit
