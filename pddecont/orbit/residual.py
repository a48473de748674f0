"""How far unknowns are from a periodic orbit.

Rows, in this order (c runs over collocation points, s over segments):

    collocation   z'(c) - h f_m(t_c, z, z(t - tau), p)          n_collocation * n_states   (slope on the reference interval)
    resets        z_{s+1}(start) - g_s(z_s(end))                S * n_states
    events        h_s(z_s(end)), or time since its source - tau   S   (an orbit without events: its phase condition)
    period        sum T_s - k * forcing period                  1 if forced
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.model.codegen import ArrayFunction
from pddecont.orbit.layout import Layout
from pddecont.orbit.problem import OrbitProblem, Reads, read

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Rows:
    """Places of the equations in the residual."""

    layout: Layout

    @property
    def n_collocation(self) -> int:
        """Number of collocation equations."""
        return self.layout.mesh.n_collocation * self.layout.n_states

    @property
    def resets(self) -> int:
        """First reset equation."""
        return self.n_collocation

    @property
    def events(self) -> int:
        """First event equation."""
        return self.resets + self.layout.mesh.n_segments * self.layout.n_states

    @property
    def period(self) -> int:
        """The period equation of a forced orbit."""
        return self.events + self.layout.mesh.n_segments

    @property
    def size(self) -> int:
        """Number of equations."""
        return self.period + self.layout.forced


def mode_sites(problem: OrbitProblem) -> list[tuple[str, NDArray[np.intp]]]:
    """Return each mode of the orbit with the collocation points that run in it."""
    mesh = problem.mesh
    of_interval = np.array([problem.segments[s].mode for s in mesh.segment])
    of_point = np.repeat(of_interval, mesh.degree)
    return [(mode, np.flatnonzero(of_point == mode)) for mode in dict.fromkeys(of_interval.tolist())]


def reset_sites(problem: OrbitProblem) -> list[tuple[str, NDArray[np.intp]]]:
    """Return each reset of the orbit with the segments at whose ends it happens."""
    resets = np.array([segment.reset for segment in problem.segments])
    return [(reset, np.flatnonzero(resets == reset)) for reset in dict.fromkeys(resets.tolist())]


def residual(problem: OrbitProblem, x: Array, sites: Reads | None = None) -> Array:
    """Return the residual of the unknowns ``x``, shape (n_equations,); ``sites`` if the orbit has been read already."""
    sites = sites or read(problem, x, problem.mesh.sites)
    mesh, n = problem.mesh, problem.numeric.n_states
    rows = Rows(problem.layout)
    result = np.empty(rows.size)
    h = np.repeat(sites.h, mesh.degree)
    slope = np.matmul(mesh.basis.slopes, sites.values[mesh.base_index]).reshape(-1, n)
    collocation = result[: rows.n_collocation].reshape(-1, n)
    for mode, points in mode_sites(problem):
        f = problem.numeric.mode(mode).value(sites.t[points], sites.x[:, points], sites.xd[:, points], sites.p)
        collocation[points] = slope[points] - h[points, None] * f.T
    starts = sites.values[np.roll(mesh.first_base, -1)]
    resets = result[rows.resets : rows.events].reshape(-1, n)
    for reset, which in reset_sites(problem):
        resets[which] = starts[which] - at_ends(problem.numeric.reset(reset), problem, sites, which).T
    timed = {s: (source, wraps) for s, source, wraps in problem.timers}
    for s, segment in enumerate(problem.segments):
        if s in timed:
            elapsed = timer_weights(problem, s, *timed[s]) @ sites.theta[: mesh.n_segments]
            result[rows.events + s] = elapsed - event_delay(problem, s, sites.p)
        elif segment.event:
            result[rows.events + s] = at_ends(problem.numeric.event(segment.event), problem, sites, np.array([s]))[0, 0]
        elif problem.numeric.model.forced:
            result[rows.events + s] = sites.start - problem.phase
        else:
            result[rows.events + s] = phase_weights(problem) @ np.ravel(sites.values)
    if problem.numeric.model.forced:
        result[rows.period] = problem.period(x) - problem.n_periods * problem.numeric.period.value(sites.p)[0]
    return result


def at_ends(function: ArrayFunction, problem: OrbitProblem, sites: Reads, segments: NDArray[np.intp]) -> Array:
    """Return a function's values at the ends of some segments, shape (n_out, len(segments))."""
    i = problem.mesh.n_collocation + segments
    return function.value(sites.t[i], sites.x[:, i], sites.xd[:, i], sites.p)


def phase_weights(problem: OrbitProblem) -> Array:
    """Return the weights of the integral phase condition, integral of z . dz_ref/dsigma = 0, shape (n_base * n_states,)."""
    assert problem.reference is not None, "an autonomous orbit without events needs a reference for its phase"
    mesh = problem.mesh
    slope = np.einsum("ib,jbn->jin", mesh.basis.slopes, problem.reference[mesh.base_index])
    local = np.einsum("i,ib,jin->jbn", mesh.basis.weights, mesh.basis.values, slope)
    weights = np.zeros((mesh.n_base, problem.numeric.n_states))
    np.add.at(weights, mesh.base_index, local)
    return np.ravel(weights)


def timer_weights(problem: OrbitProblem, s: int, source: int, wraps: int) -> Array:
    """Return the weights of the durations in the time from the end of segment ``source``, ``wraps`` periods back, to that of ``s``."""
    weights = np.full(problem.mesh.n_segments, float(wraps))
    weights[: s + 1] += 1.0
    weights[: source + 1] -= 1.0
    return weights


def event_delay(problem: OrbitProblem, s: int, p: Array) -> float:
    """Return the delay of the delayed event that ends segment ``s``."""
    return float(problem.numeric.event_delay(problem.segments[s].event).value(p)[0])
