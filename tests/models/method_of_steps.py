"""Delay equations with events by scipy's integrator, piece by piece between breaking points: independent of the
package.
"""

from __future__ import annotations

import bisect
from dataclasses import dataclass, field

import numpy as np
from scipy.integrate import solve_ivp


@dataclass
class Motion:
    """A motion from ``history(t)``; ``fields[mode](t, z, past)`` with ``past(delay)``, the state that long ago.

    ``exits[mode]`` lists (event function(t, z, past), direction, reset(z), next mode, name).
    Pieces end at events and at their echoes up to ``echoes`` delays later.
    """

    fields: dict
    exits: dict
    delays: tuple
    history: object
    mode: str
    echoes: int = 3
    at: float = 0.0
    edges: list = field(default_factory=list)
    pieces: list = field(default_factory=list)
    events: list = field(default_factory=list)
    waiting: list = field(default_factory=list)

    def __call__(self, t, middle=None):
        """Return the state at a time; at an edge between two pieces in the one that lies on the side of ``middle``."""
        nearly = t if middle is None else t + 1e-10 * np.sign(middle - t)
        i = bisect.bisect_right(self.edges, nearly) - 1
        return self.history(t) if i < 0 else self.pieces[i](t)

    def run(self, t_end):
        """Integrate up to ``t_end``; return this motion."""
        z = np.array(self.history(0.0), dtype=float)
        self._break_at(0.0)
        while self.at < t_end - 1e-12:
            self.waiting = sorted(t for t in self.waiting if t > self.at + 1e-11)
            stop = min([t_end, self.at + 1.0, self.at + min(self.delays, default=1.0), *self.waiting[:1]])
            z = self._piece(z, stop)
        return self

    def _break_at(self, t):
        sums = {t}
        for _ in range(self.echoes):
            sums |= {s + d for s in sums for d in self.delays}
        self.waiting += sums

    def _piece(self, z, stop):
        middle = 0.5 * (self.at + stop)

        def past(t):
            return lambda delay: self(t - delay, middle - delay)

        watched = []
        for function, direction, *_ in self.exits.get(self.mode, ()):

            def event(t, z, function=function, direction=direction, start=self.at):
                found = function(t, z, past(t))
                # What has just happened does not happen again because of rounding, nor where it is exactly zero.
                return direction * max(abs(found), 1e-300) if t == start and abs(found) < 1e-9 else found

            event.terminal, event.direction = True, direction
            watched.append(event)
        part = solve_ivp(
            lambda t, z: self.fields[self.mode](t, z, past(t)),
            (self.at, stop),
            z,
            method="DOP853",
            rtol=1e-11,
            atol=1e-13,
            events=watched,
            dense_output=True,
        )
        self.edges.append(self.at)
        self.pieces.append(part.sol)
        self.at = part.t[-1]
        z = part.y[:, -1]
        happened = [i for i, t in enumerate(part.t_events or ()) if len(t)]
        if happened:
            _, _, reset, to, name = self.exits[self.mode][happened[0]]
            self.events.append((name, self.at, z.copy()))
            z, self.mode = np.array(reset(z), dtype=float), to
            self._break_at(self.at)
        return z

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


def same(z):
    """Return the state unchanged: the reset of most events."""
    return z
