"""Where motions settle: attractors, told apart by their returns to a section."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.native.integrator import LONGEST, Status, T
from pddecont.simulate.failure import FailureReason, MotionFailure
from pddecont.simulate.integrator import (
    IntegratorState,
    ParameterValues,
    fit_returns,
    follow_to_period,
    make_return_buffer,
)
from pddecont.simulate.motion_row import pack_motion
from pddecont.simulate.returns import ReturnSettings
from pddecont.simulate.simulator import Simulator

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
# Attractors whose returns differ by less than this share of their size are one ...
APART = 1e-3
# ... and by less than so many absolute errors of a step.
APART_ERRORS = 1e3
# Two clouds of returns cover one region if their borders differ by less than this share of its extent.
SAME_REGION = 0.2
# The least ratio of the standard deviations of later and earlier returns of a stationary motion; for what chance makes
# of it see is_stationary.
SAME_SPREAD = 0.6
# A motion whose past, as long as delays reach back, has more steps than this is given up: it becomes slower and slower,
# and each row of a file that keeps such a past would be hundreds of megabytes.
MOST_PIECES = 1 << 19
# A motion that goes no farther than so many absolute errors of a step is at rest.
REST = 1e5
# A motion that stays away for so many times the longest time between returns, and for the longest delay, does not come
# back.
AWAY = 10.0
# Periods that a buffer of returns has to hold: the last three repetitions are compared with the three before them.
PERIODS_SEEN = 6


@dataclass(frozen=True, eq=False)
class Attractor:
    """A motion that others settle to.

    Attributes
    ----------
    period
        Returns in a period; 0 where no period was found.
    turn
        The time that they take.
    states, slopes, times
        The returns of one period, or as many as were kept (n_returns, n), (n_returns, n), (n_returns,).
    segment_counts
        How often segments end between the first and the last of them, by name, those that end at all; in a period of
        a motion that has one.
    packed_state
        The state of the integration at the last return, from :func:`~pddecont.simulate.motion_row.pack_motion`; empty
        of a motion whose past has become too long.
    p
        The parameters.
    failure
        Why the motion leads to no attractor; None where it does.
    """

    period: int
    turn: float
    states: Array
    slopes: Array
    times: Array
    segment_counts: Mapping[str, int]
    packed_state: Array
    p: Array
    failure: MotionFailure | None = None

    @property
    def size(self) -> Array:
        """How large each state is (n,): its value, or as far as its slope takes it in a radian of a turn."""
        reach: Array = np.abs(self.slopes).max(axis=0) * self.turn / max(self.period, 1) / (2 * np.pi)
        largest: Array = np.maximum(np.abs(self.states).max(axis=0), reach)
        return largest


def find_attractor(
    simulator: Simulator, values: ParameterValues, state: IntegratorState, settings: ReturnSettings
) -> Attractor:
    """Return the attractor that a motion leads to; one with a ``failure`` if it leads to none."""
    n = simulator.system.n
    capacity = max(settings.n_kept, PERIODS_SEEN * settings.max_period + 2) + 1
    returns = make_return_buffer(simulator.system, capacity, settings.max_period)
    t_end = float(state.clock[T]) + settings.transient
    while True:
        values, state = simulator.reached.fit(values, state)
        returns = fit_returns(returns, simulator.system)
        number, period = follow_to_period(
            simulator.system,
            values,
            state,
            simulator.work,
            returns,
            settings.forcing_period,
            settings.phase,
            t_end,
            settings.max_period,
        )
        status = Status(number)
        if status not in (Status.CAPACITY, Status.NEW_WAY):
            break
        if status == Status.CAPACITY and len(state.past_time) > MOST_PIECES:
            break
        state = simulator.make_room(values, state, status)
    n_returns = int(returns.number[0])
    failure = None
    if status == Status.CAPACITY:
        failure = MotionFailure(FailureReason.PAST_TOO_LONG, float(state.clock[T]))
    elif status not in (Status.SECTION, Status.REACHED):
        failure = simulator.diagnose(state, status, values.p)
    elif status == Status.REACHED and not settings.forcing_period:
        times = returns.times[np.arange(max(0, n_returns - capacity), n_returns) % capacity]
        if has_left_section(times, t_end, max(values.longest, float(state.lag_time[LONGEST]))):
            failure, period = MotionFailure(FailureReason.SECTION_LEFT, float(times[-1])), 0
    # Of a motion without a period at most the later half of its returns is kept: the earlier ones are its way there.
    kept = min(period or min(settings.n_kept, max(n_returns // 2, 1)), n_returns, capacity - 1)
    rows = np.arange(n_returns - kept, n_returns) % capacity
    last, before = (n_returns - 1) % capacity, (n_returns - kept - 1) % capacity
    counts, turn = returns.segment_counts[last].copy(), 0.0
    if n_returns > kept:
        counts -= returns.segment_counts[before]
        turn = float(returns.times[last] - returns.times[before])
    if failure is None:
        reason = _judge_returns(returns.states[rows], n_returns, period, turn, values, settings)
        failure = None if reason is None else MotionFailure(reason)
    return Attractor(
        0 if failure else int(period),
        turn,
        returns.states[rows, :n],
        returns.states[rows, n:],
        returns.times[rows],
        {name: int(n) for name, n in zip(simulator.tables.segments, counts, strict=True) if n},
        np.zeros(0) if status == Status.CAPACITY else pack_motion(simulator.tables, state),
        values.p,
        failure,
    )


def _judge_returns(
    kept: Array, n_returns: int, period: int, turn: float, values: ParameterValues, settings: ReturnSettings
) -> FailureReason | None:
    """Return why the kept returns, states and slopes (n_kept, 2 n), are those of no attractor; None if they are."""
    n = kept.shape[1] // 2
    if n_returns < 2:
        return FailureReason.NO_RETURN
    if not period:
        half, width = len(kept) // 2, n if settings.forcing_period else 2 * n
        return None if is_stationary(kept[:half, :width], kept[half:, :width]) else FailureReason.NOT_SETTLED
    if not settings.forcing_period and np.max(np.abs(kept[:, n:])) * turn < REST * values.atol:
        return FailureReason.EQUILIBRIUM
    return None


def is_same_attractor(a: Attractor, b: Attractor, atol: float, *, at_section: bool) -> bool:
    """Return whether two attractors are one.

    They are if they have as many returns, segments, and as long a turn, and the returns of one are those of the other,
    from some return on. ``atol`` is the absolute error of a step. Where returns are ``at_section`` their slopes are
    compared as well, for there the states may always be the same. Motions without a period are one attractor if their
    returns cover one region, those that fail if they do so in one way.
    """
    if a.failure is not None or b.failure is not None:
        return a.failure is not None and b.failure is not None and a.failure.is_like(b.failure)
    if a.period != b.period:
        return False
    if a.period == 0:
        return cover_same_region(a.states, b.states)
    if a.segment_counts != b.segment_counts or abs(a.turn - b.turn) > APART * a.turn:
        return False
    allowed = APART * np.maximum(a.size, b.size) + APART_ERRORS * atol
    slope = (
        APART * np.maximum(np.abs(a.slopes).max(axis=0), np.abs(b.slopes).max(axis=0))
        + APART_ERRORS * atol * 2 * np.pi / a.turn
    )
    return any(
        np.all(np.abs(a.states - np.roll(b.states, k, axis=0)) <= allowed)
        and (not at_section or np.all(np.abs(a.slopes - np.roll(b.slopes, k, axis=0)) <= slope))
        for k in range(a.period)
    )


def find_or_add(attractor: Attractor, known: list[Attractor], atol: float, *, at_section: bool) -> int:
    """Return the number of an attractor among those known; one that is new is added to them."""
    for k, other in enumerate(known):
        if is_same_attractor(attractor, other, atol, at_section=at_section):
            return k
    known.append(attractor)
    return len(known) - 1


def group_attractors(
    attractors: Sequence[Attractor], atol: float, *, at_section: bool
) -> list[tuple[Attractor, float]]:
    """Return each different attractor once, in order, with its share of all."""
    known: list[Attractor] = []
    numbers = [find_or_add(attractor, known, atol, at_section=at_section) for attractor in attractors]
    return [(attractor, numbers.count(k) / len(numbers)) for k, attractor in enumerate(known)]


def cover_same_region(a: Array, b: Array) -> bool:
    """Return whether two clouds of returns (n_returns, n) cover one region, to a part of its extent."""
    low_a, high_a, low_b, high_b = a.min(axis=0), a.max(axis=0), b.min(axis=0), b.max(axis=0)
    extent = np.maximum(high_a - low_a, high_b - low_b) + 1e-12 * np.maximum(np.abs(high_a), np.abs(high_b)) + 1e-300
    return bool(
        np.all(np.abs(low_a - low_b) < SAME_REGION * extent) and np.all(np.abs(high_a - high_b) < SAME_REGION * extent)
    )


def is_stationary(earlier: Array, later: Array) -> bool:
    """Return whether later returns (n_returns, n) move as earlier ones do: no motion that settles or grows does.

    Their means differ by a standard deviation at most, the standard deviations by SAME_SPREAD. Of 32 returns of a
    motion without a period that is four, and three, times what chance makes of it.
    """
    if len(earlier) < 2 or len(later) < 2:
        return False
    with np.errstate(over="ignore"):
        spread_a, spread_b = earlier.std(axis=0), later.std(axis=0)
    if not (np.isfinite(spread_a).all() and np.isfinite(spread_b).all()):
        return False
    noise = 1e-9 * np.maximum(np.abs(earlier).max(axis=0), np.abs(later).max(axis=0)) + 1e-300
    alike = np.abs(earlier.mean(axis=0) - later.mean(axis=0)) <= np.maximum(spread_a, spread_b) + noise
    ratio = (spread_a + noise) / (spread_b + noise)
    return bool(np.all(alike) and np.all((ratio > SAME_SPREAD) & (ratio < 1 / SAME_SPREAD)))


def has_left_section(times: Array, t_end: float, longest: float) -> bool:
    """Return whether a motion with returns at ``times`` (n_returns,) has left the section for good by ``t_end``.

    ``longest`` is the longest delay.
    """
    return len(times) > 1 and t_end - float(times[-1]) > max(AWAY * float(np.max(np.diff(times))), longest)
