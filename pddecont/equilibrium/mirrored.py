"""Bogdanov-Takens points of symmetric equilibria, at which a curve of Hopf points meets its mirror image.

There omega^2 is zero to the second order, and the curve crosses the one of the equilibria that are their own image: no
point near it can be corrected along the curve. It is solved for with omega^2 = 0 by steps of least squares from the
cubic through the points on both sides. In the direction in which the curve passes it is known to the root of rounding,
in all others, parameters among them, to rounding.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline

from pddecont.continuation import CurvePoint
from pddecont.equilibrium.critical import CriticalEvaluation
from pddecont.errors import ConvergenceError

Array = NDArray[np.float64]
Point = CurvePoint[CriticalEvaluation]
# Where the square of the frequency is among the unknowns.
SQUARE = -3
# The cubic says that the curve touches omega = 0 where what is left is such a part of omega^2 at the ends.
TOUCHES = 0.02
# Singular values below this part of the largest one are zero; steps at most, and how small residuals have to become.
RANK, MAX_ITERATIONS, SOLVED = 1e-6, 40, 1e-11


def find_mirrored(before: Point, after: Point) -> Point | None:
    """Return the point between two of a curve of Hopf points at which it touches omega = 0; None if it does not."""
    scaling = before.system.scaling
    chord = after.x - before.x
    ends = [point.tangent * np.sign(scaling.dot(point.tangent, chord)) for point in (before, after)]
    slopes = [end * scaling.length(chord) / scaling.length(end) for end in ends]
    way = CubicHermiteSpline([0.0, 1.0], np.stack([before.x, after.x]), np.stack(slopes))
    turns = CubicHermiteSpline([0.0, 1.0], [p.x[SQUARE] for p in (before, after)], [s[SQUARE] for s in slopes])
    places = turns.derivative().roots(extrapolate=False)
    largest = max(before.x[SQUARE], after.x[SQUARE])
    touching = [t for t in places.tolist() if abs(float(turns(t))) <= TOUCHES * largest]
    if len(touching) != 1:
        return None
    x = _solve(before, np.asarray(way(touching[0])))
    return None if x is None else replace(before, at=before.system.at(x), solution=None, direction=chord)


def _solve(near: Point, x: Array) -> Array | None:
    """Return the unknowns with omega^2 = 0 that solve the equations of a curve."""
    scale = near.system.scaling.scale
    row = np.zeros(len(x))
    row[SQUARE] = 1.0
    for _ in range(MAX_ITERATIONS):
        try:
            at = near.system.at(x)
            residual = np.append(at.residual, x[SQUARE] / scale[SQUARE])
            matrix = np.vstack([np.asarray(at.jacobian()) * scale, row])
        except ConvergenceError:
            return None
        if np.max(np.abs(residual)) <= SOLVED:
            return x
        step = np.linalg.lstsq(matrix, -residual, rcond=RANK)[0]
        x = x + scale * step
    return None
