"""Where motions settle: attractors, told apart by their returns to a section."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.simulate.kernel.returns import settle
from pddecont.simulate.kernel.tables import Memory, Status, T, Values, enlarged, new_returns
from pddecont.simulate.simulator import Simulator
from pddecont.simulate.snapshot import pack

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
# Attractors whose returns differ by less than this share of their size are one.
APART = 1e-3
# A motion that goes no farther than so many absolute errors of a step is at rest.
REST = 1e5
# A motion that stays away for so many times the longest time between returns, and for the longest delay, does not come back.
AWAY = 10.0


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

    ``period`` counts returns (0: no period found), ``turn`` is the time that they take; ``states``, their ``slopes`` (n_returns, n) and
    ``times`` (n_returns,) are its returns, one period or as many as were kept; ``hits`` counts how often each segment ends between the
    first and the last of them, a period for one that has a period. ``memory`` is the state of the integration at the last return, at
    parameters ``p``. ``failed`` says why a motion has none; one that ``halted`` cannot be gone on with.
    """

    period: int
    turn: float
    states: Array
    slopes: Array
    times: Array
    hits: Integers
    memory: Array
    p: Array
    failed: str = ""
    halted: bool = False

    def size(self) -> Array:
        """Return how large each state of the motion is, shape (n,): its value, or as far as its slope takes it in a radian of a turn."""
        return np.maximum(np.abs(self.states).max(axis=0), np.abs(self.slopes).max(axis=0) * self.turn / max(self.period, 1) / (2 * np.pi))


def same(a: Attractor, b: Attractor, atol: float, *, at_section: bool) -> bool:
    """Whether two are one attractor: as many returns, segments and as long a turn, and the returns of one those of the other, in turn.

    ``atol`` is the absolute error of a step; states may differ by a thousand of it and still be the same. Where returns are
    ``at_section`` their slopes are compared as well, for there the states may always be the same.
    """
    if bool(a.failed) != bool(b.failed) or a.period != b.period:
        return False
    if a.failed:
        return a.failed.partition(" t = ")[0] == b.failed.partition(" t = ")[0]
    if a.period == 0:
        return spread_alike(a.states, b.states)
    if np.any(a.hits != b.hits) or abs(a.turn - b.turn) > APART * a.turn:
        return False
    allowed = APART * np.maximum(a.size(), b.size()) + 1e3 * atol
    slope = APART * np.maximum(np.abs(a.slopes).max(axis=0), np.abs(b.slopes).max(axis=0)) + 1e3 * atol * 2 * np.pi / a.turn
    shifts = range(a.period)
    return any(np.all(np.abs(a.states - np.roll(b.states, k, axis=0)) <= allowed)
               and (not at_section or np.all(np.abs(a.slopes - np.roll(b.slopes, k, axis=0)) <= slope)) for k in shifts)  # fmt: skip


def number_of(attractor: Attractor, known: list[Attractor], atol: float, *, at_section: bool) -> int:
    """Return the number of an attractor among those known; a new one is added."""
    for k, other in enumerate(known):
        if same(attractor, other, atol, at_section=at_section):
            return k
    known.append(attractor)
    return len(known) - 1


def spread_alike(a: Array, b: Array) -> bool:
    """Whether two clouds of returns cover the same region, to a fifth of its size."""
    low_a, high_a, low_b, high_b = a.min(axis=0), a.max(axis=0), b.min(axis=0), b.max(axis=0)
    extent = np.maximum(high_a - low_a, high_b - low_b) + 1e-12 * np.maximum(np.abs(high_a), np.abs(high_b)) + 1e-300
    return bool(np.all(np.abs(low_a - low_b) < 0.2 * extent) and np.all(np.abs(high_a - high_b) < 0.2 * extent))


def still_moves(a: Array, b: Array) -> bool:
    """Whether later returns ``b`` move as earlier ones ``a`` do: their means within a standard deviation, these within two thirds.

    Of 32 returns of a motion without period that is four, and three, times what chance makes of it; one that settles, dies away
    or grows fails it.
    """
    if len(a) < 2 or len(b) < 2:
        return False
    spread_a, spread_b = a.std(axis=0), b.std(axis=0)
    noise = 1e-9 * np.maximum(np.abs(a).max(axis=0), np.abs(b).max(axis=0)) + 1e-300
    apart = np.abs(a.mean(axis=0) - b.mean(axis=0)) <= np.maximum(spread_a, spread_b) + noise
    ratio = (spread_a + noise) / (spread_b + noise)
    return bool(np.all(apart) and np.all((ratio > 0.6) & (ratio < 1 / 0.6)))


def gone(times: Array, t_end: float, longest: float) -> bool:
    """Whether a motion with returns at ``times`` (n_returns,) has left the section for good by ``t_end``."""
    return len(times) > 1 and t_end - float(times[-1]) > max(AWAY * float(np.max(np.diff(times))), longest)


def settled(simulator: Simulator, values: Values, memory: Memory, clock: Clock) -> Attractor:
    """Return the attractor that a motion settles to; one that fails on the way is told with its reason."""
    system, n = simulator.system, simulator.system.n
    room = max(clock.returns, 6 * clock.max_period + 2) + 1
    returns = new_returns(system, room, clock.max_period)
    t_end = float(memory.clock[T]) + clock.transient
    while True:
        status, period = settle(system, values, memory, simulator.work, returns, clock.period, clock.phase, t_end, clock.max_period)
        if status != Status.ROOM:
            break
        memory = enlarged(memory)
    states, times, hits, number = returns.states, returns.times, returns.hits, int(returns.number[0])
    failed = "" if status in (Status.SECTION, Status.REACHED) else simulator.complaint(memory, Status(status), values.p)
    if status == Status.REACHED and not clock.period:
        every = times[np.arange(max(0, number - room), number) % room]
        if gone(every, t_end, values.longest):
            failed, period = f"the motion no longer returns to the section after t = {every[-1]:.6g}", 0
    # Of a motion without period the later half of its returns is kept at most: the earlier ones are its way there.
    kept = min(period or min(clock.returns, max(number // 2, 1)), number, room - 1)
    if not failed and number < 2:
        failed = "the motion does not come back to the section in the time of the transient"
    rows = np.arange(number - kept, number) % room
    width = n if clock.period else 2 * n
    if not failed and not period and not still_moves(states[rows[: kept // 2], :width], states[rows[kept // 2 :], :width]):
        failed = ("the motion has not settled in the time of the transient: its last returns still move, die away or grow; raise "
                  "'transient'")  # fmt: skip
    turn = float(times[(number - 1) % room] - times[(number - 1 - kept) % room]) if number > kept else 0.0
    if not failed and period and not clock.period and np.max(np.abs(states[rows, n:])) * turn < REST * values.atol:
        failed = "the motion stays at an equilibrium or dies away to it: its returns to the section mean nothing"
    before = hits[(number - kept - 1) % room] if number > kept else np.zeros(len(system.segment_mode), np.int64)
    counted = hits[(number - 1) % room] - before if number else before
    return Attractor(0 if failed else int(period), turn, states[rows, :n], states[rows, n:], times[rows], counted, pack(memory), values.p,
                     failed, status not in (Status.SECTION, Status.REACHED))  # fmt: skip
