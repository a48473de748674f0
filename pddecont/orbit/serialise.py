"""Orbits to arrays and back: what a results file keeps of an orbit, and all that is needed to go on from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.collocation import MAX_DEGREE, BreakingTime, Mesh, Piece
from pddecont.delay import DelayMethod
from pddecont.errors import PddecontError
from pddecont.model import Model, Segment
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.problem import OrbitProblem
from pddecont.orbit.signature import Signature, link_delayed_events, make_eventless
from pddecont.orbit.varying_links import link_varying_jumps

Array = NDArray[np.float64]
# Two events at one moment leave a segment of no duration, to rounding; a shorter one, in periods, is damage.
ROUNDING = 1e-12


def orbit_to_rows(orbit: Orbit, tangent: Array | None = None) -> dict[str, Array]:
    """Return the arrays that a results file keeps of an orbit.

    ``time`` (physical), ``states`` (n_base, n_states) and ``segment`` have one row a base point; ``unknowns`` are
    durations, start, free parameters and breaking times; ``mesh`` is the mesh as one row of numbers
    (:func:`mesh_to_row`), ``signature`` the names of the segments, separated by spaces, as bytes.
    """
    mesh = orbit.mesh
    segment = np.empty(mesh.n_base)
    segment[mesh.base_index] = mesh.segment[:, None]
    return {
        "time": orbit.start + mesh.base_times(orbit.theta),
        "states": orbit.values,
        "segment": segment,
        "unknowns": np.concatenate([orbit.durations, [orbit.start], orbit.free, orbit.breaking]),
        "tangent": np.zeros(0) if tangent is None else tangent,
        "mesh": mesh_to_row(mesh),
        "signature": np.frombuffer(" ".join(orbit.signature.names).encode(), dtype=np.uint8),
    }


def orbit_from_rows(
    numeric: NumericModel,
    delay: DelayMethod,
    parameters: Array,
    free: tuple[str, ...],
    rows: Mapping[str, Any],
    n_periods: int,
    phase: float,
) -> Orbit:
    """Return the orbit that :func:`orbit_to_rows` recorded, at the ``parameters`` recorded with it.

    Raises
    ------
    PddecontError
        If it runs through a segment that the model does not have.
    ValueError
        If its unknowns are not finite, or a segment ends before it begins.
    """
    signature = Signature(numeric, read_segments(numeric.model, rows["signature"].tobytes().decode()))
    mesh = mesh_from_row(rows["mesh"])
    durations, start = rows["unknowns"][: mesh.n_segments], float(rows["unknowns"][mesh.n_segments])
    problem = OrbitProblem(signature, mesh, delay, parameters, free, n_periods, None, phase)
    breaking = rows["unknowns"][len(rows["unknowns"]) - mesh.n_breaking :]
    x = problem.unknowns.join(rows["states"], durations, start, parameters[list(problem.free_index)], breaking)
    links = link_delayed_events(signature, parameters, durations)
    if not np.all(np.isfinite(x)) or not np.min(durations) > -ROUNDING * np.sum(np.abs(durations)):
        raise ValueError("its unknowns are not finite, or a segment ends before it begins")
    return link_varying_jumps(Orbit(replace(problem, links=links), x)).with_phase_reference()


def read_segments(model: Model, names: str) -> tuple[Segment, ...]:
    """Return the segments that a recorded signature names; raise PddecontError for one that the model does not have."""
    result = []
    for name in names.split():
        if name.startswith("("):
            result.append(make_eventless(model, name[1:-1]))
        elif name in model.segments:
            result.append(model.segments[name])
        else:
            raise PddecontError(f"the recorded orbit runs through segment '{name}', which this model does not have")
    return tuple(result)


def mesh_to_row(mesh: Mesh) -> Array:
    """Return a mesh as one array of numbers; inverse of :func:`mesh_from_row`."""
    n_theta = len(mesh.pieces[0].start)
    parts = [np.array([mesh.degree, mesh.n_segments, n_theta, len(mesh.pieces)], dtype=float)]
    for piece in mesh.pieces:
        parts += [np.array([piece.segment, len(piece.cuts)], dtype=float), piece.start, piece.end, piece.cuts]
    if mesh.reference_theta is not None:
        parts.append(mesh.reference_theta)
    if mesh.reference_lags is not None:
        n_varying, n_points = mesh.reference_lags.shape
        parts.append(np.array([mesh.n_breaking, n_varying, n_points], dtype=float))
        parts += [np.array([b.delay, b.level, *b.source]) for b in mesh.breaking]
        parts.append(mesh.reference_lags.ravel())
    return np.concatenate(parts)


def mesh_from_row(row: Array) -> Mesh:
    """Return the mesh that :func:`mesh_to_row` wrote; raise ValueError if the row is none."""
    degree, n_segments, n_theta, n_pieces = (int(v) for v in row[:4])
    if not (
        1 <= degree <= MAX_DEGREE
        and 1 <= n_segments <= len(row)
        and 1 <= n_theta <= len(row)
        and n_segments <= n_pieces <= len(row)
    ):
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
    mesh = Mesh(degree, n_segments, tuple(pieces), row[at : at + n_theta].copy() if len(row) > at else None)
    return mesh if len(row) <= at + n_theta else _add_varying(mesh, row[at + n_theta :])


def _add_varying(mesh: Mesh, row: Array) -> Mesh:
    """Return a mesh with its breaking times of delays that vary, and the values of those where equations hold."""
    n_theta = len(mesh.pieces[0].start)
    if len(row) < 3:
        raise ValueError("the row is not that of a mesh")
    n_breaking, n_varying, n_points = (int(v) for v in row[:3])
    size = n_breaking * (2 + n_theta)
    if not (0 <= n_breaking < n_theta and n_varying >= 1 and len(row) == 3 + size + n_varying * n_points):
        raise ValueError("the row is not that of a mesh")
    breaking = tuple(
        BreakingTime(int(b[0]), b[2:].copy(), int(b[1])) for b in row[3 : 3 + size].reshape(n_breaking, 2 + n_theta)
    )
    return replace(mesh, breaking=breaking, reference_lags=row[3 + size :].reshape(n_varying, n_points).copy())
