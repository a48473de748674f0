"""The state of an integration, and its arrays, for tables that have grown since they were made."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.simulate.integrator.buffers import ReturnBuffer, Workspace
from pddecont.simulate.integrator.state import IntegratorState, make_state
from pddecont.simulate.integrator.system import ParameterValues, System


def fit_state(state: IntegratorState, system: System, values: ParameterValues) -> IntegratorState:
    """Return the state of an integration for larger tables: what is new has not happened yet."""
    if len(state.segment_counts) == len(system.segment_mode) and len(state.accumulation) == len(system.after):
        return state
    new = make_state(system, values)
    # The last row belongs to the section where that is one more event function.
    n_events = len(state.accumulation) - (system.section >= 0)
    new.accumulation[:n_events] = state.accumulation[:n_events]
    new.segment_counts[: len(state.segment_counts)] = state.segment_counts
    new.next_step[: len(state.next_step)] = state.next_step
    for old, larger in ((state.side, new.side), (state.residue, new.residue)):
        _keep_last(old, larger)
    return state._replace(
        accumulation=new.accumulation,
        segment_counts=new.segment_counts,
        side=new.side,
        residue=new.residue,
        next_step=new.next_step,
    )


def fit_workspace(work: Workspace, system: System) -> Workspace:
    """Return the arrays for intermediate results with room for larger tables."""
    crossing, passed = (np.zeros(len(system.after) + 1, np.int64) for _ in range(2))
    found_side = np.zeros(len(system.segment_mode) + 1, np.int64)
    crossing[: len(work.crossing)], passed[: len(work.passed)] = work.crossing, work.passed
    _keep_last(work.found_side, found_side)
    return work._replace(crossing=crossing, passed=passed, found_side=found_side)


def fit_returns(returns: ReturnBuffer, system: System) -> ReturnBuffer:
    """Return a buffer of returns that counts new segments too."""
    more = len(system.segment_mode) - returns.segment_counts.shape[1]
    return returns._replace(segment_counts=np.pad(returns.segment_counts, ((0, 0), (0, more)))) if more else returns


def _keep_last(old: NDArray[np.generic], larger: NDArray[np.generic]) -> None:
    """Copy numbers of segments; the last one is the section's."""
    larger[: len(old) - 1], larger[-1] = old[:-1], old[-1]
