"""Where delays that vary read a given moment of an orbit."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation import MeshPoints
from pddecont.orbit.orbit import Orbit

Array = NDArray[np.float64]
# Places in a mesh interval at which delays are sampled, beyond twice the degree.
MORE_SAMPLES = 1
# How near to a sample a known breaking time may lie on its other side, in periods.
KNOWN = 1e-9
# Steps towards a time at most, and from how near to it, in periods, one step of the secant method is the last: that
# leaves rounding, and the unknown that the time becomes is found by Newton's method.
N_STEPS, NEAR = 24, 1e-9


class PreimageSearch:
    """The times at which an orbit's varying delays read given moments; times count from the orbit's start."""

    def __init__(self, orbit: Orbit):
        self.orbit, self.n_constant = orbit, len(orbit.numeric.model.delays)
        mesh = orbit.mesh
        places = np.linspace(0.0, 1.0, 2 * mesh.degree + 1 + MORE_SAMPLES)
        points = mesh.grid(places)
        # At an edge what is read is that of the interval's own side.
        inward = np.where(points.sigma <= 0.0, 1.0, np.where(points.sigma >= 1.0, -1.0, 0.0))
        points = MeshPoints(points.interval, points.sigma, points.weights, inward)
        self.times = mesh.times(points) @ orbit.theta
        self.reads = self.times - orbit.read(points).lags
        self.inside = np.tile(np.append(np.ones(len(places) - 1, dtype=bool), False), mesh.n_intervals)[:-1]

    def crosses_anew(self, delay: int, moments: Array, known: Array) -> bool:
        """Return whether a delay reads one of ``moments`` (n,), or periods before it, at a time not ``known`` (m,).

        Times are told apart as far as samples lie apart.
        """
        number, period = delay - self.n_constant, self.orbit.period
        turns = np.floor((self.reads[number] - moments[:, None]) / period)
        crossed = np.any(np.diff(turns, axis=1) != 0.0, axis=0) & self.inside
        room = KNOWN * period
        first = np.searchsorted(np.sort(known), self.times[:-1] - room)
        last = np.searchsorted(np.sort(known), self.times[1:] + room, side="right")
        return bool(np.any(crossed & (first == last)))

    def find(self, delay: int, moment: float) -> list[tuple[float, int]]:
        """Return the times b at which delay number ``delay`` reads ``moment`` less n periods, each with its n."""
        number, period = delay - self.n_constant, self.orbit.period
        turns = np.floor((self.reads[number] - moment) / period)
        changes = np.flatnonzero((np.diff(turns) != 0.0) & self.inside)
        found = []
        for i in changes.tolist():
            low, high = sorted((turns[i], turns[i + 1]))
            for turn in np.arange(low + 1.0, high + 1.0):
                b = self._refine(number, i, moment + turn * period)
                found.append((b, -int(turn)))
        return sorted(found)

    def _refine(self, number: int, i: int, target: float) -> float:
        """Return the time between samples ``i`` and ``i`` + 1 at which ``target`` is read."""
        low, high = float(self.times[i]), float(self.times[i + 1])
        below, above = float(self.reads[number, i]) - target, float(self.reads[number, i + 1]) - target
        last, before = low, below
        for _ in range(N_STEPS):
            if above == below or high - low <= 1e-14 * self.orbit.period:
                break
            share = min(max(below / (below - above), 0.0), 1.0)
            middle = low + share * (high - low)
            value = self._read(number, middle) - target
            if abs(value) <= NEAR * self.orbit.period:
                step = value * (middle - last) / (value - before) if value != before else 0.0
                return min(max(middle - step, low), high)
            # The Illinois variant of regula falsi.
            last, before = middle, value
            if (value < 0.0) == (below < 0.0):
                low, below, above = middle, value, 0.5 * above
            else:
                high, above, below = middle, value, 0.5 * below
        return 0.5 * (low + high) if above == below else low + (high - low) * below / (below - above)

    def _read(self, number: int, time: float) -> float:
        points, _ = self.orbit.mesh.locate(self.orbit.theta, np.array([time]))
        return time - float(self.orbit.read(points.clipped()).lags[number, 0])
