"""The first point of a branch, with its direction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.bifurcation.settings import BranchSettings
from pddecont.continuation import CurvePoint, find_tangent
from pddecont.errors import PddecontError
from pddecont.orbit import Orbit, OrbitEvaluation, PeriodicOrbitSystem

Array = NDArray[np.float64]


class StartError(PddecontError):
    """A branch cannot start from what it was asked to start from."""


@dataclass(frozen=True, eq=False)
class BranchStart:
    """A branch's first point with its direction, towards larger values of the first free parameter.

    ``kind`` is the label of the special points that it follows (empty: orbits). ``one_way`` where the branch begins at
    its first point, or goes on as its own mirror image.
    """

    point: CurvePoint[Any]
    kind: str = ""
    one_way: bool = False


def start_branch(orbit: Orbit, settings: BranchSettings) -> BranchStart:
    """Return the start of the branch of orbits through a solved one."""
    system, orbit = settings.make_system(orbit)
    at = system.at(orbit.x)
    return BranchStart(CurvePoint(system, at, None, find_forward_tangent(system, at)))


def find_forward_tangent(system: PeriodicOrbitSystem, at: OrbitEvaluation) -> Array:
    """Return the unit tangent towards larger values of the first free parameter."""
    towards = np.zeros(len(at.x))
    towards[at.orbit.problem.unknowns.free.start] = 1.0
    return find_tangent(at, system.scaling, towards)
