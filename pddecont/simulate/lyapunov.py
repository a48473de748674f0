"""Largest Lyapunov exponents, from the tangent of a motion that is integrated along with it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ConvergenceError
from pddecont.simulate.attractors import Attractor
from pddecont.simulate.kernel.returns import growth
from pddecont.simulate.kernel.tables import Memory, Status, Values, enlarged
from pddecont.simulate.simulator import Simulator
from pddecont.simulate.snapshot import unpack

INTERVALS, MAX_INTERVALS = 200, 1_000_000


@dataclass(frozen=True)
class Exponent:
    """A largest Lyapunov exponent, per unit of time, and its uncertainty; NaN where there is none, and ``note`` says why."""

    value: float = np.nan
    uncertainty: float = np.nan
    note: str = ""


def lyapunov(simulator: Simulator, values: Values, attractor: Attractor, duration: float) -> tuple[float, float]:
    """Return the largest Lyapunov exponent of an attractor, per unit of time, and its uncertainty.

    They are the slope of the logarithm of the tangent's length over time, and how much slope the departures from it could hide.
    The tangent of the motion, its jumps at events and their echoes, and its past are integrated along with the motion (Benettin et
    al., Meccanica 15, 1980), after a quarter of ``duration`` that lets it turn into the direction of strongest growth.
    """
    if attractor.failed:
        return np.nan, np.nan
    with_tangent = replace(simulator, tangent=True)
    logs = np.zeros(0)
    # A tangent that shrinks or grows beyond what numbers hold within an interval wants shorter ones.
    for shorter in (1, 32, 1024):
        n_intervals = shorter * max(INTERVALS, int(np.ceil(duration / attractor.turn)) if attractor.turn > 0 else 0)
        if n_intervals > MAX_INTERVALS:
            break
        logs = np.zeros(n_intervals)
        interval = duration / n_intervals
        memory = _tangent_at(with_tangent, values, attractor)
        memory, status = _grown(with_tangent, values, memory, interval, logs[: n_intervals // 4])
        if status == Status.REACHED and np.all(np.isfinite(logs)):
            memory, status = _grown(with_tangent, values, memory, interval, logs)
        if status != Status.REACHED:
            raise ConvergenceError(simulator.complaint(memory, status, values.p))
        if np.all(np.isfinite(logs)):
            total, times = np.cumsum(logs), interval * np.arange(1, n_intervals + 1)
            slope, level = np.polyfit(times, total, 1)
            departure = float(np.std(total - slope * times - level))
            return float(slope), float(np.sqrt(12.0) * departure / duration)
    # The tangent vanishes at once: the motion forgets where it came from.
    return (-np.inf, 0.0) if np.any(np.isneginf(logs)) else (np.nan, np.nan)


def _grown(simulator: Simulator, values: Values, memory: Memory, interval: float, logs: NDArray[np.float64]) -> tuple[Memory, Status]:
    """Write the logarithm of the tangent's growth over each interval; return the memory, which may have grown, and how it ended."""
    done = np.array([0.0, np.nan])
    while True:
        status = Status(growth(simulator.system, values, memory, simulator.work, interval, logs, done))
        if status != Status.ROOM:
            return memory, status
        memory = enlarged(memory)


def known_exponent(simulator: Simulator, values: Values, attractor: Attractor, duration: float) -> Exponent:
    """Return the exponent of :func:`lyapunov`, or why there is none where the motion cannot be followed for so long."""
    try:
        return Exponent(*lyapunov(simulator, values, attractor, duration))
    except ConvergenceError as exc:
        return Exponent(note=f"no Lyapunov exponent: {exc}")


def _tangent_at(simulator: Simulator, values: Values, attractor: Attractor) -> Memory:
    """Return the integration at an attractor's last return with a tangent in a direction of no meaning."""
    memory = unpack(simulator.system, values, attractor.memory)
    memory.y[simulator.system.n_full :] = np.random.default_rng(1).standard_normal(simulator.system.n_full)
    return memory
