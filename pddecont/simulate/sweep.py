"""Brute-force diagrams: where motions settle, parameter by parameter, from given starts or carried along."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.simulate.attractors import Attractor, find_attractor, group_attractors
from pddecont.simulate.initial_state import InitialState
from pddecont.simulate.integrator import ParameterValues
from pddecont.simulate.lyapunov import LyapunovExponent, find_lyapunov_exponent
from pddecont.simulate.motion_row import unpack_motion
from pddecont.simulate.motion_task import MotionTask
from pddecont.simulate.past_plan import find_longest_lag
from pddecont.simulate.returns import ReturnSettings
from pddecont.simulate.simulator import Simulator
from pddecont.simulate.snapshot import find_restart_time, read_time, shift_time

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ParameterPoint:
    """One point of a sweep, numbered: parameters (n_parameters,), when returns come, and where motions start."""

    index: int
    p: Array
    settings: ReturnSettings
    starts: tuple[InitialState, ...]


@dataclass(frozen=True, eq=False)
class SweepAttractor:
    """An attractor at one parameter point, the share of the starts that lead to it, and its Lyapunov exponent."""

    point: ParameterPoint
    attractor: Attractor
    share: float
    exponent: LyapunovExponent


@dataclass(frozen=True, eq=False)
class SweepChunk:
    """Parameter points for one worker.

    Where ``carried``, each motion goes on from where it was at the point before. ``exponents`` says whether Lyapunov
    exponents are computed.
    """

    points: tuple[ParameterPoint, ...]
    carried: bool
    exponents: bool


def sweep_chunk(task: MotionTask, chunk: SweepChunk) -> list[SweepAttractor]:
    """Return the attractors at the points of a chunk, those of a point in the order in which the starts find them."""
    simulator = task.make_simulator()
    # A motion that is carried along keeps as much of its past as the longest delay on the way will read.
    longest = 0.0
    if chunk.carried:
        longest = max(find_longest_lag(simulator.numeric, point.p) for point in chunk.points)
    before: list[Attractor] = []
    found: list[SweepAttractor] = []
    for point in chunk.points:
        values = simulator.values(point.p, longest)
        now = []
        for i, start in enumerate(point.starts):
            previous = before[i] if chunk.carried and before else None
            now.append(_follow_motion(simulator, values, point, start, previous))
        before = now
        for attractor, share in group_attractors(now, values.atol, at_section=not point.settings.forcing_period):
            exponent = LyapunovExponent()
            if chunk.exponents:
                exponent = find_lyapunov_exponent(simulator, values, attractor, point.settings.transient)
            found.append(SweepAttractor(point, attractor, share, exponent))
    return found


def _follow_motion(
    simulator: Simulator,
    values: ParameterValues,
    point: ParameterPoint,
    start: InitialState,
    previous: Attractor | None,
) -> Attractor:
    """Return where a motion settles that starts anew, or from where it was at the point before."""
    if previous is None or (previous.failure is not None and previous.failure.reason.halts):
        state = simulator.start(values, start.states, start.mode, constant=start.constant)
    else:
        old = simulator.values(previous.p, values.longest)
        state = unpack_motion(simulator.reached, old, previous.packed_state)
        state = shift_time(state, find_restart_time(simulator.numeric, previous.p, point.p, read_time(state)))
        state, _ = simulator.change_parameters(state, old, point.p, values.longest)
    return find_attractor(simulator, values, state, point.settings)
