"""Orbits as a results file holds them, read without the package: polynomials over a period, a past for motions."""

from __future__ import annotations

import bisect
from dataclasses import dataclass, field

import numpy as np

# Times closer than this part of the period to an edge are read on the side that is asked for.
AT_EDGE = 1e-10


@dataclass
class RecordedOrbit:
    """An orbit of period ``period`` from ``start``; ``names`` are its segments, ``ends`` their ends.

    ``edges`` are where its polynomials begin, with the nodes and the values of each; ``error`` is its error estimate,
    in parts of the ``sizes`` of the states.
    """

    start: float
    period: float
    names: list[str]
    ends: np.ndarray
    edges: list[float]
    nodes: list[np.ndarray]
    values: list[np.ndarray]
    error: float
    parameters: dict[str, float]
    weights: dict[int, np.ndarray] = field(default_factory=dict)

    @property
    def eventless(self):
        """Whether it runs through one mode without events, whose name its only segment has in brackets."""
        return self.names[0].startswith("(")

    @property
    def sizes(self):
        """How large each state is: half its swing, and no less than a thousandth of the largest."""
        values = np.concatenate(self.values)
        halves = np.ptp(values, axis=0) / 2
        return np.maximum(halves, 1e-3 * max(halves.max(), 1e-9))

    def first_state(self):
        """Return the state just after the start."""
        return self.values[0][0]

    def __call__(self, t, side=1):
        """Return the state at any time; at an edge on the given side."""
        turns = np.floor((t - self.start + side * AT_EDGE * self.period) / self.period)
        t = t - turns * self.period
        i = max(bisect.bisect_right(self.edges, t + side * AT_EDGE * self.period) - 1, 0)
        nodes, values = self.nodes[i], self.values[i]
        difference = t - nodes
        near = np.argmin(np.abs(difference))
        if abs(difference[near]) < 1e-15 * max(1.0, abs(t)):
            return values[near]
        quotients = self.weights[i] / difference
        return quotients @ values / quotients.sum()


def read_orbit(step, row):
    """Return the orbit in a row of a step."""
    rows = step.orbit(row)
    degree, time, segment = int(rows["mesh"][0]), rows["time"], rows["segment"].astype(int)
    names = rows["signature"].tobytes().decode().split()
    durations, start = rows["unknowns"][: len(names)], float(time[0])
    nodes, values = [], []
    for s in range(len(names)):
        places = np.flatnonzero(segment == s)
        for first in places[:-1:degree]:
            if time[first + degree] > time[first]:
                nodes.append(time[first : first + degree + 1])
                values.append(rows["states"][first : first + degree + 1])
    parameters = dict(zip(step.meta["parameters"], map(float, step.points["parameters"][row]), strict=True))
    orbit = RecordedOrbit(
        start,
        float(np.sum(durations)),
        names,
        start + np.cumsum(durations),
        [float(n[0]) for n in nodes],
        nodes,
        values,
        float(step.points["error_estimate"][row]),
        parameters,
    )
    orbit.weights.update({i: _barycentric(n) for i, n in enumerate(nodes)})
    return orbit


def _barycentric(nodes):
    """Return the weights of barycentric interpolation, scaled by the interval's length."""
    scaled = (nodes - nodes[0]) / (nodes[-1] - nodes[0])
    gaps = scaled[:, None] - scaled[None, :] + np.eye(len(nodes))
    return 1.0 / np.prod(gaps, axis=1)
