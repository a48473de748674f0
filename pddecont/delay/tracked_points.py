"""Breaking points that are more than sums of delays: behind delays that vary, and through rates.

A delay tau that varies brings a jump at xi back wherever b - tau(b) = xi: once, several times or never, at times that
no sum of durations and delays gives. They are components of theta, with that equation each. A jump that a rate
x'(t - tau) reads is not smoothed: it comes back in the same derivative, times the rate's coefficient, and is followed
until it has faded.

References: Bellen, Zennaro, Numerical Methods for Delay Differential Equations (2003), chapter 2; Neves, Feldstein, J.
Math. Anal. Appl. 56 (1976), for the order of the jumps.
"""

from __future__ import annotations

import heapq
from bisect import bisect, insort
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation import BreakingTime
from pddecont.delay.breaking_points import MAX_POINTS, MERGE, BreakingPoint, DiscontinuitySources

Array = NDArray[np.float64]
# A jump that rates have made this much smaller is rounding.
FADED = 1e-14
# For each of moments xi: times b at which a delay reads it, and how many periods before its own: b - tau = xi - n T.
Preimages = Callable[[int, Array], Sequence[Sequence[tuple[float, int]]]]


class TrackedPoints:
    """The breaking points of an orbit and the breaking times among them, in order of the derivative that jumps."""

    def __init__(
        self,
        sources: DiscontinuitySources,
        theta: Array,
        n_segments: int,
        degree: int,
        preimages: Preimages,
        fading: Mapping[int, float],
    ):
        """Find them; ``theta`` holds durations and delays alone, ``fading`` the coefficients of rates by delay."""
        self.sources, self.theta, self.n_segments = sources, theta, n_segments
        self.degree, self.preimages, self.fading = degree, preimages, fading
        self.period = float(np.sum(theta[:n_segments]))
        self.breaking: list[tuple[int, tuple[int, ...], int]] = []
        self.kept: list[tuple[float, tuple[int, ...], int]] = []
        self.ends = [tuple([1] * s + [0] * (len(theta) - s)) for s in range(n_segments + 1)]
        self.at_ends = np.concatenate([[0.0], np.cumsum(theta[:n_segments])])
        self._taken: list[float] = self.at_ends.tolist()
        self._found: dict[tuple[int, float], Sequence[tuple[float, int]]] = {}
        self._spread()

    def _spread(self) -> None:
        queue: list[tuple[int, int, float, float, tuple[int, ...]]] = []
        order = 0
        for s, q in enumerate(self.sources.jumps):
            queue.append((q, order, float(self.at_ends[s + 1]), 1.0, self.ends[s + 1]))
            order += 1
        heapq.heapify(queue)
        while queue and len(self.kept) < MAX_POINTS:
            self._find_ahead(queue)
            level, _, time, size, key = heapq.heappop(queue)
            for child in self._follow(level, time, size, key):
                heapq.heappush(queue, (child[0], order, *child[1:]))
                order += 1

    def _find_ahead(self, queue: Sequence[tuple[int, int, float, float, tuple[int, ...]]]) -> None:
        """Find where delays that vary read the first of the moments to follow, and the others while at it."""
        for k in self.sources.varying:
            level, _, time, size, _ = queue[0]
            if (k, time) in self._found or not self._goes_on(k, level, size):
                continue
            moments = [time for level, _, time, size, _ in queue if self._goes_on(k, level, size)]
            found = self.preimages(k, np.array(moments))
            self._found.update(((k, moment), times) for moment, times in zip(moments, found, strict=True))

    def _goes_on(self, k: int, level: int, size: float) -> bool:
        """Return whether a jump read through a delay still counts."""
        return level + self.sources.gain(k) <= self.degree and size * self.fading.get(k, 1.0) > FADED

    def _follow(
        self, level: int, time: float, size: float, key: tuple[int, ...]
    ) -> list[tuple[int, float, float, tuple[int, ...]]]:
        """Keep the points at which a jump comes back, and return them: level, time, size, coefficients."""
        found = []
        for k in self.sources.delays:
            tau = float(self.theta[self.n_segments + k])
            later = time + tau
            wraps = int(np.floor(later / self.period))
            own = list(key)
            own[self.n_segments + k] += 1
            own[: self.n_segments] = [c - wraps for c in own[: self.n_segments]]
            if tau > MERGE * self.period:
                found += self._keep(k, level, later - wraps * self.period, size, tuple(own))
        for k in self.sources.varying:
            for b, n in self._found.get((k, time), ()):
                if not self._is_allowed(k, level, b, size):
                    continue
                source = list(key)
                source[: self.n_segments] = [c - n for c in source[: self.n_segments]]
                self.breaking.append((k, tuple(source), level + self.sources.gain(k)))
                name = (*(0,) * len(self.theta), *(0,) * (len(self.breaking) - 1), 1)
                found += self._keep(k, level, b, size, name)
        return found

    def _is_allowed(self, k: int, level: int, time: float, size: float) -> bool:
        if not self._goes_on(k, level, size):
            return False
        place = bisect(self._taken, time)
        beside = self._taken[max(0, place - 1) : place + 1]
        return min(abs(time - other) for other in beside) > MERGE * self.period

    def _keep(
        self, k: int, level: int, time: float, size: float, key: tuple[int, ...]
    ) -> list[tuple[int, float, float, tuple[int, ...]]]:
        if not self._is_allowed(k, level, time, size):
            return []
        level += self.sources.gain(k)
        insort(self._taken, time)
        self.kept.append((time, key, level))
        return [(level, time, size * self.fading.get(k, 1.0), key)]

    def list_points(self) -> list[list[BreakingPoint]]:
        """Return the breaking points of each segment in order of time, the segment's own ends first and last."""
        n = len(self.theta) + len(self.breaking)

        def name(key: tuple[int, ...], level: int) -> BreakingPoint:
            return BreakingPoint(key + (0,) * (n - len(key)), level)

        inside: list[list[BreakingPoint]] = [[] for _ in range(self.n_segments)]
        for time, key, level in sorted(self.kept, key=lambda point: point[0]):
            s = int(np.clip(np.searchsorted(self.at_ends, time, side="right") - 1, 0, self.n_segments - 1))
            inside[s].append(name(key, level))
        return [[name(self.ends[s], -1), *inside[s], name(self.ends[s + 1], -1)] for s in range(self.n_segments)]

    def list_breaking_times(self) -> tuple[BreakingTime, ...]:
        """Return the breaking times among the components of theta, in their order."""
        n = len(self.theta) + len(self.breaking)
        return tuple(
            BreakingTime(k, np.array(source + (0,) * (n - len(source)), dtype=float), level)
            for k, source, level in self.breaking
        )

    @property
    def breaking_times(self) -> Array:
        """Their values, shape (J,)."""
        n = len(self.theta)
        own = {key: time for time, key, _ in self.kept if len(key) > n and sum(key[:n]) == 0 and not any(key[:n])}
        names = [(*(0,) * n, *(0,) * j, 1) for j in range(len(self.breaking))]
        return np.array([own[name] for name in names])
