"""How far unknowns are from a periodic orbit.

Rows, in this order (c runs over collocation points, s over segments):

    collocation   z'(c) - h f_m(t_c, z, z(t - tau), p)        n_collocation * n_states   (z' = dz/dsigma)
    resets        z_{s+1}(start) - g_s(z_s(end))              S * n_states
    events        h_s(z_s(end)), or time since its source - tau   S   (an orbit without events: its phase condition)
    breaking      b - tau(z(b)) - source                  J   (breaking times of delays that vary)
    period        sum T_s - k * forcing period                1 if forced
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import ArrayFunction
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.problem import OrbitProblem
from pddecont.orbit.signature import DelayedEventLink
from pddecont.orbit.unknowns import Unknowns

Array = NDArray[np.float64]
Ints = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Rows:
    """Places of the equations in the residual."""

    unknowns: Unknowns

    @property
    def n_collocation(self) -> int:
        """Number of collocation equations."""
        return self.unknowns.mesh.n_collocation * self.unknowns.n_states

    @property
    def resets(self) -> int:
        """First reset equation."""
        return self.n_collocation

    @property
    def events(self) -> int:
        """First event equation."""
        return self.resets + self.unknowns.mesh.n_segments * self.unknowns.n_states

    @property
    def breaking(self) -> int:
        """First equation of a breaking time."""
        return self.events + self.unknowns.mesh.n_segments

    @property
    def period(self) -> int:
        """The period equation of a forced orbit."""
        return self.breaking + self.unknowns.mesh.n_breaking

    @property
    def size(self) -> int:
        """Number of equations."""
        return self.period + self.unknowns.forced


def group_by_mode(problem: OrbitProblem) -> list[tuple[str, Ints]]:
    """Return each mode of the orbit with the collocation points that run in it."""
    mesh = problem.mesh

    def find() -> list[tuple[str, Ints]]:
        of_interval = np.array([problem.segments[s].mode for s in mesh.segment])
        of_point = np.repeat(of_interval, mesh.degree)
        return [(mode, np.flatnonzero(of_point == mode)) for mode in dict.fromkeys(of_interval.tolist())]

    return mesh.always(("modes", problem.signature), find)


def group_by_reset(problem: OrbitProblem) -> list[tuple[str, Ints]]:
    """Return each reset of the orbit with the segments at whose ends it happens."""

    def find() -> list[tuple[str, Ints]]:
        resets = np.array([segment.reset for segment in problem.segments])
        return [(reset, np.flatnonzero(resets == reset)) for reset in dict.fromkeys(resets.tolist())]

    return problem.mesh.always(("resets", problem.signature), find)


def compute_residual(orbit: Orbit) -> Array:
    """Return the residual of an orbit's unknowns, shape (n_equations,)."""
    problem, mesh, n = orbit.problem, orbit.mesh, orbit.numeric.n_states
    reads, p = orbit.equation_reads, orbit.parameters
    rows = Rows(problem.unknowns)
    result = np.empty(rows.size)
    h = np.repeat(reads.h, mesh.degree)
    slope = np.matmul(mesh.basis.slopes, orbit.values[mesh.base_index]).reshape(-1, n)
    collocation = result[: rows.n_collocation].reshape(-1, n)
    for mode, points in group_by_mode(problem):
        f = problem.numeric.mode(mode).value(reads.t[points], reads.x[:, points], reads.xd[:, points], p)
        collocation[points] = slope[points] - h[points, None] * f.T
    starts = orbit.values[np.roll(mesh.first_base, -1)]
    resets = result[rows.resets : rows.events].reshape(-1, n)
    for reset, which in group_by_reset(problem):
        resets[which] = starts[which] - evaluate_at_ends(problem.numeric.reset(reset), orbit, which).T
    result[rows.events : rows.breaking] = _end_residuals(orbit)
    result[rows.breaking : rows.period] = _breaking_residuals(orbit)
    if problem.numeric.model.forced:
        result[rows.period] = orbit.period - problem.n_periods * problem.numeric.period.value(p)[0]
    return result


def _end_residuals(orbit: Orbit) -> Array:
    """Return what is left of the equation that ends each segment, shape (n_segments,)."""
    problem = orbit.problem
    links = {link.segment: link for link in problem.links}
    result = np.empty(len(problem.segments))
    for s, segment in enumerate(problem.segments):
        if s in links:
            elapsed = find_elapsed_weights(problem, links[s]) @ orbit.theta[: orbit.mesh.n_segments]
            result[s] = elapsed - _find_link_delay(orbit, links[s])
        elif segment.event:
            result[s] = evaluate_at_ends(problem.numeric.event(segment.event), orbit, np.array([s]))[0, 0]
        elif problem.numeric.model.forced:
            result[s] = orbit.start - problem.phase
        else:
            result[s] = phase_weights(problem) @ np.ravel(orbit.values)
    return result


def _find_link_delay(orbit: Orbit, link: DelayedEventLink) -> float:
    """Return the delay after which the end of a segment's source ends it."""
    varying = link.find_varying(orbit.numeric.model)
    if varying is not None:
        return float(orbit.equation_reads.lags[varying, orbit.mesh.n_collocation + link.segment])
    return float(link.make_delay(orbit.problem.signature).value(orbit.parameters)[0])


def _breaking_residuals(orbit: Orbit) -> Array:
    """Return how far from its source each breaking time reads, shape (J,)."""
    mesh, n_constant = orbit.mesh, len(orbit.numeric.model.delays)
    first, theta = mesh.n_collocation + mesh.n_segments, orbit.theta
    reads = [
        float(orbit.equation_reads.lags[b.delay - n_constant, first + j] + b.source @ theta)
        for j, b in enumerate(mesh.breaking)
    ]
    return np.asarray(theta[len(theta) - mesh.n_breaking :] - np.array(reads))


def evaluate_at_ends(function: ArrayFunction, orbit: Orbit, segments: Ints) -> Array:
    """Return a function's values at the ends of some segments, shape (n_out, len(segments))."""
    reads, i = orbit.equation_reads, orbit.mesh.n_collocation + segments
    return function.value(reads.t[i], reads.x[:, i], reads.xd[:, i], orbit.parameters)


def phase_weights(problem: OrbitProblem) -> Array:
    """Return the weights of the integral phase condition, integral of z . dz_ref/dsigma = 0.

    The result has shape (n_base * n_states,).
    """
    assert problem.reference is not None, "an autonomous orbit without events needs a reference for its phase"
    mesh = problem.mesh
    slope = np.einsum("ib,jbn->jin", mesh.basis.slopes, problem.reference[mesh.base_index])
    local = np.einsum("i,ib,jin->jbn", mesh.basis.weights, mesh.basis.values, slope)
    weights = np.zeros((mesh.n_base, problem.numeric.n_states))
    np.add.at(weights, mesh.base_index, local)
    return np.ravel(weights)


def find_elapsed_weights(problem: OrbitProblem, link: DelayedEventLink) -> Array:
    """Return the weights of the durations in the time from a delayed event's source to the event, shape (S,)."""
    weights = np.full(problem.mesh.n_segments, float(link.wraps))
    weights[: link.segment + 1] += 1.0
    weights[: link.source + 1] -= 1.0
    return weights
