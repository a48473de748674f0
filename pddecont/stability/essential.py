"""How far the essential spectrum of an orbit's linearised map reaches.

Rates that are read delayed, y'(t) = sum_k C_k(t) y'(t - tau_k(t)) + .., make the map from period to period not compact:
besides its multipliers it has an essential spectrum, which the rates alone decide. What collocation makes of it belongs
to the mesh. With M(r) the largest values along the orbit of sum_k |C_k(t)| r^-tau_k(t), entry by entry, rates grow by
no more than r^T over a period T where the spectral radius of M(r) is one.

Reference: Hale, Verduyn Lunel, Introduction to Functional Differential Equations (1993), sections 3.6 and 9.6.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.orbit import Orbit, group_by_mode

Array = NDArray[np.float64]
# Growth over a period outside of which the bound is not looked for, and its relative accuracy.
LEAST, MOST, ACCURACY = 1e-12, 1e12, 1e-6


def find_essential_radius(orbit: Orbit) -> float:
    """Return a bound of the moduli of the essential spectrum of an orbit's linearised map; 0 without delayed rates."""
    if not any(read.derivative for read in orbit.numeric.model.delayed):
        return 0.0
    coefficients, lags = _list_rates(orbit)
    if not len(lags):
        return 0.0
    # Lags of zero would be the present rate itself.
    shares = np.maximum(lags, 0.0) / orbit.period

    def radius(growth: float) -> float:
        whole: Array = np.max(np.sum(coefficients * growth ** -shares[:, :, None, None], axis=0), axis=0)
        return float(np.max(np.abs(np.linalg.eigvals(whole))))

    low, high = LEAST, MOST
    if radius(low) <= 1.0:
        return 0.0
    if radius(high) > 1.0:
        return float("inf")
    while high > (1.0 + ACCURACY) * low:
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if radius(middle) > 1.0 else (low, middle)
    return high


def _list_rates(orbit: Orbit) -> tuple[Array, Array]:
    """Return the moduli of the coefficients of delayed rates, and their lags.

    Shapes (n_delays, n_points, n_states, n_states) and (n_delays, n_points); the points are those of collocation.
    """
    problem, model, reads = orbit.problem, orbit.numeric.model, orbit.equation_reads
    used = set().union(*(e.free_symbols for s in problem.segments for e in model.modes[s.mode]))
    symbols = zip(model.delayed, model.delayed_symbols, strict=True)
    delays = sorted({read.delay for read, symbol in symbols if read.derivative and symbol in used})
    n, n_constant, n_points = orbit.numeric.n_states, len(model.delays), orbit.mesh.n_collocation
    coefficients, lags = np.zeros((len(delays), n_points, n, n)), np.zeros((len(delays), n_points))
    constant = orbit.numeric.delays.value(orbit.parameters)
    for i, k in enumerate(delays):
        lags[i] = constant[k] if k < n_constant else reads.lags[k - n_constant, :n_points]
    for mode, points in group_by_mode(problem) if delays else []:
        function = problem.numeric.mode(mode)
        d = function.derivatives(reads.t[points], reads.x[:, points], reads.xd[:, points], orbit.parameters)
        for row, q, slope in zip(*function.structure().dxd, d.dxd, strict=True):
            read = model.delayed[q] if q < len(model.delayed) else None
            if read is not None and read.derivative and read.delay in delays:
                coefficients[delays.index(read.delay), points, row, read.state] += np.abs(slope)
    return coefficients, lags
