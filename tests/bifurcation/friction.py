"""A block on a moving belt, x'' + 0.2 x' + x = force(t) - mu sign(x' - vb), simulated apart from the program.

Pieces are integrated by DOP853 at tolerance 1e-12 up to the zeros of x' - vb; while the block sticks x grows as vb t.
"""

import itertools
import math

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

DAMPING = 0.2


class Block:
    """The block at given parameters; ``terms`` are the amplitudes of cos(k om t) by k."""

    def __init__(self, om, terms, vb, mu, damping=DAMPING):
        self.om, self.terms, self.vb, self.mu, self.damping = om, terms, vb, mu, damping

    def force(self, t):
        return sum(a * math.cos(k * self.om * t) for k, a in self.terms.items())

    def needed(self, t, x):
        """Return the friction that a sticking block needs."""
        return self.force(t) - x - self.damping * self.vb

    def slip(self, t, x, v, side, end):
        """Return the time and states where v comes to vb, or those at ``end``."""

        def field(t, y):
            return [y[1], self.force(t) - y[0] - self.damping * y[1] - self.mu * side]

        def meet(t, y):
            return y[1] - self.vb if t > start + 1e-7 else side * 1.0

        start = t
        meet.terminal, meet.direction = True, -side
        found = solve_ivp(field, (t, end), [x, v], method="DOP853", events=meet, rtol=1e-12, atol=1e-13, max_step=0.3)
        return found.t[-1], *found.y[:, -1], found.status == 1

    def stick(self, t, x, end):
        """Return the time until which the needed friction stays within mu, the side to which it leaves, and x there."""

        def rest(s):
            return self.mu - abs(self.needed(s, x + self.vb * (s - t)))

        times = np.linspace(t, end, max(2, int((end - t) / 0.005)))
        for a, b in itertools.pairwise(times):
            if rest(b) < 0.0:
                out = brentq(rest, a, b, xtol=1e-15) if rest(a) > 0.0 else a
                return out, x + self.vb * (out - t), (1 if self.needed(b, x + self.vb * (b - t)) > 0.0 else -1)
        return end, x + self.vb * (end - t), 0

    def follow(self, n_periods, kept=1):
        """Return the events (kind, time, x) of the last ``kept`` periods: up or down through v = vb, stick, leave."""
        period = 2.0 * math.pi / self.om
        t, x, v, side, end = 0.0, 0.0, 0.0, -1, n_periods * period
        events = []
        while t < end:
            t, x, v, met = self.slip(t, x, v, side, end)
            if not met:
                break
            v = self.vb
            events.append(("up" if side < 0 else "down", t, x))
            if self.needed(t, x) * -side > self.mu:
                side = -side
                continue
            events.append(("stick", t, x))
            t, x, side = self.stick(t, x, end)
            events.append(("leave", t, x))
        return [e for e in events if e[1] >= end - kept * period]
