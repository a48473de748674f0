"""Where motions settle: attractors, told apart by their returns to a section."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ConvergenceError
from pddecont.simulate.kernel.returns import growth, settle
from pddecont.simulate.kernel.tables import Memory, Status, T, Values
from pddecont.simulate.simulator import Simulator
from pddecont.simulate.snapshot import pack, unpack

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
# Attractors whose returns differ by less than this share of their size are one.
APART = 1e-3
INTERVALS = 200


@dataclass(frozen=True)
class Clock:
    """When returns come and how long they are awaited.

    ``period`` is the forcing's (0: returns are to the simulator's section), ``phase`` the part of it that has passed at a return,
    ``transient`` the longest time for settling, ``max_period`` the longest period, ``returns`` how many are kept of a motion without.
    """

    period: float
    phase: float
    transient: float
    max_period: int
    returns: int


@dataclass(frozen=True, eq=False)
class Attractor:
    """A motion that others settle to.

    ``period`` counts returns (0: no period found), ``turn`` is the time that they take; ``states`` (n_returns, n) and ``times``
    (n_returns,) are its returns, one period or as many as were kept; ``hits`` counts how often each segment ends between the first
    and the last of them, a period for one that has a period. ``memory`` is the state of the integration at the last return, at
    parameters ``p``. ``failed`` says why a motion has none.
    """

    period: int
    turn: float
    states: Array
    times: Array
    hits: Integers
    memory: Array
    p: Array
    failed: str = ""

    def same_as(self, other: Attractor) -> bool:
        """Whether both are one attractor: as many returns and segments, and the returns of one near those of the other, in turn."""
        if bool(self.failed) != bool(other.failed) or self.period != other.period:
            return False
        if self.failed:
            return self.failed.partition(" t = ")[0] == other.failed.partition(" t = ")[0]
        size = np.maximum(np.abs(self.states).max(axis=0), np.abs(other.states).max(axis=0)) + 1e-12
        if self.period == 0:
            return _spread_alike(self.states / size, other.states / size)
        if np.any(self.hits != other.hits):
            return False
        shifted = (np.roll(other.states, k, axis=0) for k in range(self.period))
        return any(np.max(np.abs(self.states - s) / size) < APART for s in shifted)


def _spread_alike(a: Array, b: Array) -> bool:
    """Whether two clouds of returns without period cover the same region, to a fifth of its size."""
    low_a, high_a, low_b, high_b = a.min(axis=0), a.max(axis=0), b.min(axis=0), b.max(axis=0)
    extent = np.maximum(high_a - low_a, high_b - low_b) + 1e-12
    return bool(np.all(np.abs(low_a - low_b) < 0.2 * extent) and np.all(np.abs(high_a - high_b) < 0.2 * extent))


def settled(simulator: Simulator, values: Values, memory: Memory, clock: Clock) -> Attractor:
    """Return the attractor that a motion settles to; one that fails on the way is told with its reason."""
    system = simulator.system
    room = max(clock.returns, 2 * clock.max_period + 2) + 1
    states, times = np.zeros((room, system.n)), np.zeros(room)
    hits = np.zeros((room, len(system.segment_mode)), np.int64)
    t_end = float(memory.clock[T]) + clock.transient
    memory, status, period, number = settle(system, values, memory, simulator.work, clock.period, clock.phase, t_end, clock.max_period,
                                            states, times, hits)  # fmt: skip
    failed = "" if status in (Status.SECTION, Status.REACHED) else simulator.complaint(memory, Status(status))
    kept = min(number, period or clock.returns, room - 1)
    if not failed and number < 2:
        failed = "the motion does not come back to the section in the time of the transient"
    rows = np.arange(number - kept, number) % room
    before = hits[(number - kept - 1) % room] if number > kept else np.zeros(len(system.segment_mode), np.int64)
    counted = hits[(number - 1) % room] - before if number else before
    turn = float(times[(number - 1) % room] - times[(number - 1 - kept) % room]) if number > kept else 0.0
    return Attractor(0 if failed else int(period), turn, states[rows], times[rows], counted, pack(memory), values.p, failed)


def lyapunov(simulator: Simulator, values: Values, attractor: Attractor, duration: float) -> tuple[float, float]:
    """Return the largest Lyapunov exponent of an attractor, per unit of time, and its uncertainty.

    They are the slope of the logarithm of the tangent's length over time, and how much slope the departures from it could hide.
    The tangent of the motion, its jumps at events and their echoes, and its past are integrated along with the motion (Benettin et
    al., Meccanica 15, 1980), after a quarter of ``duration`` that lets it turn into the direction of strongest growth.
    """
    if attractor.failed:
        return np.nan, np.nan
    with_tangent = replace(simulator, tangent=True)
    memory = unpack(with_tangent.system, values, attractor.memory)
    rng = np.random.default_rng(1)
    memory.y[simulator.system.n_full :] = rng.standard_normal(simulator.system.n_full)
    interval = duration / INTERVALS
    logs = np.zeros(INTERVALS)
    memory, status = growth(with_tangent.system, values, memory, with_tangent.work, interval, logs[: INTERVALS // 4])
    if status == Status.REACHED:
        memory, status = growth(with_tangent.system, values, memory, with_tangent.work, interval, logs)
    if status != Status.REACHED:
        raise ConvergenceError(simulator.complaint(memory, Status(status)))
    if np.any(np.isneginf(logs)):
        # The tangent has vanished: the motion forgets where it came from within finite time.
        return -np.inf, 0.0
    times = interval * np.arange(1, INTERVALS + 1)
    (slope, level), total = np.polyfit(times, np.cumsum(logs), 1), np.cumsum(logs)
    departure = float(np.std(total - slope * times - level))
    return float(slope), float(np.sqrt(12.0) * departure / duration)
