"""Delay equations with events by scipy's DOP853 and the method of steps: independent of the package.

Steps end at breaking points (events, and sums of delays after them), so that whatever a step reads of the past lies in
one smooth piece of it. Events are sign changes of their functions along the dense output of a step, located by
``brentq``; a function that jumps over zero because a delayed value jumps is an event as well, a reset that carries the
state over a surface is none. Delayed events happen by clocks that every occurrence of their source starts.
"""

from __future__ import annotations

import bisect
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import combinations_with_replacement
from math import comb
from typing import NamedTuple

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq, minimize_scalar

RTOL, ATOL = 1e-11, 1e-13
# Two times closer than this are one; an event function below ON_SURFACE just after its own event is on its surface.
SAME_TIME, ON_SURFACE = 1e-11, 1e-9
# Places in a step at which event functions are looked at, and an extremum that is so near to zero, in units of how much
# the function changes on either side, is looked at more closely.
SAMPLES, NEAR = np.linspace(0.0, 1.0, 17), 1.0
# Just after an event the side is that of the function so little later, in parts of a step.
JUST_AFTER = 1e-5
FIRST_STEP = 0.02
# DOP853's dense output is x (F_0 + (1 - x) (F_1 + x (F_2 + ..))): the coefficients of x, x^2, .. of each F's factor.
FACTORS = np.zeros((7, 7))
for _k in range(7):
    _ups, _downs = _k // 2 + 1, (_k + 1) // 2
    for _j in range(_downs + 1):
        FACTORS[_k, _ups + _j - 1] = (-1) ** _j * comb(_downs, _j)


class MotionError(Exception):
    """The motion does not go on: it slides, or events accumulate."""


class Exit(NamedTuple):
    """What ends a mode: ``function(t, z, past)`` crossing zero in a direction, or a delayed event (no function)."""

    function: Callable | None
    direction: int
    reset: Callable
    to: object
    name: str
    event: str = ""

    @property
    def what(self):
        """The event; exits with one event share a surface."""
        return self.event or self.name


def same(t, z, past):
    """Return the state unchanged: the reset of most events."""
    return z


class Piece:
    """A step's dense output as a polynomial in powers of the part of the step that is over.

    Sums of powers lose no digits that matter: the factors' coefficients are at most 6. It is evaluated by numbers, ten
    times as fast as by scipy's arrays of two or three.
    """

    def __init__(self, dense):
        self.first, self.length = dense.t_old, dense.h
        rows = np.vstack([dense.y_old, FACTORS.T @ dense.F])
        self.coefficients = rows[::-1].T.tolist()

    def __call__(self, t):
        """Return the state (n_states,) at a time."""
        x = (t - self.first) / self.length
        result = []
        for c7, c6, c5, c4, c3, c2, c1, c0 in self.coefficients:
            result.append(((((((c7 * x + c6) * x + c5) * x + c4) * x + c3) * x + c2) * x + c1) * x + c0)
        return np.array(result)


