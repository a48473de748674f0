"""The state of an integration as a row of numbers that any process can read, whatever its motions have reached.

Of a model that builds its modes as they are reached, the numbers of modes and segments mean something only together
with the order in which they were reached: it stands before the state.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.native.integrator import LAST_EVENT, MODE, N_PENDING
from pddecont.simulate.integrator import IntegratorState, ParameterValues, make_state
from pddecont.simulate.part_tables import PartTables
from pddecont.simulate.reached_system import ReachedSystem
from pddecont.simulate.snapshot import LARGEST_WHOLE, NOT_THIS_MODEL, pack, unpack

Array = NDArray[np.float64]


def pack_motion(tables: PartTables, state: IntegratorState) -> Array:
    """Return all that an integration needs to go on, and what its numbers mean, shape (n_numbers,).

    Tables that hold all of a model need no words: their numbers are those of the model.
    """
    row = pack(state)
    if tables.builds_all:
        return row
    steps = [(leader, *digits) for leader, digits in tables.steps]
    return np.concatenate([[len(steps)], np.array(steps, dtype=float).ravel(), row])


def unpack_motion(reached: ReachedSystem, values: ParameterValues, row: Array) -> IntegratorState:
    """Return the state of an integration from what :func:`pack_motion` returned.

    Raises
    ------
    ValueError
        If the row is not the state of an integration of this model.
    """
    if reached.tables.builds_all:
        return unpack(reached.system, reached.fit_values(values), row)
    other = reached.make_another()
    rest = _repeat_steps(other.tables, np.asarray(row, dtype=float))
    state = unpack(other.system, other.fit_values(values), rest)
    reached.tables.add_from(other.tables)
    return _renumber(state, other.tables, reached, values)


def _repeat_steps(tables: PartTables, row: Array) -> Array:
    """Let tables reach what a row says, in its order; return the rest of the row."""
    width = 1 + tables.n_keys
    n_steps = int(row[0]) if len(row) and 0 <= row[0] < LARGEST_WHOLE else -1
    if not 0 <= n_steps * width < len(row):
        raise ValueError(NOT_THIS_MODEL)
    for leader, *digits in row[1 : 1 + n_steps * width].reshape(n_steps, width).tolist():
        try:
            tables.repeat(int(leader), tuple(map(int, digits)))
        except (KeyError, ValueError, OverflowError) as exc:
            raise ValueError(NOT_THIS_MODEL) from exc
    return row[1 + n_steps * width :]


def _renumber(
    old: IntegratorState, tables: PartTables, reached: ReachedSystem, values: ParameterValues
) -> IntegratorState:
    """Return a state with the numbers of other tables in those of a system that has reached as much."""
    now, system = reached.tables, reached.system
    modes, segments, events = (
        np.array([there[name] for name in here], dtype=np.int64)
        for here, there in ((tables.modes, now.modes), (tables.segments, now.segments), (tables.events, now.events))
    )
    new = make_state(system, reached.fit_values(values))
    new.next_step[modes] = old.next_step
    new.segment_counts[segments] = old.segment_counts
    new.accumulation[events] = old.accumulation[: len(events)]
    for before, after in ((old.side, new.side), (old.residue, new.residue)):
        after[segments], after[-1] = before[:-1], before[-1]
    state = old._replace(
        next_step=new.next_step,
        segment_counts=new.segment_counts,
        accumulation=new.accumulation,
        side=new.side,
        residue=new.residue,
    )
    if state.count[MODE] >= 0:
        state.count[MODE] = modes[state.count[MODE]]
    if 0 <= state.count[LAST_EVENT] < len(events):
        state.count[LAST_EVENT] = events[state.count[LAST_EVENT]]
    pending = slice(int(state.count[N_PENDING]))
    state.pending_event[pending] = events[state.pending_event[pending]]
    return state
