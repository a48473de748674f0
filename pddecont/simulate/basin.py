"""Basins of attraction: which attractor each of a grid of initial states leads to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.simulate.attractors import Attractor, Clock, number_of, settled
from pddecont.simulate.kernel.returns import recognise_cells
from pddecont.simulate.task import Start, Task

Array = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Line:
    """One line of the grid for one worker: starts in one mode, and the attractors known before any line was looked at."""

    task: Task
    p: Array
    clock: Clock
    states: Array
    start: Start
    known: tuple[Attractor, ...]


@dataclass(frozen=True, eq=False)
class Recognised:
    """What became of a line: the number of each cell's attractor (-1: none that is known) and the time it took; the strays themselves."""

    labels: Integers
    times: Array
    strays: dict[int, Attractor]


def basin_line(line: Line) -> Recognised:
    """Return the attractors of a line of initial states; those that reach no known one are followed until they settle."""
    simulator = line.task.simulator()
    values, system, work = simulator.values(line.p), simulator.system, simulator.work
    start = line.start
    n_cells = len(line.states)
    labels, times = np.full(n_cells, -1), np.zeros(n_cells)
    template = simulator.start(values, start.states, start.mode, constant=start.constant).y
    points, owner, following, length, size = _table(line.known, system.n)
    mode = list(line.task.model.modes).index(start.mode)
    recognise_cells(system, values, work, template, line.states, mode, int(start.constant), line.clock.period, line.clock.phase,
                    line.clock.transient, points, owner, following, length, size, labels, times)  # fmt: skip
    strays = {}
    for cell in np.flatnonzero(labels < 0):
        memory = simulator.start(values, line.states[cell], start.mode, constant=start.constant)
        strays[int(cell)] = settled(simulator, values, memory, line.clock)
    return Recognised(labels, times, strays)


def _table(known: Sequence[Attractor], n: int) -> tuple[Array, Integers, Integers, Integers, Array]:
    """Return the returns of all attractors with a period: points, whose they are, which comes next, how many there are, their size."""
    periodic = [(k, a) for k, a in enumerate(known) if a.period > 0]
    points = np.concatenate([np.empty((0, n)), *(a.states for _, a in periodic)])
    owner = np.concatenate([np.empty(0, int), *(np.full(a.period, k) for k, a in periodic)])
    ends = np.cumsum([0, *(a.period for _, a in periodic)])
    turns = [end + np.roll(np.arange(a.period), -1) for (_, a), end in zip(periodic, ends, strict=False)]
    following = np.concatenate([np.empty(0, int), *turns])
    length = np.concatenate([np.empty(0, int), *(np.full(a.period, a.period) for _, a in periodic)])
    size = np.concatenate([np.empty((0, n)), *(np.repeat(a.size()[None], a.period, axis=0) for _, a in periodic)])
    return np.ascontiguousarray(points), owner.astype(np.int64), following.astype(np.int64), length.astype(np.int64), size


def first_look(task: Task, p: Array, clock: Clock, states: Array, start: Start) -> list[Attractor]:
    """Return the different attractors that a coarse choice of initial states (n, n_states) leads to, in the order of the choice."""
    simulator = task.simulator()
    values = simulator.values(p)
    found: list[Attractor] = []
    for row in states:
        memory = simulator.start(values, row, start.mode, constant=start.constant)
        number_of(settled(simulator, values, memory, clock), found, values.atol, at_section=not clock.period)
    return found
