"""Whether a branch is back where it began: a closed branch has no other end."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation.curve_point import CurvePoint
from pddecont.continuation.locate import BranchSegment
from pddecont.continuation.system import E

Array = NDArray[np.float64]
# How far from both ends of a step the beginning may lie, in lengths of the step, to be looked for on it.
NEAR = 1.5
# A point no farther from the beginning than this, in scaled unknowns, is the beginning.
SAME = 1e-6
# Errors of a point and of the beginning are worth this much distance, and never more than this part of a step.
PER_ERROR, LARGEST = 10.0, 0.05


@dataclass(frozen=True)
class Home(Generic[E]):
    """The point that a branch begins with.

    ``list_images(at)`` returns what the mesh-independent unknowns of the solution ``at`` would be if it were that
    point, in each of the ways in which one solution can be written; ``list_ahead(at)`` the same of a point ahead of it
    on the tangent. ``error(at)`` is the relative error of a solution and of the beginning.
    """

    list_images: Callable[[E], Sequence[Array]]
    list_ahead: Callable[[E], Sequence[Array]]
    error: Callable[[E], float]


def find_return(segment: BranchSegment[E], home: Home[E]) -> float | None:
    """Return the fraction of a step at which the branch is back where it began, on the way that it set out.

    None where it is not.
    """
    index = segment.known[1.0].system.mesh_independent_index
    size = segment.known[1.0].system.scaling.scale[index]

    def measure(away: Array) -> float:
        return float(np.max(np.abs(away / size)))

    def find_way(point: CurvePoint[E]) -> Array:
        """Return the way from a point to the nearest image of the beginning; infinite if there is none."""
        ways = [image - point.mesh_independent_unknowns for image in home.list_images(point.at)]
        return min(ways, key=measure, default=np.full(len(index), np.inf))

    def value(point: CurvePoint[E]) -> float:
        return float(segment.row @ find_way(point))

    length = measure(segment.chord)
    behind = find_way(segment.known[1.0])
    if not measure(behind) < NEAR * length:
        return None
    ahead = find_way(segment.known[0.0])
    if not measure(ahead) < NEAR * length:
        return None
    f0, f1 = float(segment.row @ ahead), float(segment.row @ behind)
    if f0 * f1 >= 0.0:
        return None
    # Where the branch began at another one that it crosses, its point is interpolated from those around.
    fraction = segment.find_zero(value, 0.0, 1.0, f0, f1)
    if fraction is None:
        return None
    point = segment.at(fraction)
    same = SAME + min(PER_ERROR * home.error(point.at), LARGEST * length)
    images = home.list_images(point.at)
    away = [measure(image - point.mesh_independent_unknowns) for image in images]
    nearest = int(np.argmin(away))
    if away[nearest] >= same:
        return None
    onward = home.list_ahead(point.at)[nearest] - images[nearest]
    return fraction if segment.row @ onward > 0.0 else None
