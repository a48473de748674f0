"""Orbits to arrays and back: what a results file keeps of an orbit, and all that is needed to go on from it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.orbit.mesh import Mesh, Piece
from pddecont.orbit.problem import OrbitProblem

Array = NDArray[np.float64]
# The highest degree that a run file may ask for.
MAX_DEGREE = 20


def to_rows(problem: OrbitProblem, x: Array, tangent: Array | None = None) -> dict[str, Array]:
    """Return the arrays that a results file keeps of the orbit ``x``.

    ``time`` (physical), ``states`` (n_base, n_states) and ``segment`` have one row a base point; ``unknowns`` are durations,
    start and free parameters; ``mesh`` is the mesh as one row of numbers (:func:`mesh_to_row`).
    """
    values, durations, start, free = problem.layout.split(x)
    times = start + problem.mesh.base_times(problem.theta(x))
    segment = np.empty(problem.mesh.n_base)
    segment[problem.mesh.base_index] = problem.mesh.segment[:, None]
    return {
        "time": times, "states": values, "segment": segment,
        "unknowns": np.concatenate([durations, [start], free]),
        "tangent": np.zeros(0) if tangent is None else tangent,
        "mesh": mesh_to_row(problem.mesh),
        "signature": np.frombuffer(" ".join(s.name for s in problem.segments).encode(), dtype=np.uint8),
    }  # fmt: skip


def from_rows(problem: OrbitProblem, rows: Mapping[str, Any]) -> Array:
    """Return the unknowns of ``problem`` (whose mesh is that of the rows) for a recorded orbit."""
    n = problem.mesh.n_segments
    unknowns = rows["unknowns"]
    free = problem.parameters[list(problem.free_index)]
    return problem.layout.join(rows["states"], unknowns[:n], float(unknowns[n]), free)


def mesh_to_row(mesh: Mesh) -> Array:
    """Return a mesh as one array of numbers; inverse of :func:`mesh_from_row`."""
    n_theta = len(mesh.pieces[0].start)
    parts = [np.array([mesh.degree, mesh.n_segments, n_theta, len(mesh.pieces)], dtype=float)]
    for piece in mesh.pieces:
        parts += [np.array([piece.segment, len(piece.cuts)], dtype=float), piece.start, piece.end, piece.cuts]
    return np.concatenate([*parts, np.zeros(0) if mesh.anchor is None else mesh.anchor])


def mesh_from_row(row: Array) -> Mesh:
    """Return the mesh that :func:`mesh_to_row` wrote."""
    degree, n_segments, n_theta, n_pieces = (int(v) for v in row[:4])
    if not (1 <= degree <= MAX_DEGREE and 1 <= n_segments <= len(row) and 1 <= n_theta <= len(row) and 1 <= n_pieces <= len(row)):
        raise ValueError("the row is not that of a mesh")
    at, pieces = 4, []
    for _ in range(n_pieces):
        segment, n_cuts = int(row[at]), int(row[at + 1])
        if not (0 <= segment < n_segments and n_cuts >= 0 and at + 2 + 2 * n_theta + n_cuts <= len(row)):
            raise ValueError("the row is not that of a mesh")
        at += 2
        start, end = row[at : at + n_theta], row[at + n_theta : at + 2 * n_theta]
        at += 2 * n_theta
        pieces.append(Piece(segment, start.copy(), end.copy(), row[at : at + n_cuts].copy()))
        at += n_cuts
    return Mesh(degree, n_segments, tuple(pieces), row[at:].copy() if len(row) > at else None)
