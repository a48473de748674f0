"""The settings that a ``precision`` step compares, in order."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

from pddecont.orbit.meshing import MeshRule
from pddecont.steps.schema import Delay, Precision

INTERVALS = (8, 16, 32)
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10)


@dataclass(frozen=True)
class OrbitSetting:
    """A way to find delayed values, ``explicit`` where a chain's stages are states of their own, and a mesh rule."""

    delay: Delay
    explicit: bool
    rule: MeshRule

    @property
    def family(self) -> str:
        """What a user would choose between: the method without its numbers of points."""
        if self.delay.method == "direct":
            return "direct" if self.delay.track_breaking_points is not False else "direct, not tracked"
        if self.delay.method == "chebyshev":
            return "chebyshev"
        return f"chain of order {self.delay.order or 2}{', explicit states' if self.explicit else ''}"

    @property
    def n(self) -> int:
        """Number of Taylor steps or Chebyshev points (0: the method has none)."""
        return 0 if self.delay.method == "direct" else self.delay.n or (15 if self.delay.method == "chain" else 16)


@dataclass(frozen=True)
class RunSetting:
    """An integrator and its relative tolerance."""

    integrator: str
    tolerance: float


def orbit_settings(body: Precision) -> list[OrbitSetting]:
    """Return the settings of a step that compares orbits."""
    delays = [(delay, compared.states == "explicit") for compared in body.methods for delay in compared.delays()]
    if body.tolerances is not None:
        rules = [MeshRule(degree, None, tol) for degree, tol in product(body.degrees, body.tolerances)]
    else:
        rules = [MeshRule(degree, intervals) for degree, intervals in product(body.degrees, body.intervals or INTERVALS)]
    return [OrbitSetting(delay, explicit, rule) for (delay, explicit), rule in product(delays, rules)]


def run_settings(body: Precision) -> list[RunSetting]:
    """Return the settings of a step that compares simulations."""
    return [RunSetting(*pair) for pair in product(body.integrators or ("explicit", "stiff"), body.tolerances or TOLERANCES)]
