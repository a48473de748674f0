"""On which side of a curve in two parameters the orbit keeps its signature, or is stable."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.bifurcation import grazing, period_doubling, tangency, torus
from pddecont.bifurcation.conditioned import SpecialCurve

Array = NDArray[np.float64]


def side_of(special: SpecialCurve, x: Array) -> Array:
    """Return the direction in the plane of the two parameters in which the condition falls or grows towards the good side.

    Shape (2,), of length one in units of the parameters' ranges; NaN for a fold, whose two orbits lie over one side and none over
    the other, and for user functions.
    """
    sign = {grazing.KIND: -1.0, period_doubling.KIND: 1.0, torus.KIND: -1.0, tangency.KIND: 1.0}.get(special.condition.kind)
    if sign is None:
        return np.full(2, np.nan)
    if isinstance(special.condition, grazing.Graze) and not special.condition.is_max:
        sign = 1.0
    directions = special.directions(x)
    ranges = special.metric().scale[special.problem.layout.free]
    in_plane = directions[:, special.problem.layout.free] / ranges
    if abs(np.linalg.det(in_plane)) < 1e-12:
        return np.full(2, np.nan)
    gradient = sign * np.linalg.solve(in_plane, special.slopes(x, directions))
    length = float(np.linalg.norm(gradient))
    return gradient / length * ranges if length > 0.0 else np.full(2, np.nan)
