"""Breaking points: where the derivatives of an orbit jump.

An event makes derivative q of the solution jump, q = 0 if its reset changes the state and q = 1 if only the vector
field changes. The jump at theta comes back in derivative q + l at theta plus any sum of l delays that the vector fields
read. All are integer combinations of theta = (T_1..T_S, tau_1..tau_K), wrapped by whole periods into the orbit. On
polynomials of degree m a jump in derivative m + 1 or higher costs no order.

Reference: Bellen, Zennaro, Numerical Methods for Delay Differential Equations (2003), section 2.2.
"""

from __future__ import annotations

from bisect import bisect
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field
from itertools import combinations_with_replacement

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.model import DelayedValue, Model, Segment, find_reading_symbols

Array = NDArray[np.float64]
# Breaking points closer than this, in periods, count as one: rounding decides on their order.
MERGE = 1e-10
# A jump this close to an event, in periods, comes back at the event itself.
AT_EVENT = 1e-9
# Breaking points of an orbit at most: those of many small delays would make a mesh of nothing else.
MAX_POINTS = 2000


@dataclass(frozen=True)
class DiscontinuitySources:
    """What decides an orbit's breaking points.

    ``jumps`` is the derivative that jumps at the end of each segment, ``delays`` are the numbers of the constant delays
    through which the vector fields read those jumps again, ``varying`` those of delays that vary. A jump becomes one in
    the next derivative where it is read, but for delays with ``gains`` of their own: a rate keeps its derivative, the
    limit of an integral smooths twice.
    """

    jumps: tuple[int, ...]
    delays: tuple[int, ...]
    varying: tuple[int, ...] = ()
    gains: Mapping[int, int] = field(default_factory=dict)

    @property
    def are_sums(self) -> bool:
        """Whether all breaking points are events and sums of delays later, one derivative higher each."""
        return not self.varying and not self.gains

    def gain(self, delay: int) -> int:
        """Return by how much the derivative that jumps grows through a delay."""
        return self.gains.get(delay, 1)


def find_discontinuity_sources(model: Model, segments: Sequence[Segment]) -> DiscontinuitySources:
    """Return the sources of a signature's breaking points, from its resets and vector fields."""
    ends = [segment for segment in segments if segment.event]
    jumps = tuple(0 if model.resets[segment.reset] != model.state_symbols else 1 for segment in ends)
    fields = [e for segment in segments for e in model.modes[segment.mode]]
    used = set().union(*(e.free_symbols for e in fields))
    gains: dict[int, int] = {}
    symbols = set().union(*(find_reading_symbols(e, model.chain) for e in fields))
    for symbol in symbols & set(model.delayed_symbols):
        read = model.delayed[model.delayed_symbols.index(symbol)]
        # What only delays and limits read, not the field itself, is smoothed as a value is.
        gain = 1 - _count_rates(model, segments, read) if symbol in used else 1
        gains[read.delay] = min(gain, gains.get(read.delay, gain))
    for k in _find_limits(model, symbols):
        gains[k] = min(2, gains.get(k, 2))
    n = len(model.delays)
    return DiscontinuitySources(
        jumps,
        tuple(sorted(k for k in gains if k < n)),
        tuple(sorted(k for k in gains if k >= n)),
        {k: gain for k, gain in gains.items() if gain != 1},
    )


def _count_rates(model: Model, segments: Sequence[Segment], read: DelayedValue) -> int:
    """Return which derivative of the states a read is: where x' = v all along, x'(t - tau) is v(t - tau), a value."""
    state, derivative = read.state, read.derivative
    while derivative:
        rates = {model.modes[segment.mode][state] for segment in segments}
        if len(rates) > 1 or not rates <= {*model.state_symbols}:
            break
        state, derivative = model.state_symbols.index(rates.pop()), derivative - 1
    return derivative


def _find_limits(model: Model, symbols: Set[sympy.Symbol]) -> set[int]:
    """Return the numbers of the delays that are limits of those integrals over states that are among ``symbols``."""
    delays, states = [*model.delays, *model.varying], set(model.state_symbols)
    read = [i for i, symbol in zip(model.integrals, model.integral_symbols, strict=True) if symbol in symbols]
    limits = [limit for i in read if i.integrand.free_symbols & states for limit in (i.low, i.high)]
    return {delays.index(limit) for limit in limits if limit != 0}


