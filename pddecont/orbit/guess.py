"""From the last cycle of a trajectory to an orbit's unknowns on a mesh."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pddecont.delay.operator import DelayMethod
from pddecont.model.codegen import NumericModel
from pddecont.model.system import check_signature
from pddecont.orbit.mesh import Mesh, Places, equal_cuts, segment_pieces, share_intervals
from pddecont.orbit.problem import OrbitProblem, eventless
from pddecont.simulate.recognise import Cycle

Array = NDArray[np.float64]


def fixed_mesh(durations: Array, n_delays: int, degree: int, n_intervals: int) -> Mesh:
    """Return a mesh of ``n_intervals`` intervals of nearly equal length, at least one a segment."""
    counts = share_intervals(durations, max(n_intervals, len(durations)))
    return Mesh(degree, len(durations), segment_pieces(len(durations), len(durations) + n_delays, equal_cuts(counts)))


def orbit_from_cycle(numeric: NumericModel, p: Array, delay: DelayMethod, cycle: Cycle, degree: int,
                     n_intervals: int) -> tuple[OrbitProblem, Array]:  # fmt: skip
    """Return the boundary-value problem of a cycle's signature and the cycle as first guess of its unknowns."""
    model = numeric.model
    check_signature(model, cycle.signature)
    segments = tuple(model.segments[name] for name in cycle.signature) or (eventless(cycle.mode),)
    durations = np.diff(cycle.times)
    mesh = fixed_mesh(durations, len(model.delays), degree, n_intervals)
    times = cycle.times[0] + mesh.base_times(np.concatenate([durations, numeric.delays.value(p)]))
    values = np.empty((mesh.n_base, numeric.n_states))
    for s, arc in enumerate(cycle.arcs):
        inside = slice(mesh.first_base[s], mesh.last_base[s] + 1)
        values[inside] = [arc(t) for t in times[inside]]
    start = 0.0
    if model.forced:
        period = float(numeric.period.value(p)[0])
        start = cycle.times[0] % period
    reference = values if not cycle.signature and not model.forced else None
    problem = OrbitProblem(numeric, segments, mesh, delay, p, (), cycle.n_periods, reference, start)
    return problem, problem.layout.join(values, durations, start, np.zeros(0))


def interpolate_orbit(problem: OrbitProblem, x: Array, degree: int, n_intervals: int) -> tuple[OrbitProblem, Array]:
    """Return the orbit ``x`` on a fixed mesh of another degree or number of intervals."""
    n_delays = len(problem.numeric.model.delays)
    return on_mesh(problem, x, fixed_mesh(x[problem.layout.durations], n_delays, degree, n_intervals))


def on_mesh(problem: OrbitProblem, x: Array, mesh: Mesh) -> tuple[OrbitProblem, Array]:
    """Return the orbit ``x`` on another mesh of the same segments, read from its own polynomials."""
    values, durations, start, free = problem.layout.split(x)
    new = replace(problem, mesh=mesh)
    theta = problem.theta(x)
    if problem.reference is not None:
        new = replace(new, reference=transfer(problem.mesh, mesh, theta, problem.reference))
    return new, new.layout.join(transfer(problem.mesh, mesh, theta, values), durations, start, free)


def transfer(old: Mesh, new: Mesh, theta: Array, values: Array) -> Array:
    """Return base values (n_base, n) of ``old`` at the base points of ``new``."""
    times, edges, lengths = new.base_times(theta), old.start @ theta, old.length @ theta
    result = np.empty((new.n_base, values.shape[1]))
    for s in range(new.n_segments):
        inside = np.flatnonzero(old.segment == s)
        rows = np.arange(new.first_base[s], new.last_base[s] + 1)
        interval = inside[np.clip(np.searchsorted(edges[inside], times[rows], side="right") - 1, 0, len(inside) - 1)]
        sigma = np.clip((times[rows] - edges[interval]) / lengths[interval], 0.0, 1.0)
        result[rows] = old.at(values, Places(interval, sigma))
    return result
