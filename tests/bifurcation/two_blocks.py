"""Two coupled blocks on one moving belt, each with its own friction, simulated apart from the program.

x'' = cos(om t) + G cos(5 om t) - x - 0.2 x' - 0.3 (x - y) - 0.4 sign(x' - vb) and
y'' = 0.8 cos(om t + 1) - y - 0.2 y' - 0.3 (y - x) - 0.6 sign(y' - vb). Pieces are integrated by scipy's DOP853; their
ends are zeros of the speeds on the belt and of what friction can do more, which are also looked for between extrema
inside of steps.
"""

import math

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq, minimize_scalar

DAMPING, SPRING, FRICTION, PLACES = 0.2, 0.3, (0.4, 0.6), np.linspace(0.0, 1.0, 9)
# What is smaller where a piece begins may be rounding of a zero.
FRESH = 1e-13
NAMES = ("one", "two")


class Blocks:
    """Both blocks at given parameters."""

    def __init__(self, om, vb, G):
        self.om, self.vb, self.G = om, vb, G

    def pull(self, i, t, z):
        """Return all forces on block ``i`` but friction; ``t`` and the rows of ``z`` may be arrays."""
        force = 0.8 * np.cos(self.om * t + 1.0) if i else np.cos(self.om * t) + self.G * np.cos(5.0 * self.om * t)
        own, other = z[2 * i], z[2 - 2 * i]
        return force - own - DAMPING * z[2 * i + 1] - SPRING * (own - other)

    def field(self, t, z, sides):
        """Return the slopes; ``sides`` are -1, 1, or 0 for a block that sticks."""
        found = []
        for i in (0, 1):
            found += [self.vb, 0.0] if sides[i] == 0 else [z[2 * i + 1], self.pull(i, t, z) - FRICTION[i] * sides[i]]
        return found

    def list_ends(self, sides):
        """Return what may end a piece: (block, kind, function that falls through zero there)."""
        ends = []
        for i, side in enumerate(sides):
            if side != 0:
                ends.append((i, "down" if side > 0 else "up", lambda t, z, i=i, s=side: s * (z[2 * i + 1] - self.vb)))
            else:
                for s, kind in ((1, "off_up"), (-1, "off_down")):
                    ends.append((i, kind, lambda t, z, i=i, s=s: FRICTION[i] - s * self.pull(i, t, z)))
        return ends

    def follow(self, n_periods):
        """Return the events of the last period, (block, kind, whether it sticks), in order."""
        t, z, sides, end = 0.0, np.zeros(4), (-1, -1), 2.0 * math.pi / self.om * n_periods
        events = []
        while t < end:
            t, z, happened = self._piece(t, z, sides, end)
            for i, kind in happened:
                sides, sticks = self._enter(i, kind, t, z, sides)
                if sides[i] == 0:
                    z[2 * i + 1] = self.vb
                events.append((t, NAMES[i], kind, sticks))
        return [e[1:] for e in events if e[0] > end - 2.0 * math.pi / self.om]

    def _enter(self, i, kind, t, z, sides):
        if kind in ("off_up", "off_down"):
            side = 1 if kind == "off_up" else -1
        else:
            way = 1 if kind == "up" else -1
            side = way if self.pull(i, t, z) * way > FRICTION[i] else 0
        return (side, sides[1]) if i == 0 else (sides[0], side), side == 0

    def _piece(self, t, z, sides, end):
        """Integrate up to the first end; return its time, the states, and what ends there."""
        solver = DOP853(lambda s, y: self.field(s, y, sides), t, z, end, rtol=1e-12, atol=1e-14, max_step=0.2)
        ends, last = self.list_ends(sides), None
        while solver.status == "running":
            solver.step()
            dense = solver.dense_output()
            times = solver.t_old + (solver.t - solver.t_old) * PLACES
            if last is not None:
                # With the end of the step before: what is least where two steps meet is least inside of neither.
                dense, times = _join(last, dense, solver.t_old), np.append(last[1][-2], times)
            last = solver.dense_output(), times
            values = np.array([dense(s) for s in times]).T
            found = []
            for i, kind, function in ends:
                zero = _find_zero(_along(function, dense), times, function(times, values), t)
                found += [] if zero is None else [(zero, i, kind)]
            if found:
                first = min(found)[0]
                return first, dense(first), [(i, kind) for zero, i, kind in found if zero == first]
        return end, solver.y, []


def _join(last, dense, t):
    """Return the states along a step and the one before it; the steps meet at ``t``."""
    return lambda s: last[0](s) if s < t else dense(s)


def _along(function, dense):
    return lambda s: float(function(s, dense(s)))


def _find_zero(function, times, values, began):
    """Return the first time at which a function falls through zero; it begins positive, or on its zero at ``began``."""
    for j in range(len(times) - 1):
        a, b = times[j], times[j + 1]
        if values[j + 1] < 0.0 and values[j] > FRESH:
            return brentq(function, a, b, xtol=1e-15)
        if values[j + 1] < 0.0 and a == began:
            # It has just left the surface, and comes back.
            top = minimize_scalar(lambda s: -function(s), bounds=(a, b), method="bounded", options={"xatol": 1e-12})
            return brentq(function, top.x, b, xtol=1e-15) if top.fun < 0.0 else a
        if j > 0 and values[j] <= values[j - 1] and values[j] <= values[j + 1]:
            low = minimize_scalar(function, bounds=(times[j - 1], b), method="bounded", options={"xatol": 1e-12})
            if low.fun < 0.0:
                return brentq(function, times[j - 1], low.x, xtol=1e-15)
    return None
