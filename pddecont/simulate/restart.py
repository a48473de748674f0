"""An integration that goes on from a motion known as a piecewise polynomial, such as a periodic orbit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pddecont.simulate.failure import MotionFailure
from pddecont.simulate.integrator import (
    CONSTANT,
    FIRST,
    N_COEFFICIENTS,
    N_PENDING,
    N_REJECTED,
    N_STEPS,
    USED,
    IntegratorState,
    ParameterValues,
    Status,
    System,
    begin_inside_arc,
    enlarge,
    make_log,
    make_state,
    run,
)
from pddecont.simulate.simulator import Simulator

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
# Events that are recorded of a motion; one with more goes another way than what it is compared with.
MAX_EVENTS = 128


def make_extension_basis(s: Array) -> Array:
    """Return what the coefficients of a continuous extension are multiplied with at ``s`` (n,).

    The result has shape (n, 1 + N_COEFFICIENTS): its first column belongs to the value at the step's beginning. The
    polynomials have degree 0 to N_COEFFICIENTS.

    Reference: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), section II.6.
    """
    columns, product = [np.ones_like(s)], np.ones_like(s)
    for i in range(N_COEFFICIENTS):
        product = product * (s if i % 2 == 0 else 1.0 - s)
        columns.append(product)
    return np.stack(columns, axis=-1)


@dataclass(frozen=True, eq=False)
class Past:
    """A motion up to some time as steps with continuous extensions.

    Attributes
    ----------
    time, length, end
        Where a step begins, how long it is, and up to where it belongs to the motion (n_steps,).
    arc
        The arc that it belongs to (n_steps,): values and slopes jump where one follows another.
    value, coefficients
        Its continuous extension (n_steps, n_states), (n_steps, N_COEFFICIENTS, n_states).
    """

    time: Array
    length: Array
    end: Array
    arc: Integers
    value: Array
    coefficients: Array

    def until(self, t: float) -> Past:
        """Return the past up to ``t``, the step that holds it cut there."""
        n = max(1, int(np.searchsorted(self.time, t, side="left")))
        return Past(
            self.time[:n],
            self.length[:n],
            np.minimum(self.end[:n], t),
            self.arc[:n],
            self.value[:n],
            self.coefficients[:n],
        )

    def between(self, begin: float, end: float) -> Past:
        """Return the steps that hold times from ``begin`` to ``end``, whole."""
        rows = (self.end > begin) & (self.time < end)
        return Past(
            self.time[rows],
            self.length[rows],
            self.end[rows],
            self.arc[rows],
            self.value[rows],
            self.coefficients[rows],
        )

    def shift(self, by: float) -> Past:
        """Return the same motion so much later."""
        return replace(self, time=self.time + by, end=self.end + by)


@dataclass(frozen=True, eq=False)
class DrivenSimulator(Simulator):
    """A model whose delayed values are given functions of time.

    They are read from a past that holds one column a delayed value instead of the states, all of them as long ago as
    the one entry of ``tau`` in the parameter values says. It takes the direct method.
    """

    @cached_property
    def system(self) -> System:
        """The model in numbers, delayed value i read from column i."""
        own = super().system
        every = np.arange(len(own.pair_state))
        return own._replace(pair_state=every, pair_delay=0 * every, kept=0 * every, place=every)

    def values(self, p: Array, longest: float = 0.0) -> ParameterValues:
        """Return the model's numbers at parameters ``p``, but for how long ago delayed values are read."""
        values = super().values(p, longest)
        model = self.numeric.model
        longest_step = float(self.numeric.period.value(p)[0]) / 2 if model.forced else self.method.max_step
        return values._replace(max_step=longest_step)


def restart_motion(
    simulator: Simulator,
    values: ParameterValues,
    past: Past,
    t: float,
    states: Array,
    mode: str,
    pending: Sequence[tuple[float, str]],
) -> IntegratorState:
    """Return the state of an integration at ``t``, inside the last arc of ``past``, with ``states`` (n_states,).

    ``pending`` are the delayed events under way, (time, event) in order.
    """
    system, model = simulator.system, simulator.numeric.model
    events = list(model.events)
    # A driven model has its own columns.
    kept = system.place if isinstance(simulator, DrivenSimulator) else system.kept
    state = make_state(system, values)
    used = len(past.time) if len(kept) else 0
    while len(state.past_time) <= max(used + 2, len(pending) + 2):
        state = enlarge(state)
    if used:
        state.past_time[:used], state.past_length[:used], state.past_end[:used] = past.time, past.length, past.end
        state.past_arc[:used] = past.arc
        state.past_value[:used, : len(kept)] = past.value[:, kept]
        state.past_coefficients[:used, :, : len(kept)] = past.coefficients[:, :, kept]
    state.count[FIRST], state.count[USED], state.count[CONSTANT] = 0, used, 0
    state.y[: system.n] = states
    state.count[N_PENDING] = len(pending)
    for k, (time, event) in enumerate(pending):
        state.pending_time[k], state.pending_event[k] = time, events.index(event)
    number, arc = list(model.modes).index(mode), int(past.arc[-1])
    while (
        begin_inside_arc(system, values, state, simulator.work, t, float(past.time[0]), number, arc) == Status.CAPACITY
    ):
        state = enlarge(state)
    return state


@dataclass(frozen=True, eq=False)
class MotionRecord:
    """What a motion did up to some time.

    Attributes
    ----------
    times, segments
        When events happened (n_events,), and the segments that they ended.
    states
        States at the end (n_states,).
    failure
        Why it came to a halt; None if it did not.
    """

    times: Array
    segments: tuple[str, ...]
    states: Array
    failure: MotionFailure | None


def follow_motion(
    simulator: Simulator, values: ParameterValues, state: IntegratorState, t_stop: float, most_steps: int
) -> MotionRecord | None:
    """Return what a motion does up to ``t_stop``; None if that takes more than ``most_steps`` steps."""
    system = simulator.system
    log = make_log(system.n, 0, MAX_EVENTS)
    while True:
        left = most_steps - int(state.count[N_STEPS] + state.count[N_REJECTED])
        status = Status(run(system, values, state, log, simulator.work, t_stop, left)) if left > 0 else Status.PAUSED
        if status == Status.CAPACITY:
            state = enlarge(state)
        elif status == Status.PAUSED:
            return None
        elif status != Status.SECTION:
            break
    n = int(log.n[1])
    names = list(simulator.numeric.model.segments)
    failure = None
    if status not in (Status.REACHED, Status.LOG_FULL):
        failure = simulator.diagnose(state, status, values.p)
    segments = tuple(names[k] for k in log.event_segment[:n])
    return MotionRecord(log.event_time[:n], segments, state.y[: system.n].copy(), failure)
