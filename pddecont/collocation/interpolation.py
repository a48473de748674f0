"""Piecewise polynomials from one mesh to another."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation.mesh import Mesh

Array = NDArray[np.float64]


def transfer(old: Mesh, old_theta: Array, values: Array, new: Mesh, new_theta: Array) -> Array:
    """Return base ``values`` (n_base, n) of ``old`` at the base points of ``new``.

    A base point reads the old polynomials at the same fraction of its segment, so the two meshes may differ in their
    segment durations.
    """
    times, n = new.base_times(new_theta), new.n_segments
    old_ends = np.concatenate([[0.0], np.cumsum(old_theta[:n])])
    new_ends = np.concatenate([[0.0], np.cumsum(new_theta[:n])])
    result = np.empty((new.n_base, values.shape[1]))
    for s in range(n):
        rows = np.arange(new.first_base[s], new.last_base[s] + 1)
        at = old_ends[s] + (times[rows] - new_ends[s]) * (old_theta[s] / new_theta[s])
        points, _ = old.locate(old_theta, at, segment=s)
        result[rows] = old.interpolate(values, points.clipped())
    return result


def raise_degree(mesh: Mesh, reference_theta: Array) -> Mesh:
    """Return the mesh with the same intervals and polynomials of one degree more."""
    return replace(mesh, degree=mesh.degree + 1, reference_theta=reference_theta)


def resample(mesh: Mesh, values: Array, other: Mesh) -> Array:
    """Return base ``values`` (n_base, n) at the base points of a mesh with the same intervals and another degree."""
    result = np.empty((other.n_base, values.shape[1]))
    result[other.base_index.ravel()] = mesh.interpolate(values, mesh.grid(other.basis.base))
    return result