def jump_returns_at_event(sources: DiscontinuitySources, theta: Array, n_segments: int) -> bool:
    """Return whether a jump of the state comes back through a delay just at an event of the orbit, to rounding.

    Nearby motions read it before or after the event: they have two linear maps, and the orbit's multipliers are those
    of neither.
    """
    ends = np.cumsum(theta[:n_segments])
    period = float(ends[-1])
    for s, jump in enumerate(sources.jumps):
        for k in (k for k in sources.delays if jump == 0 and sources.gain(k) <= 1):
            tau = theta[n_segments + k]
            apart = np.abs((ends[s] + tau - ends + 0.5 * period) % period - 0.5 * period)
            if tau > 0.0 and np.min(apart) < AT_EVENT * period:
                return True
    return False


@dataclass(frozen=True)
class BreakingPoint:
    """A point of an orbit at ``coefficients @ theta``; ``level`` is the derivative that jumps there (-1: an event)."""

    coefficients: tuple[int, ...]
    level: int


@dataclass(frozen=True)
class BreakingPoints:
    """The breaking points of each segment in order of time, the segment's own ends first and last.

    ``distinct``: no two of them, or of the segments' ends, count as one.
    """

    by_segment: list[list[BreakingPoint]]
    distinct: bool


def find_breaking_points(sources: DiscontinuitySources, theta: Array, n_segments: int, degree: int) -> BreakingPoints:
    """Return the breaking points of an orbit.

    Points closer than ``MERGE`` periods count as one: the segment's end, else the one that jumps lowest.
    """
    n_theta = len(theta)
    period = float(np.sum(theta[:n_segments]))
    ends = [tuple([1] * s + [0] * (n_theta - s)) for s in range(n_segments + 1)]
    at_ends = [0.0, *np.cumsum(theta[:n_segments]).tolist()]
    near = MERGE * period
    points = _propagate(sources, theta, ends, near, degree)
    kept: list[list[tuple[float, BreakingPoint]]] = [[] for _ in range(n_segments)]
    taken = sorted(at_ends)
    for level, key, value in sorted((level, key, value) for key, (value, level) in points.items()):
        place = bisect(taken, value)
        if all(abs(value - other) > near for other in taken[max(0, place - 1) : place + 1]):
            taken.insert(place, value)
            segment = min(max(bisect(at_ends, value) - 1, 0), n_segments - 1)
            kept[segment].append((value, BreakingPoint(key, level)))
    found = [
        [
            BreakingPoint(ends[s], -1),
            *(p for _, p in sorted(kept[s], key=lambda item: item[0])),
            BreakingPoint(ends[s + 1], -1),
        ]
        for s in range(n_segments)
    ]
    return BreakingPoints(found, sum(map(len, kept)) == len(points))


def _propagate(
    sources: DiscontinuitySources, theta: Array, ends: Sequence[tuple[int, ...]], near: float, degree: int
) -> dict[tuple[int, ...], tuple[float, int]]:
    """Return the time and the lowest derivative that jumps at each sum of delays after an event, by coefficients."""
    n_segments = len(ends) - 1
    period = float(np.sum(theta[:n_segments]))
    delays = [k for k in sources.delays if theta[n_segments + k] > near]
    points: dict[tuple[int, ...], tuple[float, int]] = {}
    for s, q in enumerate(sources.jumps):
        for level in range(1, degree - q + 1):
            for combination in combinations_with_replacement(delays, level):
                c = list(ends[s + 1])
                for k in combination:
                    c[n_segments + k] += 1
                wraps = int(np.floor(float(np.dot(c, theta)) / period))
                c[:n_segments] = [i - wraps for i in c[:n_segments]]
                key = tuple(c)
                if key not in points or points[key][1] > q + level:
                    points[key] = (float(np.dot(c, theta)), q + level)
            if len(points) > MAX_POINTS:
                break
    return points
