"""An integration that goes on from a motion known as a piecewise polynomial, such as a periodic orbit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.native.integrator import CONSTANT, FIRST, N_PENDING, N_REJECTED, N_STEPS, USED, Status
from pddecont.simulate.failure import MotionFailure
from pddecont.simulate.integrator import (
    IntegratorState,
    ParameterValues,
    begin_inside_arc,
    enlarge,
    make_log,
    make_state,
    run,
)
from pddecont.simulate.past import Past
from pddecont.simulate.simulator import Simulator

Array = NDArray[np.float64]
# Events that are recorded of a motion; one with more goes another way than what it is compared with.
MAX_EVENTS = 128
# Steps that there is room for at first beside those of the past: more than most segments of an orbit take.
ROOM = 96


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
    number = simulator.tables.add_mode(mode)
    events = [simulator.tables.add_event(event) for _, event in pending]
    system = simulator.system
    values = simulator.reached.fit_values(values)
    kept = simulator.past_columns
    used = len(past.time) if len(kept) else 0
    state = make_state(system, values, max(used, len(pending)) + ROOM)
    if used:
        state.past_time[:used], state.past_length[:used], state.past_end[:used] = past.time, past.length, past.end
        state.past_arc[:used] = past.arc
        state.past_value[:used, : len(kept)] = past.value[:, kept]
        state.past_coefficients[:used, :, : len(kept)] = past.coefficients[:, :, kept]
    state.count[FIRST], state.count[USED], state.count[CONSTANT] = 0, used, 0
    state.y[: system.n] = states
    state.count[N_PENDING] = len(pending)
    for k, ((time, _), event) in enumerate(zip(pending, events, strict=True)):
        state.pending_time[k], state.pending_event[k] = time, event
    arc = int(past.arc[-1])
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
    log = make_log(simulator.system.n, 0, MAX_EVENTS)
    while True:
        values, state = simulator.reached.fit(values, state)
        left = most_steps - int(state.count[N_STEPS] + state.count[N_REJECTED])
        status = Status.PAUSED
        if left > 0:
            status = Status(run(simulator.system, values, state, log, simulator.work, t_stop, left))
        if status in (Status.CAPACITY, Status.NEW_WAY):
            state = simulator.make_room(values, state, status)
        elif status == Status.PAUSED:
            return None
        elif status != Status.SECTION:
            break
    n = int(log.n[1])
    names = list(simulator.tables.segments)
    failure = None
    if status not in (Status.REACHED, Status.LOG_FULL):
        failure = simulator.diagnose(state, status, values.p)
    segments = tuple(names[k] for k in log.event_segment[:n])
    return MotionRecord(log.event_time[:n], segments, state.y[: simulator.system.n].copy(), failure)
