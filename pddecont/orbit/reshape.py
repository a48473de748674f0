"""The same motion cut into other segments: doubled, halved, with a segment inserted or removed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pddecont.model.system import Segment
from pddecont.orbit.guess import timers_of
from pddecont.orbit.mesh import Mesh, Places
from pddecont.orbit.meshing import Density, MeshRule, density_of, new_mesh
from pddecont.orbit.problem import OrbitProblem

Array = NDArray[np.float64]
INSIDE = 1e-7


@dataclass(frozen=True)
class Part:
    """A segment of the new orbit and the times of the old one at which it begins and ends, counted on through the periods."""

    segment: Segment
    begin: float
    end: float


def reshape(problem: OrbitProblem, x: Array, parts: Sequence[Part], rule: MeshRule, n_periods: int) -> tuple[OrbitProblem, Array]:
    """Return the motion ``x`` (no free parameters) as an orbit through ``parts``, as a guess of its unknowns.

    ``n_periods`` is the new number of forcing periods.
    """
    assert not problem.free, "all parameters are fixed here"
    start = problem.layout.split(x)[2] + parts[0].begin
    segments = tuple(part.segment for part in parts)
    durations = np.array([part.end - part.begin for part in parts])
    S = problem.mesh.n_segments
    theta = np.concatenate([durations, problem.theta(x)[S:]])
    timers = timers_of(problem.numeric, segments, problem.parameters, durations)
    bare = replace(problem, segments=segments, mesh=Mesh(rule.degree, len(parts), ()), n_periods=n_periods, reference=None,
                   phase=start, timers=timers)  # fmt: skip
    density = None if rule.tol is None else _density(problem, x, parts, durations, rule)
    new = replace(bare, mesh=new_mesh(bare, theta, rule, density))
    guess = new.layout.join(np.zeros((new.mesh.n_base, new.numeric.n_states)), durations, start, np.zeros(0))
    values = sampled(problem, x, problem.layout.split(x)[0], parts, new, guess)
    guess[new.layout.values] = values.ravel()
    if not segments[0].event and not problem.numeric.model.forced:
        new = replace(new, reference=values)
    return new, guess


def _density(problem: OrbitProblem, x: Array, parts: Sequence[Part], durations: Array, rule: MeshRule) -> Density:
    """Return the intervals that the old orbit wants, along the new one."""
    old, period = density_of(problem, x, rule), problem.period(x)
    edges, heights, offset = [0.0], [], 0.0
    for part, duration in zip(parts, durations, strict=True):
        turns = np.arange(np.floor(part.begin / period), np.ceil(part.end / period) + 1)
        every = np.unique((turns[:, None] * period + old.edges[:-1]).ravel())
        inner = every[(every > part.begin) & (every < part.end)]
        grid = np.concatenate([[part.begin], inner, [part.end]])
        middle = 0.5 * (grid[1:] + grid[:-1]) % period
        heights.append(old.heights[np.clip(np.searchsorted(old.edges, middle, side="right") - 1, 0, len(old.heights) - 1)])
        edges += [*(offset + inner - part.begin), offset + duration]
        offset += duration
    return Density(np.array(edges), np.concatenate(heights))


def sampled(problem: OrbitProblem, x: Array, values: Array, parts: Sequence[Part], new: OrbitProblem, guess: Array) -> Array:
    """Return base ``values`` on the mesh of the orbit ``x`` at the base points of the new orbit, shape (n_base, n_states).

    A part's times are stretched to the new segment's duration; at a segment's ends the side that lies inside it is taken.
    """
    theta = problem.theta(x)
    period = problem.period(x)
    edges, lengths = problem.mesh.start @ theta, problem.mesh.length @ theta
    times = new.mesh.base_times(new.theta(guess))
    offsets = np.concatenate([[0.0], np.cumsum(guess[new.layout.durations])])
    result = np.empty((new.mesh.n_base, values.shape[1]))
    for s, part in enumerate(parts):
        rows = np.arange(new.mesh.first_base[s], new.mesh.last_base[s] + 1)
        at = part.begin + (times[rows] - offsets[s]) * (part.end - part.begin) / (offsets[s + 1] - offsets[s])
        inner = np.clip(at, part.begin + INSIDE * (part.end - part.begin), part.end - INSIDE * (part.end - part.begin))
        wraps = np.floor(inner / period)
        interval = np.clip(np.searchsorted(edges, inner - wraps * period, side="right") - 1, 0, len(edges) - 1)
        sigma = np.clip((at - wraps * period - edges[interval]) / lengths[interval], 0.0, 1.0)
        result[rows] = problem.mesh.at(values, Places(interval, sigma))
    return result
