"""Arrays that an integration writes beside its state: a log, the last returns, and intermediate results."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pddecont.native.integrator import N_COEFFICIENTS, N_SUMS, SUM_WIDTH
from pddecont.simulate.integrator.system import System

Array = NDArray[np.float64]
Integers = NDArray[np.int64]


class Log(NamedTuple):
    """Steps and events of an integration, for those who want them; arrays of no length record nothing.

    ``n`` counts both (2,). A step has its beginning, length, end, mode, arc, and continuous extension (steps, n),
    (steps, N_COEFFICIENTS, n); an event its time, the segment that it ends, the arc that it begins, and the states
    before and after the reset (events, n).
    """

    n: Integers
    time: Array
    length: Array
    end: Array
    mode: Integers
    arc: Integers
    value: Array
    coefficients: Array
    event_time: Array
    event_segment: Integers
    event_arc: Integers
    before: Array
    after: Array


def make_log(n: int, steps: int, events: int) -> Log:
    """Return an empty log for so many steps and events of ``n`` states."""
    return Log(
        np.zeros(2, np.int64),
        np.zeros(steps),
        np.zeros(steps),
        np.zeros(steps),
        np.zeros(steps, np.int64),
        np.zeros(steps, np.int64),
        np.zeros((steps, n)),
        np.zeros((steps, N_COEFFICIENTS, n)),
        np.zeros(events),
        np.zeros(events, np.int64),
        np.zeros(events, np.int64),
        np.zeros((events, n)),
        np.zeros((events, n)),
    )


class ReturnBuffer(NamedTuple):
    """The last returns of a motion to a section, and how its period shows in them.

    All but the last three are rings: return number i is in row i modulo the capacity.

    Attributes
    ----------
    states
        States and their slopes (capacity, 2 n).
    times
        Times (capacity,).
    segment_counts
        How often each segment had ended (capacity, n_segments).
    distances
        How far each return is from the one so many returns before (capacity, max_period + 1).
    running
        How often in a row the motion came back after so many returns (max_period + 1,).
    number
        How many returns there were (1,).
    stop
        The time that the motion is under way to (1,); NaN at a return.
    """

    states: Array
    times: Array
    segment_counts: Integers
    distances: Array
    running: Integers
    number: Integers
    stop: Array


def make_return_buffer(system: System, n: int, max_period: int) -> ReturnBuffer:
    """Return an empty buffer for the last ``n`` returns."""
    return ReturnBuffer(
        np.zeros((n, 2 * system.n)),
        np.zeros(n),
        np.zeros((n, len(system.segment_mode)), np.int64),
        np.zeros((n, max_period + 1)),
        np.zeros(max_period + 1, np.int64),
        np.zeros(1, np.int64),
        np.full(1, np.nan),
    )


class Workspace(NamedTuple):
    """Arrays for intermediate results; rows have ``dimension`` numbers unless they say otherwise.

    ``stages`` has 16 rows, ``extension`` N_COEFFICIENTS, ``trial`` and ``slope`` 3; ``xd`` and ``xd_slope`` hold the
    delayed values and their slopes (n_pairs + 1,), ``jacobian`` the derivatives of a field or a reset
    (n, n + n_pairs + 1), ``gradient`` those of an event function. ``bernstein`` and ``stack`` have 64 rows of 10 and 4.
    ``digits`` are those that an event leads to (n_keys,). ``asked`` holds the segment whose way on is not in the tables
    and what is missing; then a segment (-1: none) and the way that it has to go (4,). ``landing`` holds
    the time and the states after the reset of that segment (n + 1,). ``lag`` holds the lags that vary (n_varying + 1,),
    ``lag_least`` and ``lag_most`` the least and the greatest times that they read in a step; ``held`` an extension of
    the present step (N_COEFFICIENTS rows), ``fresh_slope`` the slopes where a piece begins (dimension,), ``inside`` and
    ``integrand`` the states at a time in the past and what an integrand is there (n + 2,), ``panels`` those that wait
    to be integrated (64 rows of 3), ``sums`` the number of those over whole steps that are kept, and these (1 + N_SUMS
    * SUM_WIDTH,). Of the stiff method are ``full_jacobian`` (n_full, n_full), ``matrix`` (3 n_full, 3 n_full) with its
    ``pivots``, ``increments`` and ``change`` (3 n_full,); elsewhere they are empty.
    """

    stages: Array
    extension: Array
    trial: Array
    slope: Array
    xd: Array
    xd_slope: Array
    jacobian: Array
    gradient: Array
    after_reset: Array
    past_trial: Array
    crossing: Integers
    passed: Integers
    found_side: Integers
    bernstein: Array
    stack: Array
    digits: Integers
    asked: Integers
    landing: Array
    lag: Array
    lag_least: Array
    lag_most: Array
    held: Array
    fresh_slope: Array
    inside: Array
    integrand: Array
    panels: Array
    sums: Array
    full_jacobian: Array
    matrix: Array
    pivots: Integers
    increments: Array
    change: Array


def make_workspace(system: System) -> Workspace:
    """Return arrays for intermediate results of an integration of ``system``."""
    n, m = system.n, len(system.pair_state)
    dimension = system.n_full * (1 + system.tangent)
    full = system.n_full * system.stiff
    return Workspace(
        np.zeros(16 * dimension),
        np.zeros(N_COEFFICIENTS * dimension),
        np.zeros(3 * dimension),
        np.zeros(3 * dimension),
        np.zeros(m + 1),
        np.zeros(m + 1),
        np.zeros(n * (n + m + 1)),
        np.zeros(n + m + 2),
        np.zeros(n + 1),
        np.zeros(n + 1),
        np.zeros(len(system.after) + 1, np.int64),
        np.zeros(len(system.after) + 1, np.int64),
        np.zeros(len(system.segment_mode) + 1, np.int64),
        np.zeros(640),
        np.zeros(256),
        np.zeros(system.n_keys, np.int64),
        np.full(4, -1, np.int64),
        np.zeros(n + 1),
        np.zeros(system.n_varying + 1),
        np.zeros(system.n_varying + 1),
        np.zeros(system.n_varying + 1),
        np.zeros(N_COEFFICIENTS * dimension),
        np.zeros(dimension),
        np.zeros(n + 2),
        np.zeros(n + 2),
        np.zeros(192),
        np.zeros(1 + N_SUMS * SUM_WIDTH),
        np.zeros(full * full),
        np.zeros(9 * full * full),
        np.zeros(3 * full, np.int64),
        np.zeros(3 * full),
        np.zeros(3 * full),
    )