@dataclass
class Motion:
    """A motion from ``history(t, side)``; ``fields[mode](t, z, past)`` with ``past(delay)``, the state that long ago.

    ``exits[mode]`` lists :class:`Exit` (or tuples in its order). ``clocks[event]`` lists (delayed event, delay) that
    every occurrence of the event starts; ``pending`` those under way as (time, delayed event). ``breaks`` are breaking
    points of the past that still lie ahead. Breaking points are followed up to ``echoes`` delays after an event.
    ``history`` may have two arguments: the time, and +1 or -1 for the side of a jump on which it is read.
    """

    fields: dict
    exits: dict
    delays: tuple
    history: Callable
    mode: object
    echoes: int = 3
    at: float = 0.0
    clocks: dict = field(default_factory=dict)
    pending: list = field(default_factory=list)
    breaks: list = field(default_factory=list)
    start: np.ndarray | None = None
    max_events: int = 100_000
    # Tolerances of the integration, in the usual ones.
    accuracy: float = 1.0
    edges: list = field(default_factory=list)
    pieces: list = field(default_factory=list)
    events: list = field(default_factory=list)
    afters: list = field(default_factory=list)

    def __post_init__(self):
        two_sided = self.history.__code__.co_argcount > 1 if hasattr(self.history, "__code__") else True
        self._history = self.history if two_sided else lambda t, side: self.history(t)
        self.exits = {mode: [Exit(*e) for e in exits] for mode, exits in self.exits.items()}
        self.delays = tuple(d for d in self.delays if d > 0)
        self.first = self.at
        sums = {sum(c) for n in range(1, self.echoes + 1) for c in combinations_with_replacement(self.delays, n)}
        self._echoes = sorted(sums)
        self.z = np.array(self._history(self.at, 1) if self.start is None else self.start, dtype=float)
        self._break_at(self.at)
        self._sides, self._step = {}, FIRST_STEP

    def __call__(self, t, side=1):
        """Return the state at a time; at an edge between two pieces on the given side of it."""
        nearly = t + side * 1e-10
        if nearly < self.first:
            return np.asarray(self._history(t, side))
        return self.pieces[bisect.bisect_right(self.edges, nearly) - 1](t)

    def run(self, t_end, n_events=None):
        """Integrate up to ``t_end``, or until so many events have happened; return this motion."""
        while self.at < t_end - SAME_TIME and (n_events is None or len(self.events) < n_events):
            while self.breaks and self.breaks[0] <= self.at + SAME_TIME:
                self.breaks.pop(0)
            self._do_delayed_events()
            stop = min([t_end, *self.breaks[:1], *(t for t, _ in self.pending[:1] if t > self.at + SAME_TIME)])
            self._arc(stop)
        self._do_delayed_events()
        return self

    def times(self, name):
        """Return the times of an event."""
        return np.array([t for n, t, _ in self.events if n == name])

    def highest(self, state, first, last):
        """Return a state's maximum between two times, refined from samples by a parabola on each."""
        t = np.linspace(first, last, 4001)
        values = np.array([self(s)[state] for s in t])
        i = int(np.argmax(values))
        t = np.linspace(t[max(i - 1, 0)], t[min(i + 1, 4000)], 2001)
        return max(self(s)[state] for s in t)

    def _break_at(self, t):
        for echo in self._echoes:
            place = bisect.bisect_left(self.breaks, t + echo)
            near = self.breaks[max(place - 1, 0) : place + 1]
            if all(abs(t + echo - other) > SAME_TIME for other in near):
                self.breaks.insert(place, t + echo)

    def _past(self, t, side):
        def past(delay):
            return self(t - delay, side)

        return past

    def _arc(self, stop):
        """Integrate to ``stop`` in steps, or to the first event before it."""
        field_, middle = self.fields[self.mode], 0.5 * (self.at + stop)

        def flow(t, z):
            return field_(t, z, self._past(t, 1 if t < middle else -1))

        longest = min(self.delays, default=np.inf)
        # The step before is tried first: what scipy would choose is nothing where the state is zero to rounding.
        first = min(self._step, longest, stop - self.at)
        solver = DOP853(
            flow,
            self.at,
            self.z,
            stop,
            rtol=self.accuracy * RTOL,
            atol=self.accuracy * ATOL,
            max_step=longest,
            first_step=first,
        )
        while solver.status == "running":
            if message := solver.step():
                raise MotionError(message)
            dense = Piece(solver.dense_output())
            if solver.t < stop:
                self._step = solver.step_size
            self.edges.append(solver.t_old)
            self.pieces.append(dense)
            found = self._first_event(dense, solver.t_old, solver.t)
            if found is not None:
                self.at, exit_ = found
                self.z = dense(self.at)
                self._happen(exit_)
                return
            self.at, self.z = solver.t, solver.y
        self.at = stop

    def _first_event(self, dense, a, b):
        """Return (time, exit) of the first crossing in a step, None if there is none."""
        first = None
        for exit_ in self.exits.get(self.mode, ()):
            if exit_.function is None:
                continue
            t = self._first_crossing(exit_, dense, a, b if first is None else first[0])
            if t is not None and (first is None or t < first[0]):
                first = t, exit_
        if first is None:
            for exit_ in self.exits.get(self.mode, ()):
                if exit_.function is not None:
                    self._keep_side(exit_, dense, a, b)
        return first

    def _function(self, exit_, dense, a, b):
        middle = 0.5 * (a + b)
        return lambda t: float(exit_.function(t, dense(t), self._past(t, 1 if t < middle else -1)))

    def _keep_side(self, exit_, dense, a, b):
        value = self._function(exit_, dense, a, b)(b)
        if value != 0.0:
            self._sides[exit_] = np.sign(value)

    def _first_crossing(self, exit_, dense, a, b):
        h = self._function(exit_, dense, a, b)
        t = a + SAMPLES * (b - a)
        values = np.array([h(s) for s in t])
        side = self._sides.get(exit_)
        if side is None:
            # The arc begins here: its side is where it is, or where it goes to from the surface.
            if abs(values[0]) > ON_SURFACE:
                side = np.sign(values[0])
            else:
                t[0] = a + JUST_AFTER * (b - a)
                values[0] = h(t[0])
                side = np.sign(values[0])
            self._sides[exit_] = side
        elif values[0] * side < 0 and abs(values[0]) > ON_SURFACE and exit_.direction * side <= 0:
            return a
        for j in range(1, len(t)):
            if values[j] * values[j - 1] <= 0 and values[j] != 0 and values[j - 1] != 0:
                if exit_.direction * values[j] >= 0:
                    return brentq(h, t[j - 1], t[j], xtol=1e-14, rtol=1e-15)
            elif j < len(t) - 1 and exit_.direction * values[j] <= 0:
                found = self._dip(h, exit_, t[j - 1 : j + 2], values[j - 1 : j + 2])
                if found is not None:
                    return found
        return None

    @staticmethod
    def _dip(h, exit_, t, values):
        """Return where a function crosses zero and returns between three samples that do not show it."""
        sign = np.sign(values[1])
        left, middle, right = sign * values
        if sign == 0 or not (left > middle < right) or middle > NEAR * max(left - middle, right - middle):
            return None
        lowest = minimize_scalar(lambda s: sign * h(s), bounds=(t[0], t[2]), method="bounded", options={"xatol": 1e-12})
        if lowest.fun >= 0:
            return None
        return brentq(h, t[0], lowest.x, xtol=1e-14, rtol=1e-15)

    def _do_delayed_events(self):
        """Let all delayed events happen that are due; those that the mode does not list are lost."""
        while self.pending and self.pending[0][0] <= self.at + SAME_TIME:
            _, event = self.pending.pop(0)
            for exit_ in self.exits.get(self.mode, ()):
                if exit_.function is None and exit_.what == event:
                    self._happen(exit_)
                    break

    def _happen(self, exit_):
        past = self._past(self.at, -1)
        self.events.append((exit_.name, self.at, self.z.copy()))
        came_from = self.fields[self.mode]
        before = None if exit_.function is None else self._slope(exit_, came_from, self.z, -1)
        self.z = np.array(exit_.reset(self.at, self.z, past), dtype=float)
        self.mode = exit_.to
        self.afters.append(self.z.copy())
        if len(self.events) > self.max_events:
            raise MotionError(f"more than {self.max_events} events by t = {self.at}")
        self._sides = {}
        self._break_at(self.at)
        for event, delay in self.clocks.get(exit_.what, ()):
            bisect.insort(self.pending, (self.at + delay, event))
        if before is not None:
            # The direction listed says more than a slope: a step aside may reach over a jump of what it reads.
            self._refuse_sliding(exit_, exit_.direction or np.sign(before))

    def _slope(self, exit_, flow, z, side):
        """Return the rate of an event function along a flow at this moment, by a small step with it."""
        rate = np.asarray(flow(self.at, z, self._past(self.at, side)))
        step = 1e-7 * side
        later = exit_.function(self.at + step, z + step * rate, self._past(self.at + step, side))
        return (later - exit_.function(self.at, z, self._past(self.at, side))) / step

    def _refuse_sliding(self, exit_, crossed):
        """Raise MotionError if the next mode's flow leads back over the surface, where it would be left at once."""
        for other in self.exits.get(self.mode, ()):
            if other.function is None or other.what != exit_.what or other.direction * crossed > 0:
                continue
            if abs(other.function(self.at, self.z, self._past(self.at, 1))) > ON_SURFACE:
                continue
            if self._slope(other, self.fields[self.mode], self.z, 1) * crossed < 0:
                raise MotionError(f"slides on '{exit_.what}' at t = {self.at}: both fields point at the surface")


def settled_period(motion, name):
    """Return the time between the last two events of a name; the two before are as far apart."""
    before, middle, last = motion.times(name)[-3:]
    assert abs((last - middle) - (middle - before)) <= 1e-8
    return last - middle
