"""A trajectory of a model: integration with everything kept, or with what comes before a time forgotten."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.delay.operator import DelayMethod
from pddecont.model.codegen import NumericModel
from pddecont.simulate.kernel.tables import N_STEPS, Log, Memory, Status, new_log
from pddecont.simulate.simulator import Method, Simulator
from pddecont.simulate.trajectory import Events, Trajectory

Array = NDArray[np.float64]
LOG_STEPS, LOG_EVENTS = 4096, 4096


def simulate(numeric: NumericModel, p: Array, delay: DelayMethod, t_end: float, method: Method | None = None, *,
             initial: Sequence[float] | None = None, mode: str | None = None, constant: bool = False,
             history: tuple[sympy.Expr, ...] | None = None, schedule: Sequence[tuple[float, Array]] = (), keep_from: float = 0.0,
             heard: Callable[[float], None] | None = None) -> Trajectory:  # fmt: skip
    """Return the trajectory from t = 0 to ``t_end`` at parameters ``p``; steps that end before ``keep_from`` are forgotten.

    Parameters
    ----------
    initial, mode
        Replace the model's states and mode at t = 0.
    constant, history
        The history for t < 0 is the initial states, or these expressions in t; without either it is the model's.
    schedule
        Times, in order, from which on other parameters hold.
    heard
        Hears of times reached.
    """
    simulator = Simulator(numeric, delay, method or Method(), history=history)
    changes = [(t, np.asarray(q, dtype=float)) for t, q in schedule if t < t_end]
    longest = max([float(np.max(numeric.delays.value(q), initial=0.0)) for _, q in changes], default=0.0)
    values = simulator.values(np.asarray(p, dtype=float), longest)
    memory = simulator.start(values, initial, mode, constant=constant)
    return follow(simulator, values.p, memory, t_end, changes, keep_from, longest, heard)


def follow(simulator: Simulator, p: Array, memory: Memory, t_end: float, changes: Sequence[tuple[float, Array]] = (),
           keep_from: float = -np.inf, longest: float = 0.0, heard: Callable[[float], None] | None = None) -> Trajectory:  # fmt: skip
    """Return the trajectory from where an integration stands to ``t_end``."""
    record = _Record(simulator, keep_from)
    log = new_log(simulator.system.n, LOG_STEPS, LOG_EVENTS)
    values = simulator.values(p, longest)
    n_steps = memory.count[N_STEPS]
    for t, q in [*changes, (t_end, None)]:
        status = Status.SECTION
        while status == Status.SECTION:
            memory, status = simulator.advance(values, memory, t, log, heard, record.take)
        if q is not None:
            memory, values = simulator.change(memory, values, q, longest)
    record.take(log)
    return record.trajectory(int(memory.count[N_STEPS] - n_steps))


class _Record:
    """Collects what logs hold before they are emptied."""

    def __init__(self, simulator: Simulator, keep_from: float):
        self.model, self.keep_from = simulator.numeric.model, keep_from
        self.steps: list[tuple[Array, ...]] = []
        self.events: list[tuple[Array, ...]] = []

    def take(self, log: Log) -> None:
        """Copy what belongs to the trajectory and empty the log."""
        n, n_events = log.n
        late = log.end[:n] >= self.keep_from
        self.steps.append(tuple(a[:n][late] for a in (log.time, log.length, log.end, log.arc, log.mode, log.value, log.coefficients)))
        late = log.event_time[:n_events] >= self.keep_from
        self.events.append(tuple(a[:n_events][late] for a in (log.event_time, log.event_segment, log.before, log.after, log.event_arc)))
        log.n[:] = 0

    def trajectory(self, n_steps: int) -> Trajectory:
        """Return what was kept as a trajectory."""
        time, length, end, arc, mode, value, coefficients = (np.concatenate(a) for a in zip(*self.steps, strict=True))
        t, segment, before, after, event_arc = (np.concatenate(a) for a in zip(*self.events, strict=True))
        modes, segments = list(self.model.modes), list(self.model.segments)
        events = Events(t, tuple(segments[s] for s in segment), before, after, event_arc)
        return Trajectory(time, length, end, arc, tuple(modes[m] for m in mode), value, coefficients, events, n_steps)
