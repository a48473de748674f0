"""How far an orbit is from solving its equation between the collocation points, interval by interval.

The defect d = z' - h f vanishes at the Gauss points and is nearly c * omega(sigma), omega the polynomial with those roots,
in between. Measured at one point near each end of an interval it gives c, and the error that it leaves inside the interval
is c * max |integral of omega| (superconvergence makes the error at the interval's ends smaller).

Reference: Ascher, Mattheij, Russell (1995), section 9.3; Kierzenka, Shampine, ACM TOMS 27 (2001).
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from pddecont.delay.operator import FullWeights
from pddecont.orbit.basis import make_basis
from pddecont.orbit.problem import OrbitProblem, read

Array = NDArray[np.float64]
STILL = 1e-5
ZERO = 1e-13


def interval_errors(problem: OrbitProblem, x: Array) -> Array:
    """Return each mesh interval's error estimate relative to the size of each state, shape (n_intervals,)."""
    found: Array = problem.once("interval errors", x, lambda: _interval_errors(problem, x))
    return found


def _interval_errors(problem: OrbitProblem, x: Array) -> Array:
    mesh = problem.mesh
    basis = make_basis(mesh.degree)
    sigma, weights = _checks(mesh.degree)
    places = mesh.grid(sigma)
    reads = read(problem, x, places)
    slope = np.einsum("cb,jbn->jcn", basis.lagrange(sigma) @ basis.differentiate, reads.values[mesh.base_index])
    defect = np.empty_like(slope)
    modes = np.array([problem.segments[s].mode for s in mesh.segment])
    for mode in dict.fromkeys(modes.tolist()):
        inside = np.flatnonzero(np.repeat(modes == mode, len(sigma)))
        f = problem.numeric.mode(mode).value(reads.t[inside], reads.x[:, inside], reads.xd[:, inside], reads.p)
        intervals = modes == mode
        defect[intervals] = slope[intervals] - reads.h[intervals, None, None] * f.T.reshape(-1, len(sigma), f.shape[0])
    scale = state_sizes(reads.values)
    return np.max(np.abs(defect) * weights[None, :, None] / scale, axis=(1, 2))


def rounding_error(problem: OrbitProblem, x: Array) -> float:
    """Return what rounding errors in the base values can become in the delayed values, relative to the orbit's size.

    A chain of order 3 or more magnifies frequencies near its own by |sum (i w delta)^k / k!|^(-n), at order 4 by up to 2^n.
    """
    operators = problem.operators(problem.theta(x), problem.mesh.sites)
    full = [op.weights.amplification for op in operators if isinstance(op.weights, FullWeights)]
    return float(np.finfo(float).eps * max(full, default=0.0))


def state_sizes(values: Array) -> Array:
    """Return each state's size along the orbit: its largest modulus about its middle, never zero; shape (n_states,).

    A state that hardly moves counts by its largest modulus, since rounding leaves no digits of so small a swing; one that stays at
    zero, up to ``ZERO``, has size one.
    """
    swing = 0.5 * np.ptp(values, axis=0)
    largest = np.max(np.abs(values), axis=0)
    fallback = np.where(largest > ZERO, largest, 1.0)
    return np.where((swing > STILL * largest) & (largest > ZERO), swing, fallback)


@cache
def _checks(degree: int) -> tuple[Array, Array]:
    """Return where the defect is measured and what turns it into an error."""
    nodes = make_basis(degree).nodes
    sigma = np.array([0.5 * nodes[0], 1.0 - 0.5 * nodes[0]])
    omega = np.polynomial.Polynomial.fromroots(nodes)
    inside = np.concatenate([nodes, [1.0]])
    largest = np.max(np.abs(omega.integ()(inside)))
    return sigma, largest / np.abs(omega(sigma))
