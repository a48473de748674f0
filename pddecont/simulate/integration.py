"""Trajectories of a model: integration with all steps and events kept, or those after a time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.delay import DelayMethod
from pddecont.native.integrator import N_STEPS, Status
from pddecont.simulate.integrator import IntegratorState, Log, make_log
from pddecont.simulate.method import Method
from pddecont.simulate.past_plan import find_longest_lag
from pddecont.simulate.simulator import Simulator
from pddecont.simulate.trajectory import Events, Trajectory

Array = NDArray[np.float64]
# Steps and events that a log holds before it is copied: some MiB, seldom full.
LOG_STEPS, LOG_EVENTS = 4096, 4096


def simulate(
    numeric: NumericModel,
    p: Array,
    delay: DelayMethod,
    t_end: float,
    method: Method | None = None,
    *,
    initial: Sequence[float] | None = None,
    mode: str | None = None,
    constant: bool = False,
    history: tuple[sympy.Expr, ...] | None = None,
    schedule: Sequence[tuple[float, Array]] = (),
    keep_from: float = 0.0,
    on_progress: Callable[[float], None] | None = None,
) -> Trajectory:
    """Return the trajectory from t = 0 to ``t_end`` at parameters ``p`` (n_parameters,).

    Parameters
    ----------
    initial, mode
        Replace the model's states and mode at t = 0.
    constant, history
        The history for t < 0 is the initial states, or these expressions in t; without either it is the model's.
    schedule
        Times, in order, from which on other parameters hold.
    keep_from
        Steps that end before this time are not kept.
    on_progress
        Called with times reached.

    Raises
    ------
    ConvergenceError
        If events accumulate and do not stick, if the solution grows without bound, or if no step is small enough.
    """
    simulator = Simulator(numeric, delay, method or Method(), history=history)
    changes = [(t, np.asarray(q, dtype=float)) for t, q in schedule if t < t_end]
    longest = max([find_longest_lag(numeric, q) for _, q in changes], default=0.0)
    values = simulator.values(np.asarray(p, dtype=float), longest)
    state = simulator.start(values, initial, mode, constant=constant)
    return record_trajectory(simulator, values.p, state, t_end, changes, keep_from, longest, on_progress)


def record_trajectory(
    simulator: Simulator,
    p: Array,
    state: IntegratorState,
    t_end: float,
    changes: Sequence[tuple[float, Array]] = (),
    keep_from: float = -np.inf,
    longest: float = 0.0,
    on_progress: Callable[[float], None] | None = None,
) -> Trajectory:
    """Return the trajectory of an integration from its present time to ``t_end``.

    ``changes`` are times, in order, from which on other parameters hold; the past is kept for ``longest``, or the
    longest delay.
    """
    recorder = _Recorder(simulator, keep_from)
    log = make_log(simulator.system.n, LOG_STEPS, LOG_EVENTS)
    values = simulator.values(p, longest)
    n_steps = state.count[N_STEPS]
    for t, q in [*changes, (t_end, None)]:
        status = Status.SECTION
        while status == Status.SECTION:
            state, status = simulator.advance(values, state, t, log, on_progress, recorder.take_log)
        if q is not None:
            state, values = simulator.change_parameters(state, values, q, longest)
    recorder.take_log(log)
    return recorder.make_trajectory(int(state.count[N_STEPS] - n_steps))


class _Recorder:
    """Collects what logs hold before they are emptied."""

    def __init__(self, simulator: Simulator, keep_from: float):
        self.tables, self.method, self.keep_from = simulator.tables, simulator.method, keep_from
        self.steps: list[tuple[NDArray[Any], ...]] = []
        self.events: list[tuple[NDArray[Any], ...]] = []

    def take_log(self, log: Log) -> None:
        """Copy what belongs to the trajectory and empty the log."""
        n, n_events = log.n
        late = log.end[:n] >= self.keep_from
        self.steps.append(
            tuple(a[:n][late] for a in (log.time, log.length, log.end, log.arc, log.mode, log.value, log.coefficients))
        )
        late = log.event_time[:n_events] >= self.keep_from
        self.events.append(
            tuple(a[:n_events][late] for a in (log.event_time, log.event_segment, log.before, log.after, log.event_arc))
        )
        log.n[:] = 0

    def make_trajectory(self, n_steps: int) -> Trajectory:
        """Return what was kept as a trajectory."""
        time, length, end, arc, mode, value, coefficients = (np.concatenate(a) for a in zip(*self.steps, strict=True))
        t, segment, before, after, event_arc = (np.concatenate(a) for a in zip(*self.events, strict=True))
        modes, segments = list(self.tables.modes), list(self.tables.segments)
        events = Events(t, tuple(segments[s] for s in segment), before, after, event_arc)
        names, rtol, atol = tuple(modes[m] for m in mode), self.method.rtol, self.method.atol
        return Trajectory(time, length, end, arc, names, value, coefficients, events, n_steps, rtol, atol)
