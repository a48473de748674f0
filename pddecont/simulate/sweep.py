"""Brute-force diagrams: where motions settle, parameter by parameter, from given starts or carried along."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.simulate.attractors import Attractor, Clock, number_of, settled
from pddecont.simulate.kernel.tables import T, Values
from pddecont.simulate.lyapunov import Exponent, known_exponent
from pddecont.simulate.simulator import Simulator
from pddecont.simulate.snapshot import moved, restart_time, unpack
from pddecont.simulate.task import Start, Task

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Cell:
    """One parameter point of a sweep: parameters, when returns come, where motions start."""

    index: int
    p: Array
    clock: Clock
    starts: tuple[Start, ...]


@dataclass(frozen=True, eq=False)
class Found:
    """An attractor at one parameter point, the share of the starts that lead to it, and its Lyapunov exponent."""

    cell: Cell
    attractor: Attractor
    share: float
    exponent: Exponent


@dataclass(frozen=True, eq=False)
class Chunk:
    """Parameter points for one worker; where ``carried``, each motion goes on from where it stood at the point before."""

    task: Task
    cells: tuple[Cell, ...]
    carried: bool
    exponents: bool


def sweep_chunk(chunk: Chunk) -> list[Found]:
    """Return the attractors of a chunk's parameter points, those of one point in the order in which the starts find them."""
    simulator = chunk.task.simulator()
    # A motion that is carried along takes as much of its past with it as the longest delay on the way will read.
    delays = [simulator.numeric.delays.value(cell.p).max(initial=0.0) for cell in chunk.cells] if chunk.carried else [0.0]
    longest = float(max(delays))
    before: list[Attractor | None] = []
    found: list[Found] = []
    for cell in chunk.cells:
        values = simulator.values(cell.p, longest)
        now = []
        for i, start in enumerate(cell.starts):
            previous = before[i] if chunk.carried and before else None
            now.append(_follow(simulator, values, cell, start, previous))
        before = list(now)
        for attractor, share in distinct(now, values.atol, at_section=not cell.clock.period):
            exponent = known_exponent(simulator, values, attractor, cell.clock.transient) if chunk.exponents else Exponent()
            found.append(Found(cell, attractor, share, exponent))
    return found


def _follow(simulator: Simulator, values: Values, cell: Cell, start: Start, previous: Attractor | None) -> Attractor:
    if previous is None or previous.halted:
        memory = simulator.start(values, start.states, start.mode, constant=start.constant)
    else:
        old = simulator.values(previous.p, values.longest)
        memory = unpack(simulator.system, old, previous.memory)
        memory = moved(memory, restart_time(simulator.numeric, previous.p, cell.p, float(memory.clock[T])))
        memory, _ = simulator.change(memory, old, cell.p, values.longest)
    return settled(simulator, values, memory, cell.clock)


def distinct(attractors: Sequence[Attractor], atol: float, *, at_section: bool) -> list[tuple[Attractor, float]]:
    """Return each different attractor once, with its share."""
    kinds: list[Attractor] = []
    numbers = [number_of(attractor, kinds, atol, at_section=at_section) for attractor in attractors]
    return [(kind, numbers.count(k) / len(numbers)) for k, kind in enumerate(kinds)]
