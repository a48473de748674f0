"""Where delays that vary read a given moment of an orbit."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.orbit.orbit import Orbit

Array = NDArray[np.float64]
Ints = NDArray[np.intp]
# Places in a mesh interval at which delays are sampled, beyond twice the degree.
MORE_SAMPLES = 1
# How near to a sample a known breaking time may lie on its other side, in periods.
KNOWN = 1e-9
# Steps at most to a time, and when it is found, in periods: the unknown that it becomes is found by Newton's method.
N_STEPS, EXACT = 24, 1e-14


class PreimageSearch:
    """The times at which an orbit's varying delays read given moments; times count from the orbit's start."""

    def __init__(self, orbit: Orbit):
        self.orbit, self.n_constant = orbit, len(orbit.numeric.model.delays)
        mesh = orbit.mesh
        places = np.linspace(0.0, 1.0, 2 * mesh.degree + 1 + MORE_SAMPLES)
        self.inside = np.tile(np.append(np.ones(len(places) - 1, dtype=bool), False), mesh.n_intervals)[:-1]
        # At an edge what is read is that of the interval's own side.
        points = mesh.grid(places)
        self.times = mesh.evaluate_times(points, orbit.theta)
        # Without delays that vary there is nothing to read.
        lags = orbit.read(points, integrals=False).lags if orbit.numeric.model.varying else np.zeros((0, len(points)))
        self.reads = self.times - lags
        # What is read at the end of one interval and at the start of the next is one time, unless the delay jumps: told
        # apart by rounding, a moment between them would be read by neither interval.
        ends = np.arange(len(places) - 1, len(self.times) - 1, len(places))
        alike = np.abs(self.reads[:, ends + 1] - self.reads[:, ends]) <= KNOWN * orbit.period
        self.reads[:, ends + 1] = np.where(alike, self.reads[:, ends], self.reads[:, ends + 1])

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

    def find(self, delay: int, moments: Array) -> list[list[tuple[float, int]]]:
        """Return, for each of ``moments`` (n,), the times b at which a delay reads it less k periods, each with its k.

        ``delay`` is its number among all delays.
        """
        number, period = delay - self.n_constant, self.orbit.period
        turns = np.floor((self.reads[number] - moments[:, None]) / period)
        which, samples, shifts = [], [], []
        for m, i in np.argwhere((np.diff(turns, axis=1) != 0.0) & self.inside).tolist():
            low, high = sorted((turns[m, i], turns[m, i + 1]))
            for turn in np.arange(low + 1.0, high + 1.0):
                which.append(m)
                samples.append(i)
                shifts.append(turn)
        found: list[list[tuple[float, int]]] = [[] for _ in moments]
        if which:
            times = self._refine(number, np.array(samples), moments[which] + period * np.array(shifts))
            for m, b, turn in zip(which, times.tolist(), shifts, strict=True):
                found[m].append((b, -int(turn)))
        return [sorted(times) for times in found]

    def _refine(self, number: int, samples: Ints, targets: Array) -> Array:
        """Return the times (n,) between ``samples`` (n,) and those after them at which ``targets`` (n,) are read."""
        low, high = self.times[samples], self.times[samples + 1]
        below, above = self.reads[number, samples] - targets, self.reads[number, samples + 1] - targets
        result = np.where(np.abs(below) <= np.abs(above), low, high)
        left = np.flatnonzero(below != above)
        for _ in range(N_STEPS):
            share = np.clip(below[left] / (below[left] - above[left]), 0.0, 1.0)
            result[left] = low[left] + share * (high[left] - low[left])
            value = self._read(number, result[left]) - targets[left]
            # The Illinois variant of regula falsi.
            same = (value < 0.0) == (below[left] < 0.0)
            first, last = left[same], left[~same]
            low[first], below[first], above[first] = result[first], value[same], 0.5 * above[first]
            high[last], above[last], below[last] = result[last], value[~same], 0.5 * below[last]
            apart = (high[left] - low[left] > EXACT * self.orbit.period) & (below[left] != above[left])
            left = left[apart & (np.abs(value) > EXACT * self.orbit.period)]
            if len(left) == 0:
                break
        return result

    def _read(self, number: int, times: Array) -> Array:
        points, _ = self.orbit.mesh.locate(self.orbit.theta, times)
        read: Array = times - self.orbit.read(points.clipped(), integrals=False).lags[number]
        return read
