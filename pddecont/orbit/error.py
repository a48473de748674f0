"""How far an orbit is from solving its equation between the collocation points, interval by interval.

The defect d = z' - h f vanishes at the Gauss points and is nearly c * omega(sigma), omega the polynomial with those
roots, in between. Measured at one point near each end of an interval it gives c, and the error that it leaves inside
the interval is c * max |integral of omega| (superconvergence makes the error at the interval's ends smaller).

Reference: Ascher, Mattheij, Russell (1995), section 9.3; Kierzenka, Shampine, ACM TOMS 27 (2001).
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation import MeshPoints, make_basis
from pddecont.delay import FullWeights
from pddecont.orbit.orbit import Orbit

Array = NDArray[np.float64]
Ints = NDArray[np.intp]
# A state that swings by less than this part of its modulus counts by its modulus: rounding leaves no digits of so small
# a swing.
STILL = 1e-5
# A state no larger than this is zero, to rounding.
ZERO = 1e-13


def estimate_interval_errors(orbit: Orbit) -> Array:
    """Return each mesh interval's error estimate relative to the size of each state, shape (n_intervals,)."""
    return orbit.once("interval errors", lambda: _interval_errors(orbit))


def _interval_errors(orbit: Orbit) -> Array:
    mesh, (sigma, weights, slopes) = orbit.mesh, _defect_points(orbit.mesh.degree)
    points = mesh.alike("defect points", lambda: mesh.grid(sigma))
    reads = orbit.read(points)
    slope = np.einsum("cb,jbn->jcn", slopes, orbit.values[mesh.base_index])
    defect = np.empty_like(slope)
    for mode, intervals, inside in mesh.alike(("defects", orbit.signature), lambda: _group_intervals(orbit, points)):
        f = orbit.numeric.mode(mode).value(reads.t[inside], reads.x[:, inside], reads.xd[:, inside], orbit.parameters)
        f = f.T.reshape(-1, len(sigma), f.shape[0])
        defect[intervals] = slope[intervals] - reads.h[intervals, None, None] * f
    scale = measure_states(orbit.values)
    return np.asarray(np.max(np.abs(defect) * weights[None, :, None] / scale, axis=(1, 2)))


def _group_intervals(orbit: Orbit, points: MeshPoints) -> list[tuple[str, Ints, Ints]]:
    """Return each mode of an orbit with the intervals that run in it and those of some points that lie there."""
    modes = np.array([segment.mode for segment in orbit.signature.segments])[orbit.mesh.segment]
    of_points = modes[points.interval]
    return [
        (mode, np.flatnonzero(modes == mode), np.flatnonzero(of_points == mode))
        for mode in dict.fromkeys(modes.tolist())
    ]


def estimate_rounding_error(orbit: Orbit) -> float:
    """Return what rounding errors in the base values can become in the delayed values, relative to the orbit's size.

    A chain of order 3 or more magnifies frequencies near its own by |sum (i w delta)^k / k!|^(-n), at order 4 by up to
    2^n.
    """
    operators = orbit.equation_reads.operators[: len(orbit.numeric.model.delays)]
    full = [op.weights.amplification for op in operators if isinstance(op.weights, FullWeights)]
    return float(np.finfo(float).eps * max(full, default=0.0))


def measure_states(values: Array) -> Array:
    """Return each state's size along an orbit: its largest modulus about its middle, never zero; shape (n_states,).

    A state that hardly moves counts by its largest modulus; one that stays at zero, to rounding, has size one.
    """
    low, high = values.min(axis=0), values.max(axis=0)
    largest = np.maximum(np.abs(low), np.abs(high))
    fallback = np.where(largest > ZERO, largest, 1.0)
    return np.where(_are_still(low, high, largest), fallback, 0.5 * (high - low))


def find_still_states(values: Array) -> NDArray[np.bool_]:
    """Return which states hardly move along an orbit, or stay at zero, to rounding; shape (n_states,)."""
    low, high = values.min(axis=0), values.max(axis=0)
    return _are_still(low, high, np.maximum(np.abs(low), np.abs(high)))


def _are_still(low: Array, high: Array, largest: Array) -> NDArray[np.bool_]:
    """Return of each state whether it hardly moves between its extremes, ``largest`` of which is the larger modulus."""
    still: NDArray[np.bool_] = (0.5 * (high - low) <= STILL * largest) | (largest <= ZERO)
    return still


@cache
def _defect_points(degree: int) -> tuple[Array, Array, Array]:
    """Return where the defect is measured, what turns it into an error, and from base values to slopes there."""
    basis = make_basis(degree)
    nodes = basis.nodes
    sigma = np.array([0.5 * nodes[0], 1.0 - 0.5 * nodes[0]])
    omega = np.polynomial.Polynomial.fromroots(nodes)
    inside = np.concatenate([nodes, [1.0]])
    largest = np.max(np.abs(omega.integ()(inside)))
    return sigma, largest / np.abs(omega(sigma)), basis.lagrange(sigma) @ basis.differentiate
