"""What a motion does that repeats nothing: it rests, dies away, or one of its states goes on growing."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pddecont.simulate.trajectory import Trajectory

Array = NDArray[np.float64]
# A motion that is smaller than this part of what it was, or of where it is, has come to rest; so has one that goes no
# farther than so many errors allowed in a step.
STILL, NOISE = 1e-6, 10.0
# The later part of a trajectory is looked at in so many stretches of one length, at so many times in each.
LATER, N_STRETCHES, N_TIMES = 0.6, 6, 300
# Swings that shrink by one factor lead to rest: by no more than SLOWEST in each stretch and to FADED in all.
SLOWEST, FADED = 0.9, 0.03
# A state that grows goes on doing so: its last increase is no less than this part of the largest.
STEADY = 0.5


@dataclass(frozen=True)
class Decay:
    """Swings shrink by a ``factor`` in each ``length`` of time."""

    factor: float
    length: float


def measure_noise(trajectory: Trajectory, states: Array) -> Array:
    """Return how far states (n_times, n_states) of a trajectory may differ by errors of its steps (n_states,)."""
    noise: Array = NOISE * (trajectory.atol + trajectory.rtol * np.max(np.abs(states), axis=0))
    return noise


def is_at_rest(trajectory: Trajectory) -> bool:
    """Return whether no state moves in the last tenth of a trajectory, compared with all of it or with where it is."""
    start, end = trajectory.t0, trajectory.t_end
    everything = trajectory(np.linspace(start, end, N_STRETCHES * N_TIMES))
    late = trajectory(np.linspace(end - 0.1 * (end - start), end, N_TIMES))
    swing = np.ptp(late, axis=0)
    whole, place = STILL * np.ptp(everything, axis=0), STILL * np.max(np.abs(late), axis=0)
    return bool(np.all((swing <= whole) | (swing <= place) | (swing <= measure_noise(trajectory, late))))


def find_growing_state(trajectory: Trajectory) -> tuple[int, float, float] | None:
    """Return the state that grows or falls steadily, with where it comes from and where it is; None if none does."""
    stretches = _sample_stretches(trajectory)
    means, swings = stretches.mean(axis=1), np.ptp(stretches, axis=1)
    increases = np.diff(means, axis=0)
    one_way = np.all(increases > 0.0, axis=0) | np.all(increases < 0.0, axis=0)
    steady = np.abs(increases[-1]) >= STEADY * np.max(np.abs(increases), axis=0)
    covered = np.abs(means[-1] - means[0])
    grows = one_way & steady & (covered > np.max(swings, axis=0))
    grows &= covered > measure_noise(trajectory, stretches.reshape(-1, stretches.shape[2]))
    if not grows.any():
        return None
    state = int(np.argmax(grows))
    return state, float(stretches[0, 0, state]), float(stretches[-1, -1, state])


def find_decay(trajectory: Trajectory) -> Decay | None:
    """Return how fast a motion dies away to rest; None if it does not.

    The swings of all states together shrink by nearly one factor from stretch to stretch.
    """
    swings = np.ptp(_sample_stretches(trajectory), axis=1)
    size = np.max(swings / (swings[0] + 1e-300), axis=1)
    if np.any(size <= 0.0):
        return None
    factors = size[1:] / size[:-1]
    if np.max(factors) > SLOWEST or size[-1] > FADED or np.max(factors) > np.sqrt(np.min(factors)):
        return None
    length = LATER * (trajectory.t_end - trajectory.t0) / N_STRETCHES
    return Decay(float(size[-1] ** (1.0 / (N_STRETCHES - 1))), length)


def _sample_stretches(trajectory: Trajectory) -> Array:
    """Return the states in stretches of the later part of a trajectory, shape (N_STRETCHES, N_TIMES, n_states)."""
    end = trajectory.t_end
    edges = np.linspace(end - LATER * (end - trajectory.t0), end, N_STRETCHES + 1)
    return np.stack([trajectory(np.linspace(a, b, N_TIMES)) for a, b in pairwise(edges)])
