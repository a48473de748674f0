"""A periodic orbit as the past of a simulation."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation import make_basis
from pddecont.orbit.orbit import Orbit
from pddecont.simulate import Past, make_extension_basis

Array = NDArray[np.float64]
# Polynomials of a higher degree than a simulation's are cut into so many parts, until those follow them to rounding.
PARTS = (1, 2, 4, 8)
ROUNDING = 1e-13
SIMULATED_DEGREE = 7


def make_past(orbit: Orbit, begin: float, end: float, *, delayed: bool = False) -> Past:
    """Return an orbit, repeated, from ``begin`` or a little before to ``end``, as the past of a simulation.

    Both times count from the orbit's start; those of the result are the model's. Each segment is an arc; an orbit
    without events is one arc. ``delayed``: its delayed values instead of its states.
    """
    mesh, period, n_segments = orbit.mesh, orbit.period, len(orbit.signature)
    start, h = mesh.start @ orbit.theta, mesh.length @ orbit.theta
    lasting = np.flatnonzero(h > 0.0)
    values = orbit.delayed_values if delayed else orbit.values
    extension = _extend(mesh.degree, values[mesh.base_index[lasting]])
    k = extension.shape[1]
    first, last = math.floor(begin / period), math.ceil(end / period)
    turns = np.arange(first, last)
    parts = (np.arange(k) / k)[None, :]
    time = (start[lasting, None] + parts * h[lasting, None]).ravel()
    length = np.repeat(h[lasting] / k, k)
    arc = np.repeat(mesh.segment[lasting], k) if orbit.signature.has_events else np.zeros(len(time), np.int64)
    coefficients = extension.reshape(len(lasting) * k, *extension.shape[2:])
    times = orbit.start + time + period * turns[:, None]
    numbers = arc + (n_segments * (turns - first))[:, None] * orbit.signature.has_events
    every, lengths = np.broadcast_to(np.arange(len(time)), times.shape), np.broadcast_to(length, times.shape)
    kept = times + lengths > orbit.start + begin
    return Past(
        times[kept],
        lengths[kept],
        (times + lengths)[kept],
        numbers[kept].astype(np.int64),
        coefficients[every[kept], 0],
        coefficients[every[kept], 1:],
    ).until(orbit.start + end)


def _extend(degree: int, values: Array) -> Array:
    """Return the extensions of mesh intervals with base ``values`` (n, degree + 1, n_columns) in parts.

    The result has shape (n, n_parts, 1 + N_COEFFICIENTS, n_columns).
    """
    # What all intervals miss is one product.
    side_by_side = values.transpose(1, 0, 2).reshape(degree + 1, -1)
    allowed = ROUNDING * np.max(np.abs(values), axis=(0, 1), initial=0.0)
    for parts in PARTS:
        matrix, missed = _fit(degree, parts)
        if degree <= SIMULATED_DEGREE or parts == PARTS[-1]:
            break
        worst = np.max(np.abs(missed @ side_by_side), axis=0, initial=0.0)
        if np.all(worst.reshape(len(values), -1) <= allowed):
            break
    result: Array = matrix.reshape(-1, degree + 1) @ values
    return result.reshape(len(values), *matrix.shape[:2], values.shape[2])


@cache
def _fit(degree: int, parts: int) -> tuple[Array, Array]:
    """Return what takes base values to the extensions of an interval's parts, and to what these miss.

    Shapes (parts, 1 + N_COEFFICIENTS, degree + 1) and (n_checks, degree + 1).
    """
    basis, nodes = make_basis(degree), make_basis(SIMULATED_DEGREE).base
    places = (np.arange(parts)[:, None] + nodes) / parts
    matrix = np.asarray(np.linalg.solve(make_extension_basis(nodes), basis.lagrange(places)), dtype=np.float64)
    checks = make_basis(2 * degree).nodes
    missed = make_extension_basis(checks) @ matrix - basis.lagrange((np.arange(parts)[:, None] + checks) / parts)
    return matrix, missed.reshape(-1, degree + 1)
