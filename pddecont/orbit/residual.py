"""How far unknowns are from a periodic orbit.

Rows, in this order (c runs over collocation points, s over segments):

    collocation   z'(c) - h f_m(t_c, z, z(t - tau), p)        n_collocation * n_states   (z' = dz/dsigma)
    resets        z_{s+1}(start) - g_s(z_s(end))              S * n_states
    events        h_s(z_s(end)), or time since its source - tau   S   (an orbit without events: its phase condition)
    breaking      b - tau(z(b)) - source                  J   (breaking times of delays that vary)
    period        sum T_s - k * forcing period                1 if forced
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.native import compiled_assembly
from pddecont.native.assembly import Equations
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
        intervals = _group([problem.segments[s].mode for s in mesh.segment.tolist()])
        inside = np.arange(mesh.degree)
        return [(mode, (mesh.degree * which[:, None] + inside).ravel()) for mode, which in intervals]

    return mesh.alike(("modes", problem.signature), find)


def group_by_reset(problem: OrbitProblem) -> list[tuple[str, Ints]]:
    """Return each reset of the orbit with the segments at whose ends it happens."""
    resets = [segment.reset for segment in problem.segments]
    return problem.mesh.alike(("resets", problem.signature), lambda: _group(resets))


def group_by_event(problem: OrbitProblem) -> list[tuple[str, Ints]]:
    """Return each event with a function that ends segments of the orbit, with those segments."""
    linked = {link.segment for link in problem.links}
    events = ["" if s in linked else segment.event for s, segment in enumerate(problem.segments)]
    return [(event, which) for event, which in _group(events) if event]


def _group(names: Sequence[str]) -> list[tuple[str, Ints]]:
    """Return each name with its places."""
    places: dict[str, list[int]] = {}
    for i, name in enumerate(names):
        places.setdefault(name, []).append(i)
    return [(name, np.array(found)) for name, found in places.items()]


def compute_residual(orbit: Orbit) -> Array:
    """Return the residual of an orbit's unknowns, shape (n_equations,)."""
    problem, reads, p = orbit.problem, orbit.equation_reads, orbit.parameters
    rows, equations = Rows(problem.unknowns), _list_functions(problem)
    result, work = np.empty(rows.size), np.empty(max(orbit.numeric.n_states, 1))
    values = np.ascontiguousarray(orbit.values)
    x, xd = np.ascontiguousarray(reads.x.T), np.ascontiguousarray(reads.xd.T)
    compiled_assembly.fill_residual(equations, values, reads.h, reads.t, x, xd, p, work, result)
    _fill_other_ends(orbit, result[rows.events : rows.breaking])
    if problem.mesh.breaking:
        result[rows.breaking : rows.period] = _breaking_residuals(orbit)
    if problem.numeric.model.forced:
        result[rows.period] = orbit.period - problem.n_periods * problem.numeric.period.value(p)[0]
    return result


def _list_functions(problem: OrbitProblem) -> Equations:
    """Return which of the model's functions hold where on an orbit: mode by mode, reset by reset, event by event."""
    mesh, numeric = problem.mesh, problem.numeric

    def find() -> Equations:
        model, segments = numeric.model, problem.segments
        has_function = [bool(s.event) and model.events[s.event].function is not None for s in segments]
        fields = numeric.locate_code("fields", tuple(s.mode for s in segments))
        resets = numeric.locate_code("resets", tuple(s.reset for s in segments))
        events = numeric.locate_code(
            "events", tuple(s.event for s, has in zip(segments, has_function, strict=True) if has)
        )
        found = iter(events)
        at_events = [next(found) if has else (0, 0) for has in has_function]
        codes = np.array([*fields, *resets, *at_events], dtype=np.int64)
        at_points = np.repeat(codes[: len(fields)][mesh.segment], mesh.degree, axis=0)
        address, which = np.concatenate([at_points, codes[len(fields) :]]).T.copy()
        return Equations(
            degree=mesh.degree,
            n_intervals=mesh.n_intervals,
            n_segments=mesh.n_segments,
            n_states=numeric.n_states,
            n_reads=len(model.read_symbols),
            base_index=mesh.base_index,
            slopes=mesh.basis.slopes,
            next_base=np.append(mesh.first_base[1:], mesh.first_base[:1]),
            address=address,
            which=which,
        )

    return mesh.alike(("functions", problem.signature), find)


def _fill_other_ends(orbit: Orbit, result: Array) -> None:
    """Write what is left of the equations that end segments without an event function, of (n_segments,)."""
    problem = orbit.problem
    for link in problem.links:
        elapsed = find_elapsed_weights(problem, link) @ orbit.theta[: orbit.mesh.n_segments]
        result[link.segment] = elapsed - _find_link_delay(orbit, link)
    for s, segment in enumerate(problem.segments):
        if segment.event:
            continue
        if problem.numeric.model.forced:
            result[s] = orbit.start - problem.phase
        else:
            result[s] = phase_weights(problem) @ np.ravel(orbit.values)


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
