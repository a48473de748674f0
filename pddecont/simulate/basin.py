"""Basins of attraction: which attractor each of a grid of initial states leads to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.simulate.attractors import Attractor, find_attractor, find_or_add
from pddecont.simulate.initial_state import InitialState
from pddecont.simulate.integrator import KnownReturns, classify_cells
from pddecont.simulate.motion_task import MotionTask
from pddecont.simulate.returns import ReturnSettings

Array = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class BasinRow:
    """One line of the grid, for one worker.

    ``states`` (n_cells, n_states) are those of its cells, with the mode and the history of ``start``; ``known`` are the
    attractors known before any line was computed.
    """

    p: Array
    settings: ReturnSettings
    states: Array
    start: InitialState
    known: tuple[Attractor, ...]


@dataclass(frozen=True, eq=False)
class ClassifiedRow:
    """Where the cells of a line of the grid lead.

    ``labels`` (n_cells,) are the numbers of known attractors, -1 for none, ``times`` (n_cells,) when they were seen;
    ``strays`` are the attractors of the other cells.
    """

    labels: Integers
    times: Array
    strays: dict[int, Attractor]


def classify_row(task: MotionTask, row: BasinRow) -> ClassifiedRow:
    """Return where the cells of a line lead; those that reach no known attractor are followed until they settle."""
    simulator = task.make_simulator()
    values, start, settings = simulator.values(row.p), row.start, row.settings
    labels, times = np.full(len(row.states), -1), np.zeros(len(row.states))
    template = simulator.start(values, start.states, start.mode, constant=start.constant).y
    modes: list[str | None] = (
        simulator.find_start_modes(values, row.states, constant=start.constant)
        if start.mode is None
        else [start.mode] * len(row.states)
    )
    numbers = np.array([simulator.number_mode(mode) for mode in modes], dtype=np.int64)
    known = _gather_returns(row.known, simulator.system.n)
    done = 0
    while done < len(row.states):
        values = simulator.reached.fit_values(values)
        n_done = classify_cells(
            simulator.system,
            values,
            simulator.work,
            template,
            row.states[done:],
            numbers[done:],
            int(start.constant),
            settings.forcing_period,
            settings.phase,
            settings.transient,
            known,
            labels[done:],
            times[done:],
        )
        done += int(n_done)
        if done < len(row.states):
            # The cell is followed anew when what it came to is there.
            simulator.reached.add_way(values)
    strays = {}
    for cell in np.flatnonzero(labels < 0):
        state = simulator.start(values, row.states[cell], start.mode, constant=start.constant)
        strays[int(cell)] = find_attractor(simulator, values, state, settings)
    return ClassifiedRow(labels, times, strays)


def _gather_returns(known: Sequence[Attractor], n: int) -> KnownReturns:
    periodic = [(k, a) for k, a in enumerate(known) if a.period > 0]
    ends = np.cumsum([0, *(a.period for _, a in periodic)])
    following = [end + np.roll(np.arange(a.period), -1) for (_, a), end in zip(periodic, ends, strict=False)]
    no_points, no_numbers = np.empty((0, n)), np.empty(0, np.int64)
    return KnownReturns(
        np.ascontiguousarray(np.concatenate([no_points, *(a.states for _, a in periodic)])),
        np.concatenate([no_points, *(np.repeat(a.size[None], a.period, axis=0) for _, a in periodic)]),
        np.concatenate([no_numbers, *(np.full(a.period, k) for k, a in periodic)]).astype(np.int64),
        np.concatenate([no_numbers, *following]).astype(np.int64),
        np.concatenate([no_numbers, *(np.full(a.period, a.period) for _, a in periodic)]).astype(np.int64),
    )


def survey_attractors(
    task: MotionTask, p: Array, settings: ReturnSettings, states: Array, start: InitialState
) -> list[Attractor]:
    """Return the different attractors that some initial states (n_motions, n_states) lead to, in their order."""
    simulator = task.make_simulator()
    values = simulator.values(p)
    found: list[Attractor] = []
    for row in states:
        state = simulator.start(values, row, start.mode, constant=start.constant)
        attractor = find_attractor(simulator, values, state, settings)
        find_or_add(attractor, found, values.atol, at_section=not settings.forcing_period)
    return found
