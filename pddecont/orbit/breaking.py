"""Breaking points: where the derivatives of an orbit jump (design section 5.1).

An event makes derivative q of the solution jump, q = 0 if its reset changes the state and q = 1 if only the vector field changes.
The jump at theta comes back in derivative q + l at theta plus any sum of l delays that the vector fields read. All are integer
combinations of theta = (T_1..T_S, tau_1..tau_K), wrapped by whole periods into the orbit. On polynomials of degree m a jump
in derivative m + 1 or higher costs no order.

Reference: Bellen, Zennaro, Numerical Methods for Delay Differential Equations (2003), section 2.2.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

from pddecont.model.codegen import NumericModel
from pddecont.model.system import Segment

Array = NDArray[np.float64]
MERGE = 1e-10
AT_EVENT = 1e-9
MAX_POINTS = 2000


@dataclass(frozen=True)
class Echoes:
    """What decides an orbit's breaking points: the derivative that jumps at the end of each segment, the delays that echo."""

    jumps: tuple[int, ...]
    delays: tuple[int, ...]


@cache
def echoes(numeric: NumericModel, segments: tuple[Segment, ...]) -> Echoes:
    """Return the echoes of a signature, found from its resets and vector fields."""
    model = numeric.model
    jumps = []
    for segment in segments:
        if not segment.event:
            continue
        changed = model.resets[segment.reset] != model.state_symbols
        jumps.append(0 if changed else 1)
    used = set().union(*(e.free_symbols for s in segments for e in model.modes[s.mode]))
    read = {k for (_, k), symbol in zip(model.delayed, model.delayed_symbols, strict=True) if symbol in used}
    return Echoes(tuple(jumps), tuple(sorted(read)))


def jumps_at_events(numeric: NumericModel, segments: tuple[Segment, ...], theta: Array) -> bool:
    """Whether a jump of the state comes back through a delay just at an event of the orbit, to rounding.

    Nearby motions read it before or after the event: they have two linear maps, and the orbit's multipliers are those of neither.
    """
    pattern, n = echoes(numeric, segments), len(segments)
    ends = np.cumsum(theta[:n])
    period = float(ends[-1])
    for s, jump in enumerate(pattern.jumps):
        for k in pattern.delays if jump == 0 else ():
            apart = np.abs((ends[s] + theta[n + k] - ends + 0.5 * period) % period - 0.5 * period)
            if theta[n + k] > 0.0 and np.min(apart) < AT_EVENT * period:
                return True
    return False


@dataclass(frozen=True)
class Edge:
    """A point of an orbit at ``coefficients @ theta``; ``level`` is the derivative that jumps there (-1: a segment's end)."""

    coefficients: tuple[int, ...]
    level: int


def edges(pattern: Echoes, theta: Array, n_segments: int, degree: int) -> list[list[Edge]]:
    """Return the edges of each segment's pieces in order of time, the segment's own ends first and last.

    Points closer than ``MERGE`` periods count as one: the segment's end, else the one that jumps lowest.
    """
    n_theta = len(theta)
    period = float(np.sum(theta[:n_segments]))
    ends = [tuple([1] * s + [0] * (n_theta - s)) for s in range(n_segments + 1)]
    at_ends = np.concatenate([[0.0], np.cumsum(theta[:n_segments])])
    near = MERGE * period
    points: dict[tuple[int, ...], tuple[float, int]] = {}
    delays = [k for k in pattern.delays if theta[n_segments + k] > near]
    for s, q in enumerate(pattern.jumps):
        for level in range(1, degree - q + 1):
            for combination in combinations_with_replacement(delays, level):
                c = np.array(ends[s + 1])
                for k in combination:
                    c[n_segments + k] += 1
                c[:n_segments] -= int(np.floor(float(c @ theta) / period))
                key = tuple(c.tolist())
                if key not in points or points[key][1] > q + level:
                    points[key] = (float(c @ theta), q + level)
            if len(points) > MAX_POINTS:
                break
    inner = sorted((level, key, value) for key, (value, level) in points.items())
    kept: list[list[tuple[float, Edge]]] = [[] for _ in range(n_segments)]
    taken = list(at_ends)
    for level, key, value in inner:
        if all(abs(value - other) > near for other in taken):
            taken.append(value)
            segment = int(np.clip(np.searchsorted(at_ends, value, side="right") - 1, 0, n_segments - 1))
            kept[segment].append((value, Edge(key, level)))
    return [[Edge(ends[s], -1), *(edge for _, edge in sorted(kept[s], key=lambda item: item[0])), Edge(ends[s + 1], -1)]
            for s in range(n_segments)]  # fmt: skip
