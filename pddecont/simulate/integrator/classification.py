"""Which of the known attractors motions lead to, for many initial states at once."""

from __future__ import annotations

import math

import numpy as np

from pddecont.simulate.integrator.advance import initialise
from pddecont.simulate.integrator.buffers import make_log
from pddecont.simulate.integrator.calls import entry, internal
from pddecont.simulate.integrator.poincare import advance_to_return
from pddecont.simulate.integrator.state import CONSTANT, LONGEST, T, enlarge, make_state
from pddecont.simulate.integrator.status import Status

# How near to a return of an attractor a motion is taken to be on it, relative to the size of the attractor, and in
# absolute errors of a step.
NEAR, NEAR_ERRORS = 1e-4, 100.0


@entry
def classify_cells(
    system,
    values,
    work,
    template,
    initial,
    modes,
    constant,
    period,
    phase,
    t_end,
    points,
    owner,
    following,
    length,
    size,
    labels,
    times,
):
    """Write which known attractor each of ``initial`` (n_cells, n) leads to, and when that was seen.

    Return how many cells are done; the next one comes to where the tables of ``system`` have nothing yet.

    A motion is on an attractor when its returns are near those of the attractor, in their order, for longer than these
    take and than the longest delay.

    Parameters
    ----------
    template
        All variables at the start (dimension,); the states are replaced by those of a cell.
    modes
        The numbers of the cells' modes at the start (n_cells,).
    points, size
        The returns of all attractors (n_points, n), and how large each state of the attractor is (n_points, n).
    owner, following, length
        Whose return each is, which comes after it, and how many returns its attractor has (n_points,).
    labels, times
        The results: the number of the attractor, -1 for none, and the time (n_cells,).
    """
    log, stop = make_log(0, 0, 0), np.zeros(1)
    for cell in range(len(initial)):
        state = make_state(system, values)
        state.y[:] = template
        state.y[: system.n] = initial[cell]
        if constant == 1:
            state.count[CONSTANT] = 1
            state.constant[:] = initial[cell]
            _start_chain(system, state)
        initialise(system, values, state, work, 0.0, modes[cell])
        labels[cell], expected, since, met = -1, -1, 0.0, 0
        stop[0] = math.nan
        while True:
            status = advance_to_return(system, values, state, work, log, period, phase, t_end, stop)
            if status == Status.CAPACITY:
                state = enlarge(state)
                continue
            if status == Status.NEW_WAY:
                return np.int64(cell)
            if status != Status.SECTION:
                break
            if expected >= 0 and _is_near(points, expected, state.y, size, values.atol):
                found, met = expected, met + 1
            else:
                found, met = _find_near_return(points, state.y, size, values.atol), 1
                since = state.clock[T]
            expected = -1 if found < 0 else following[found]
            if (
                found >= 0
                and met > length[found]
                and state.clock[T] - since >= max(values.longest, state.lag_time[LONGEST])
            ):
                labels[cell] = owner[found]
                break
        times[cell] = state.clock[T]
    return np.int64(len(initial))


@internal
def _start_chain(system, state):
    """Let the chains of a constant history begin: every stage has the value of the state, and no derivatives."""
    for i in range(len(system.pair_state) if system.chain_n > 0 else 0):
        for stage in range(system.chain_n):
            state.y[system.n + (i * system.chain_n + stage) * system.chain_order] = state.constant[system.pair_state[i]]


@internal
def _find_near_return(points, y, size, atol):
    """Return the return of an attractor that ``y`` is near to; -1 for none."""
    for j in range(len(points)):
        if _is_near(points, j, y, size, atol):
            return j
    return -1


@internal
def _is_near(points, j, y, size, atol):
    """Return whether ``y`` is near the return ``j``, relative to the size of its attractor."""
    for i in range(points.shape[1]):
        if not abs(points[j, i] - y[i]) <= NEAR * size[j, i] + NEAR_ERRORS * atol:
            return False
    return True
