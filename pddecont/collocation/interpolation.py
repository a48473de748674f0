"""Piecewise polynomials from one mesh to another."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation.mesh import Mesh, MeshPoints
from pddecont.native import compiled_assembly

Array = NDArray[np.float64]


def transfer(old: Mesh, old_theta: Array, values: Array, new: Mesh, new_theta: Array) -> Array:
    """Return base ``values`` (n_base, n) of ``old`` at the base points of ``new``.

    A base point reads the old polynomials at the same fraction of its segment, so the two meshes may differ in their
    segment durations. The old intervals may have passed one another at ``old_theta`` (:func:`_read_folded`).
    """
    n_points = new.n_base
    result, owner = np.empty((n_points, values.shape[1])), np.empty(n_points, dtype=np.intp)
    times, sigma = np.empty((2, n_points))
    starts, lengths = old.evaluate_edges(old_theta)
    compiled_assembly.transfer_values(
        *new.evaluate_edges(new_theta),
        new.segment,
        new.n_intervals,
        new.basis.base,
        new.degree + 1,
        np.ascontiguousarray(new_theta),
        starts,
        lengths,
        old.last_interval,
        old.basis.base,
        old.basis.barycentric,
        old.degree + 1,
        np.ascontiguousarray(old_theta),
        np.ascontiguousarray(values),
        values.shape[1],
        times,
        owner,
        sigma,
        np.empty((n_points, old.degree + 1)),
        result,
    )
    if np.any(lengths < 0.0):
        for s in np.unique(old.segment[lengths < 0.0]).tolist():
            rows = np.arange(new.first_base[s], new.last_base[s] + 1)
            result[rows] = _read_folded(old, old_theta, values, s, times[rows])
    return result


def _read_folded(mesh: Mesh, theta: Array, values: Array, s: int, times: Array) -> Array:
    """Return the polynomials of a segment at ``times`` (n,) where some intervals end before they begin.

    Let breaking points a < b pass one another, and P1, P2, P3 be the solution before a, between them, and after b. What
    jumps at a is P2 - P1, at b P3 - P2; with b before a the solution between them is P1 + (P3 - P2), for jumps of small
    size. All three intervals lie over that part of time, P2 the wrong way round: so every interval over a time counts,
    with the sign of its length. Shape (n, n_quantities).
    """
    intervals = np.flatnonzero(mesh.segment == s)
    left, lengths = (mesh.start @ theta)[intervals], (mesh.length @ theta)[intervals]
    # Neighbours share their edge to the last bit: with signs, every time then has one interval over it.
    edges = np.append(left, left[-1] + lengths[-1])
    low, high = np.minimum(edges[:-1], edges[1:]), np.maximum(edges[:-1], edges[1:])
    inside = np.clip(times, edges[0], np.nextafter(edges[-1], edges[0]))
    over = (low <= inside[:, None]) & (inside[:, None] < high)
    which, among = np.nonzero(over)
    # By its own length one between edges that are the same to rounding may have none.
    widths = np.diff(edges)[among]
    points = MeshPoints(intervals[among], np.clip((inside[which] - left[among]) / widths, 0.0, 1.0))
    result = np.zeros((len(times), values.shape[1]))
    np.add.at(result, which, np.sign(widths)[:, None] * mesh.interpolate(values, points))
    return result


def raise_degree(mesh: Mesh, reference_theta: Array) -> Mesh:
    """Return the mesh with the same intervals and polynomials of one degree more."""

    def raise_whole() -> Mesh:
        raised = replace(mesh, degree=mesh.degree + 1, reference_theta=None, reference_lags=None)
        raised.take_edges(mesh)
        raised.take_layout(mesh)
        # Found here, these are found for all orbits on such meshes.
        _ = raised.equation_points, raised.first_base, raised.last_base
        return raised

    return mesh.always("raised", raise_whole).anchor(reference_theta)


def resample(mesh: Mesh, values: Array, other: Mesh) -> Array:
    """Return base ``values`` (n_base, n) at the base points of a mesh with the same intervals and another degree."""
    points = mesh.alike(("resampled", other.degree), lambda: mesh.grid(other.basis.base))
    result = np.empty((other.n_base, values.shape[1]))
    result[other.base_index.ravel()] = mesh.interpolate(values, points)
    return result
