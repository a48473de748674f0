"""Largest Lyapunov exponents, from the tangent of a motion that is integrated along with it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pddecont.native.integrator import Status
from pddecont.simulate.attractors import Attractor
from pddecont.simulate.failure import MotionFailure
from pddecont.simulate.integrator import IntegratorState, ParameterValues, measure_growth
from pddecont.simulate.motion_row import unpack_motion
from pddecont.simulate.simulator import TANGENT_SEED, Simulator

# Intervals over which the growth of a tangent is taken: enough for a slope with an uncertainty, and a bound on memory.
INTERVALS, MAX_INTERVALS = 200, 1_000_000
# A tangent that shrinks or grows beyond what numbers hold within an interval is tried in intervals so much shorter.
SHORTER = (1, 32, 1024)
# The part of the time that the tangent has to turn into the direction of strongest growth.
TURNING_PART = 4


@dataclass(frozen=True)
class LyapunovExponent:
    """A largest Lyapunov exponent, per unit of time, and its uncertainty.

    NaN where there is none; ``failure`` says why where the motion could not be followed for so long.
    """

    value: float = np.nan
    uncertainty: float = np.nan
    failure: MotionFailure | None = None


def find_lyapunov_exponent(
    simulator: Simulator, values: ParameterValues, attractor: Attractor, duration: float
) -> LyapunovExponent:
    """Return the largest Lyapunov exponent of an attractor, from ``duration`` of its motion.

    It is the slope of the logarithm of the tangent's length over time, its uncertainty how much slope the departures
    from it could hide. The tangent of the motion, its jumps at events and where they come back through delays, and its
    past are integrated along with the motion, after a part of ``duration`` that lets it turn into the direction of
    strongest growth.

    References
    ----------
    Benettin, Galgani, Giorgilli, Strelcyn, Meccanica 15 (1980).
    """
    if attractor.failure is not None:
        return LyapunovExponent()
    with_tangent = replace(simulator, tangent=True)
    logs = np.zeros(0)
    for shorter in SHORTER:
        n_intervals = shorter * max(INTERVALS, int(np.ceil(duration / attractor.turn)) if attractor.turn > 0 else 0)
        if n_intervals > MAX_INTERVALS:
            break
        logs = np.zeros(n_intervals)
        interval = duration / n_intervals
        state = _start_tangent(with_tangent, values, attractor)
        state, status = _follow_growth(with_tangent, values, state, interval, logs[: n_intervals // TURNING_PART])
        if status == Status.REACHED and np.all(np.isfinite(logs)):
            state, status = _follow_growth(with_tangent, values, state, interval, logs)
        if status != Status.REACHED:
            return LyapunovExponent(failure=simulator.diagnose(state, status, values.p))
        if np.all(np.isfinite(logs)):
            total, times = np.cumsum(logs), interval * np.arange(1, n_intervals + 1)
            slope, level = np.polyfit(times, total, 1)
            departure = float(np.std(total - slope * times - level))
            return LyapunovExponent(float(slope), float(np.sqrt(12.0) * departure / duration))
    # The tangent vanishes at once: the motion forgets where it came from.
    return LyapunovExponent(-np.inf, 0.0) if np.any(np.isneginf(logs)) else LyapunovExponent()


def _follow_growth(
    simulator: Simulator, values: ParameterValues, state: IntegratorState, interval: float, logs: NDArray[np.float64]
) -> tuple[IntegratorState, Status]:
    """Write the logarithm of the tangent's growth over each interval to ``logs``; return the state and how it ended."""
    done = np.array([0.0, np.nan])
    while True:
        values, state = simulator.reached.fit(values, state)
        status = Status(measure_growth(simulator.system, values, state, simulator.work, interval, logs, done))
        if status not in (Status.CAPACITY, Status.NEW_WAY):
            return state, status
        state = simulator.make_room(values, state, status)


def _start_tangent(simulator: Simulator, values: ParameterValues, attractor: Attractor) -> IntegratorState:
    """Return the integration at the last return of an attractor, with a tangent in a direction of no meaning."""
    state = unpack_motion(simulator.reached, values, attractor.packed_state)
    state.y[simulator.system.n_full :] = np.random.default_rng(TANGENT_SEED).standard_normal(simulator.system.n_full)
    return state
