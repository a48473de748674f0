"""Integration of a model with events, resets, delays and delayed events.

Simple and correct: DOP853 steps between events, restarted at every event and, for the delay equation, at every breaking
point; events located on the continuous extension by Brent's method.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy.integrate
import scipy.optimize
from numpy.typing import NDArray

from pddecont.delay.chain import Chain
from pddecont.delay.operator import DelayMethod
from pddecont.errors import ConvergenceError
from pddecont.model.codegen import NumericModel
from pddecont.model.system import Segment
from pddecont.simulate.delays import ChainStates, Delays, Past, history_functions
from pddecont.simulate.trajectory import Arc, Happening, Step, Trajectory

Array = NDArray[np.float64]
SAMPLES = 9
TINY = 1e-300
BREAKING_LEVELS = 6
MAX_EVENTS_AT_ONCE = 1000


@dataclass(frozen=True)
class Tolerances:
    """Relative and absolute error allowed in one step."""

    rtol: float = 1e-9
    atol: float = 1e-11


def simulate(numeric: NumericModel, p: Array, delay: DelayMethod, t_end: float, tolerances: Tolerances | None = None,
             initial: Sequence[float] | None = None, mode: str | None = None,
             progress: Callable[[float], None] | None = None) -> Trajectory:  # fmt: skip
    """Return the trajectory from t = 0 to ``t_end`` at parameters ``p``.

    ``initial`` replaces the model's states at t = 0 (its history for t < 0 stays), ``mode`` its initial mode.
    """
    if isinstance(delay, Chain) and delay.order > 4:
        raise ConvergenceError(f"a chain of order {delay.order} has growing solutions and cannot be simulated (orders 1 to 4 can); give "
                               "the simulate step 'delay: {method: direct}' and the orbit step the chain")  # fmt: skip
    integration = _Integration(numeric, p, delay, tolerances or Tolerances(), t_end)
    return integration.run(initial, mode or numeric.model.initial_mode, progress)


class _Integration:
    def __init__(self, numeric: NumericModel, p: Array, delay: DelayMethod, tolerances: Tolerances, t_end: float):
        self.numeric, self.model, self.p, self.tolerances, self.t_end = numeric, numeric.model, p, tolerances, t_end
        self.n = numeric.n_states
        self.tau = numeric.delays.value(p)
        self.plain_p = p.tolist()
        order = delay.order if isinstance(delay, Chain) else 0
        functions = history_functions(numeric, p, max(order - 1, 0))
        self.history = functions[0]
        self.delays: Delays = (ChainStates(delay, self.model.delayed, self.tau, functions, 0.0) if isinstance(delay, Chain)
                               else Past(self.model.delayed, self.tau, self.history, 0.0))  # fmt: skip
        self.breaking: list[tuple[float, int]] = []
        self.pending: list[tuple[float, str]] = []
        self.trajectory = Trajectory(0.0, [], [])

    def run(self, initial: Sequence[float] | None, mode: str, progress: Callable[[float], None] | None) -> Trajectory:
        x = np.array(self.history(0.0) if initial is None else initial, dtype=float)
        y = np.concatenate([x, self.delays.start(0.0)])
        t, fired = 0.0, None
        self.note_breaking(0.0, 0)
        at_once = 0
        while t < self.t_end:
            arc = Arc(mode)
            self.trajectory.arcs.append(arc)
            self.delays.new_arc(t)
            self.delays.begin(t)
            started = t
            t, y, segment = self.arc(arc, t, y, mode, fired, progress)
            if segment is None:
                break
            at_once = at_once + 1 if t - started <= 1e-12 * (1.0 + abs(t)) else 0
            again = segment.event == fired and t <= started and self.model.events[segment.event].function is not None
            if again or at_once > MAX_EVENTS_AT_ONCE:
                raise ConvergenceError(f"events of '{segment.event}' accumulate at t = {t:.10g} (Zeno), or a reset leads straight back "
                                       "to its own event; give the model a mode that sticks")  # fmt: skip
            y = self.happen(t, y, segment)
            mode, fired = segment.to, segment.event
        return self.trajectory

    def happen(self, t: float, y: Array, segment: Segment) -> Array:
        before = y[: self.n].copy()
        out = [0.0] * self.n
        self.numeric.reset(segment.reset).scalar(t, before.tolist(), self.delays.values(t, y), self.plain_p, out)
        after = np.concatenate([out, y[self.n :]])
        self.trajectory.events.append(Happening(t, segment.name, before, after[: self.n].copy()))
        self.note_breaking(t, 0)
        for event in self.model.events.values():
            if event.after == segment.event and event.delay is not None:
                names = dict(zip(self.model.parameters, self.plain_p, strict=True))
                heapq.heappush(self.pending, (t + self.model.evaluate(event.delay, names), event.name))
        return after

    def note_breaking(self, t: float, level: int) -> None:
        if isinstance(self.delays, Past) and level < BREAKING_LEVELS:
            for tau in self.tau:
                if tau > 0 and t + tau < self.t_end:
                    heapq.heappush(self.breaking, (t + tau, level + 1))

    def next_stop(self, t: float) -> float:
        """Return the next time that a step must land on; drop those that have passed."""
        near = 1e-12 * (1.0 + abs(t))
        while self.breaking and self.breaking[0][0] <= t + near:
            self.note_breaking(*heapq.heappop(self.breaking))
        stops = [self.t_end]
        if self.breaking:
            stops.append(self.breaking[0][0])
        if self.pending:
            stops.append(self.pending[0][0])
        return min(stops)

    def arc(self, arc: Arc, t: float, y: Array, mode: str, fired: str | None,
            progress: Callable[[float], None] | None) -> tuple[float, Array, Segment | None]:  # fmt: skip
        """Integrate until an event ends the arc; return the time, the variables and the segment (None at the end)."""
        rhs = self.right_hand_side(mode)
        watched = [s for s in self.model.segments.values() if s.mode == mode and self.model.events[s.event].function is not None]
        level = {s.name: self.event_value(s, t, y) for s in watched}
        for s in watched:
            if s.event == fired and abs(level[s.name]) <= 1e-9 * self.event_scale(s, t, y):
                # On the surface just left: its side is where the flow goes, however short the flight may be.
                level[s.name] = math.copysign(TINY, self.event_slope(s, t, y, rhs))
        previous_step = None
        while True:
            segment = self.due(t, mode)
            if segment is not None or t >= self.t_end:
                return t, y, segment
            stop = self.next_stop(t)
            self.delays.begin(t)
            try:
                solver = scipy.integrate.DOP853(rhs, t, y, stop, rtol=self.tolerances.rtol, atol=self.tolerances.atol,
                                                max_step=self.delays.max_step,
                                                first_step=None if previous_step is None else min(previous_step, stop - t))  # fmt: skip
                while solver.status == "running":
                    message = solver.step()
                    if solver.status == "failed":
                        raise ConvergenceError(f"integration failed at t = {solver.t:.10g} in mode '{mode}': {message}")
                    if not np.all(np.isfinite(solver.y)):
                        raise ConvergenceError(f"the solution is no longer finite near t = {solver.t_old:.10g} in mode '{mode}'; "
                                               "it grows without bound there")  # fmt: skip
                    dense = solver.dense_output()
                    hit = self.first_event(watched, level, solver.t_old, solver.t, dense)
                    end = solver.t if hit is None else hit[0]
                    step = Step(solver.t_old, solver.t, dense.y_old[: self.n], dense.F[:, : self.n], end)
                    self.trajectory.n_steps += 1
                    arc.steps.append(step)
                    self.delays.record(step)
                    if hit is not None:
                        return end, dense(end), hit[1]
                    previous_step = solver.step_size
                    if progress:
                        progress(solver.t)
                t, y = solver.t, solver.y
            except (ValueError, OverflowError, ZeroDivisionError) as exc:
                raise ConvergenceError(f"the vector field of mode '{mode}' cannot be evaluated near t = {t:.10g}: {exc}; "
                                       "check its logarithms, roots, divisions and exponentials there") from exc  # fmt: skip

    def due(self, t: float, mode: str) -> Segment | None:
        """Return the segment that a delayed event ends now, if its time has come and the mode has such a segment."""
        while self.pending and self.pending[0][0] <= t + 1e-12 * (1.0 + abs(t)):
            _, name = heapq.heappop(self.pending)
            for segment in self.model.segments.values():
                if segment.mode == mode and segment.event == name:
                    return segment
        return None

    def right_hand_side(self, mode: str) -> Callable[[float, Array], Array]:
        scalar, n, delays, p = self.numeric.mode(mode).scalar, self.n, self.delays, self.plain_p

        def rhs(t: float, y: Array) -> Array:
            out = [0.0] * n
            scalar(t, y[:n].tolist(), delays.values(t, y), p, out)
            return np.concatenate([out, delays.slopes(y)])

        return rhs

    def event_value(self, segment: Segment, t: float, y: Array) -> float:
        out = [0.0]
        self.numeric.event(segment.event).scalar(t, y[: self.n].tolist(), self.delays.values(t, y), self.plain_p, out)
        return out[0]

    def event_slope(self, segment: Segment, t: float, y: Array, rhs: Callable[[float, Array], Array]) -> float:
        """Return dh/dt along the flow; delayed values are held at their slope over a short step."""
        d = self.numeric.event(segment.event).derivatives(
            np.array([t]), y[: self.n, None], np.array(self.delays.values(t, y))[:, None], self.p)  # fmt: skip
        f = rhs(t, y)
        slope = float(d.dt[0, 0] + d.dx[0, :, 0] @ f[: self.n])
        if np.any(d.dxd):
            ahead = 1e-7 * (1.0 + abs(t))
            later = np.array(self.delays.values(t + ahead, y + ahead * f)) - np.array(self.delays.values(t, y))
            slope += float(d.dxd[0, :, 0] @ later) / ahead
        return slope

    def event_scale(self, segment: Segment, t: float, y: Array) -> float:
        d = self.numeric.event(segment.event).derivatives(
            np.array([t]), y[: self.n, None], np.array(self.delays.values(t, y))[:, None], self.p)
        in_time = abs(float(d.dt[0, 0])) * (1.0 + abs(t))
        return float(np.sum(np.abs(d.dx[0, :, 0] * y[: self.n]))) + float(np.max(np.abs(d.dx), initial=0.0)) + in_time + 1e-300

    def first_event(self, watched: list[Segment], level: dict[str, float], t0: float, t1: float,
                    dense: Callable[[float], Array]) -> tuple[float, Segment] | None:  # fmt: skip
        """Return the earliest watched event in a step; ``level`` carries the event functions' values along."""
        times = np.linspace(t0, t1, SAMPLES)
        hits: list[tuple[float, int, Segment]] = []
        for i, segment in enumerate(watched):
            before = level[segment.name]
            for ta, tb in pairwise(times):
                after = self.event_value(segment, tb, dense(tb))
                rises, falls = before < 0.0 <= after, before > 0.0 >= after
                if (rises and segment.direction != "falling") or (falls and segment.direction != "rising"):
                    at = self.root(segment, ta, tb, before, dense)
                    hits.append((at, i, segment))
                    break
                before = after
            level[segment.name] = before
        if not hits:
            return None
        time, _, segment = min(hits, key=lambda hit: hit[:2])
        return time, segment

    def root(self, segment: Segment, ta: float, tb: float, before: float, dense: Callable[[float], Array]) -> float:
        """Return the zero of an event function in a step; ``before`` gives its side at ``ta``, where it may itself be zero."""

        def value(t: float) -> float:
            return self.event_value(segment, t, dense(t))

        if value(tb) == 0.0:
            return tb
        # Just after an event the function is zero at ta to rounding: look for a moment at which it is on its side.
        for k in range(61):
            left = ta + (tb - ta) * 2.0**-k if k else ta
            if np.sign(value(left)) == np.sign(before):
                ta = left
                break
        else:
            return ta
        return float(scipy.optimize.brentq(value, ta, tb, xtol=1e-15 * (1.0 + abs(tb)), rtol=8.9e-16))
