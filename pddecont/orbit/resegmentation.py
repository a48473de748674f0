"""The same motion cut into other segments: doubled, halved, with a segment inserted or removed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation import Density, Mesh, MeshRule
from pddecont.model import Segment
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.problem import OrbitProblem
from pddecont.orbit.remesh import find_density, make_mesh, transfer_orbit
from pddecont.orbit.signature import Signature, link_delayed_events
from pddecont.orbit.varying_links import link_varying_jumps

Array = NDArray[np.float64]
# How far inside a span, relative to its length, the interval that a point at its end is read from is chosen.
INSIDE = 1e-7


@dataclass(frozen=True)
class SegmentSpan:
    """A segment of the new orbit and the times of the old one between which it runs.

    Times are counted from the old orbit's start, on through the periods.
    """

    segment: Segment
    begin: float
    end: float


def resegment(orbit: Orbit, spans: Sequence[SegmentSpan], rule: MeshRule, n_periods: int) -> Orbit:
    """Return the motion of an orbit without free parameters as an orbit through ``spans``, as a guess.

    ``n_periods`` is the new number of forcing periods.
    """
    problem = orbit.problem
    assert not problem.free, "all parameters are fixed here"
    signature = Signature(problem.numeric, tuple(span.segment for span in spans))
    start = orbit.start + spans[0].begin
    durations = np.array([span.end - span.begin for span in spans])
    n_known = orbit.mesh.n_segments + len(problem.numeric.model.delays)
    theta = np.concatenate([durations, orbit.theta[orbit.mesh.n_segments : n_known]])
    links = link_delayed_events(signature, problem.parameters, durations)

    def on(mesh: Mesh, reference: Array | None = None) -> OrbitProblem:
        return OrbitProblem(signature, mesh, problem.delay, problem.parameters, (), n_periods, reference, start, links)

    density = None if rule.tol is None else _follow_density(orbit, spans, durations, rule.tol)
    mesh = make_mesh(on(Mesh(rule.degree, len(spans), ())), theta, rule, density)
    values = sample_spans(orbit, orbit.values, spans, mesh, theta)
    new = on(mesh, values if signature.needs_phase_reference else None)
    guess = Orbit(new, new.unknowns.join(values, durations, start, np.zeros(0)))
    if not problem.numeric.model.varying:
        return guess
    guess = link_varying_jumps(guess)
    return transfer_orbit(guess, make_mesh(guess.problem, theta, rule, density, guess))


def _follow_density(orbit: Orbit, spans: Sequence[SegmentSpan], durations: Array, tol: float) -> Density:
    """Return the intervals that the old orbit wants, along the new one."""
    old, period = find_density(orbit, tol), orbit.period
    edges, heights, offset = [0.0], [], 0.0
    for span, duration in zip(spans, durations, strict=True):
        turns = np.arange(np.floor(span.begin / period), np.ceil(span.end / period) + 1)
        every = np.unique((turns[:, None] * period + old.edges[:-1]).ravel())
        inner = every[(every > span.begin) & (every < span.end)]
        grid = np.concatenate([[span.begin], inner, [span.end]])
        middle = 0.5 * (grid[1:] + grid[:-1]) % period
        place = np.searchsorted(old.edges, middle, side="right") - 1
        heights.append(old.heights[np.clip(place, 0, len(old.heights) - 1)])
        edges += [*(offset + inner - span.begin), offset + duration]
        offset += duration
    return Density(np.array(edges), np.concatenate(heights))


def sample_spans(orbit: Orbit, values: Array, spans: Sequence[SegmentSpan], mesh: Mesh, theta: Array) -> Array:
    """Return base ``values`` on an orbit's mesh at the base points of another mesh through ``spans``.

    A span's times are stretched to the new segment's duration at ``theta``; at a segment's ends the side that lies
    inside it is taken. The result has shape (n_base, n_states).
    """
    times = mesh.base_times(theta)
    offsets = np.concatenate([[0.0], np.cumsum(theta[: mesh.n_segments])])
    result = np.empty((mesh.n_base, values.shape[1]))
    for s, span in enumerate(spans):
        rows = np.arange(mesh.first_base[s], mesh.last_base[s] + 1)
        length = span.end - span.begin
        at = span.begin + (times[rows] - offsets[s]) * length / (offsets[s + 1] - offsets[s])
        inner = np.clip(at, span.begin + INSIDE * length, span.end - INSIDE * length)
        points, _ = orbit.mesh.locate(orbit.theta, at, choose_by=inner)
        result[rows] = orbit.mesh.interpolate(values, points.clipped())
    return result
