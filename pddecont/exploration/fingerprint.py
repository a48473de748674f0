"""What all ways of writing a motion have in common, wherever it begins and however many periods are counted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation import make_basis
from pddecont.exploration.symmetry import Symmetry
from pddecont.results import Step
from pddecont.simulate import Trajectory

Array = NDArray[np.float64]
# Places in each piece of a motion at which it is read: evenly for its extremes, at Gauss points for its means.
EVENLY = np.linspace(0.0, 1.0, 25)
GAUSS, WEIGHTS = (part / 2 for part in np.polynomial.legendre.leggauss(7))
SIGMA = np.concatenate([EVENLY, GAUSS + 0.5])
# Periods that differ by less than this, relative to their multiple, are multiples.
SAME_PERIOD = 1e-3
# Periods of two points beside each other that differ by this factor count other numbers of periods.
OTHER_COUNT = 1.3
# The smallest size of a state, as a part of how far motions of the model go.
LEAST_SIZE = 1e-2


@dataclass(frozen=True, eq=False)
class Fingerprint:
    """A motion, whatever its phase: its period (0: it rests, NaN: it has none) and some numbers of each state.

    ``values`` (4, n_states) are the lowest and the highest value, the mean over time, and the standard deviation.
    """

    period: float
    values: Array

    @property
    def lowest(self) -> Array:
        """The lowest value of each state (n_states,)."""
        return np.asarray(self.values[0])

    @property
    def highest(self) -> Array:
        """The highest value of each state (n_states,)."""
        return np.asarray(self.values[1])

    def apply(self, symmetry: Symmetry) -> Fingerprint:
        """Return what the image of the motion is."""
        if symmetry.is_identity:
            return self
        lowest, highest, mean, deviation = self.values[:, list(symmetry.sources)]
        turned = np.array(symmetry.signs) < 0
        ends = np.where(turned, -highest, lowest), np.where(turned, -lowest, highest)
        return Fingerprint(self.period, np.stack([*ends, np.where(turned, -mean, mean), deviation]))

    def measure_size(self, scale: Array) -> Array:
        """Return how large each state is (n_states,); ``scale`` is how far motions of the model go."""
        return np.asarray(np.maximum(self.highest - self.lowest, LEAST_SIZE * scale))


def fingerprint_rest(states: Array) -> Fingerprint:
    """Return that of an equilibrium."""
    return Fingerprint(0.0, np.stack([states, states, states, np.zeros(len(states))]))


def fingerprint_trajectory(
    trajectory: Trajectory, period: float, since: float = -np.inf, until: float = np.inf
) -> Fingerprint:
    """Return that of the motion of a trajectory between two times, which is one period of it (NaN: it has none)."""
    begin, end = np.maximum(trajectory.time, since), np.minimum(trajectory.end, until)
    inside = np.flatnonzero(end > begin)
    lengths = (end - begin)[inside]
    times = begin[inside, None] + lengths[:, None] * SIGMA
    states = trajectory.evaluate_steps(times.ravel(), np.repeat(inside, len(SIGMA)))
    return _summarise(lengths, states.reshape(*times.shape, -1), period)


def fingerprint_orbits(step: Step, rows: NDArray[np.intp]) -> list[Fingerprint]:
    """Return those of recorded orbits."""
    read = _read_equilibrium if "roots" in step.format.orbits else _read_orbit
    return [read(step, int(row)) for row in rows]


def _read_equilibrium(step: Step, row: int) -> Fingerprint:
    return fingerprint_rest(step.points["states"][row])


def _read_orbit(step: Step, row: int) -> Fingerprint:
    orbit = step.orbit(row)
    # A recorded mesh begins with its degree.
    degree, times, values = int(orbit["mesh"][0]), orbit["time"], orbit["states"]
    segments = [np.flatnonzero(orbit["segment"] == number) for number in np.unique(orbit["segment"])]
    starts = np.concatenate([inside[:-1:degree] for inside in segments])
    base = starts[:, None] + np.arange(degree + 1)
    states = np.einsum("pb,jbn->jpn", make_basis(degree).lagrange(SIGMA), values[base])
    return _summarise(times[base[:, -1]] - times[base[:, 0]], states, float(step.points["period"][row]))


def _summarise(lengths: Array, states: Array, period: float) -> Fingerprint:
    """Return the numbers of a motion in pieces: ``lengths`` (n_pieces,), ``states`` (n_pieces, n_places, n_states)."""
    weights = lengths[:, None] * WEIGHTS / lengths.sum()
    inner, flat = states[:, len(EVENLY) :], states.reshape(-1, states.shape[2])
    mean = np.einsum("jp,jpn->n", weights, inner)
    # What grows without bound may be too large to be squared.
    size = np.maximum(np.max(np.abs(flat), axis=0), np.finfo(float).tiny)
    deviation = size * np.sqrt(np.einsum("jp,jpn->n", weights, ((inner - mean) / size) ** 2))
    return Fingerprint(period, np.stack([flat.min(axis=0), flat.max(axis=0), mean, deviation]))


def is_multiple(period: float, of: float, error: float = 0.0) -> bool:
    """Return whether a period is a multiple of another, or that; both are 0 of what rests.

    ``error`` is how wrong one of them may be, relative to it.
    """
    if period == 0.0 or of == 0.0:
        return period == of
    ratio = period / of
    return ratio > 0.5 and abs(ratio - round(ratio)) < (SAME_PERIOD + error) * round(ratio)


def are_as_long(period: float, other: float) -> bool:
    """Return whether two periods count as many turns, though motions between two points of a branch differ somewhat."""
    return max(period, other) <= OTHER_COUNT * min(period, other)
