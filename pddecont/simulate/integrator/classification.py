"""Which of the known attractors motions lead to, for many initial states at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.native.integrator import CONSTANT, LONGEST, Status, T
from pddecont.simulate.integrator.buffers import Workspace
from pddecont.simulate.integrator.entries import advance_to_return, initialise
from pddecont.simulate.integrator.state import IntegratorState, enlarge, make_state
from pddecont.simulate.integrator.system import ParameterValues, System

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
# How near to a return of an attractor a motion is taken to be on it, relative to the size of the attractor, and in
# absolute errors of a step.
NEAR, NEAR_ERRORS = 1e-4, 100.0


@dataclass(frozen=True, eq=False)
class KnownReturns:
    """The returns of all known attractors with a period, one a row.

    Of each are held its states and how large each state of its attractor is (n_points, n), whose it is, which comes
    next, and how many its attractor has (n_points,).
    """

    points: Array
    size: Array
    owner: Integers
    following: Integers
    length: Integers


def classify_cells(
    system: System,
    values: ParameterValues,
    work: Workspace,
    template: Array,
    initial: Array,
    modes: Integers,
    constant: int,
    period: float,
    phase: float,
    t_end: float,
    known: KnownReturns,
    labels: Integers,
    times: Array,
) -> int:
    """Write which known attractor each of ``initial`` (n_cells, n) leads to, and when that was seen.

    Return how many cells are done; the next one comes to where the tables of ``system`` have nothing yet.

    Parameters
    ----------
    template
        All variables at the start (dimension,); the states are replaced by those of a cell.
    modes
        The numbers of the cells' modes at the start (n_cells,).
    labels, times
        The results: the number of the attractor, -1 for none, and the time (n_cells,).
    """
    for cell in range(len(initial)):
        state = make_state(system, values)
        state.y[:] = template
        state.y[: system.n] = initial[cell]
        if constant == 1:
            state.count[CONSTANT] = 1
            state.constant[:] = initial[cell]
            _start_chain(system, state)
        initialise(system, values, state, work, 0.0, int(modes[cell]))
        found = _find_attractor(system, values, state, work, period, phase, t_end, known)
        if found is None:
            return cell
        labels[cell], times[cell] = found
    return len(initial)


def _find_attractor(
    system: System,
    values: ParameterValues,
    state: IntegratorState,
    work: Workspace,
    period: float,
    phase: float,
    t_end: float,
    known: KnownReturns,
) -> tuple[int, float] | None:
    """Return the number of the attractor that a motion leads to (-1: none of those known), and when that was seen.

    A motion is on an attractor when its returns are near those of the attractor, in their order, for longer than these
    take and than the longest delay. None says that it comes to where the tables of ``system`` have nothing yet.
    """
    allowed = NEAR * known.size + NEAR_ERRORS * values.atol
    expected, since, met = -1, 0.0, 0
    stop = np.array([np.nan])
    while True:
        status = advance_to_return(system, values, state, work, period, phase, t_end, stop)
        if status == Status.CAPACITY:
            state = enlarge(state)
            continue
        if status == Status.NEW_WAY:
            return None
        if status != Status.SECTION:
            return -1, float(state.clock[T])
        near = np.all(np.abs(known.points - state.y[: system.n]) <= allowed, axis=1)
        if expected >= 0 and near[expected]:
            found, met = expected, met + 1
        else:
            found, met = int(np.argmax(near)) if near.any() else -1, 1
            since = state.clock[T]
        expected = -1 if found < 0 else int(known.following[found])
        settled = found >= 0 and met > known.length[found]
        if settled and state.clock[T] - since >= max(values.longest, state.lag_time[LONGEST]):
            return int(known.owner[found]), float(state.clock[T])


def _start_chain(system: System, state: IntegratorState) -> None:
    """Let the chains of a constant history begin: every stage has the value of the state, and no derivatives."""
    for i in range(len(system.pair_state) if system.chain_n > 0 else 0):
        for stage in range(system.chain_n):
            state.y[system.n + (i * system.chain_n + stage) * system.chain_order] = state.constant[system.pair_state[i]]
