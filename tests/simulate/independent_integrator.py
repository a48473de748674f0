"""An integrator for delay equations of every kind that shares nothing with the program: panels of Picard iterations.

On a panel [t, t + h] the motion is a Chebyshev series; x -> x(t) + int f is repeated on its nodes until nothing
changes. What is read of the panel itself is the iterate. Panels end where a lag passes from one smooth piece of the
past to the next, and where an event function crosses zero; both are found on the series by bisection.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.polynomial import chebyshev
from scipy.optimize import brentq

DEGREE, GAUSS = 18, 24
NODES = np.cos(np.pi * (np.arange(DEGREE + 1) + 0.5) / (DEGREE + 1))[::-1]
TO_SERIES = np.linalg.inv(chebyshev.chebvander(NODES, DEGREE))


class Motion:
    """Panels (begin, end, series, piece), oldest first; piece -1 is the history, a function of t and an order."""

    def __init__(self, history, states, t=0.0):
        self.history, self.panels, self.piece, self.t, self.start = history, [], 0, t, t
        self.states, self.ends, self.events = np.array(states, dtype=float), [t], []
        self.trial, self.reading = None, {}

    def evaluate(self, panel, t, order=0):
        begin, end, series, _ = panel
        half = 0.5 * (end - begin)
        s = (t - begin) / half - 1.0
        series = chebyshev.chebder(series, order, axis=0) if order else series
        return chebyshev.chebval(s, series) / half**order

    def __call__(self, t, order=0):
        """Return the states at ``t``, where no piece is asked for."""
        if t < self.start:
            return self.history(t, order)
        held = [p for p in self.panels if p[0] <= t] or self.panels[:1]
        return self.evaluate(held[-1], t, order)

    def read(self, lag, t, order=0):
        """Return the states at ``t`` in the piece that lag number ``lag`` reads, continued beyond its ends."""
        piece = self.reading.setdefault(lag, self.find_piece(t))
        if piece < 0:
            return self.history(t, order)
        if piece == self.piece and self.trial is not None and (t >= self.t or not self.holds(piece)):
            return self.evaluate(self.trial, t, order)
        held = [p for p in self.panels if p[3] == piece]
        if not held:
            return self.states if order == 0 else 0.0 * self.states
        inside = [p for p in held if p[0] <= t] or held[:1]
        return self.evaluate(inside[-1], t, order)

    def holds(self, piece):
        return any(p[3] == piece for p in self.panels)

    def find_piece(self, t):
        if t < self.start:
            return -1
        inside = [p[3] for p in self.panels if p[0] <= t < p[1]]
        return inside[0] if inside else self.piece

    def find_ends(self, piece):
        """Return where a piece begins and ends."""
        return (-np.inf if piece < 0 else self.ends[piece]), (self.ends[piece + 1] if piece < self.piece else np.inf)

    def integrate(self, g, t, low, high):
        """Return the integral of g(s, x(t - s)) over s from low to high."""
        nodes, weights = np.polynomial.legendre.leggauss(GAUSS)
        panels = [*self.panels, *([] if self.trial is None else [self.trial])]
        cuts = sorted({t - high, t - low, *(e for p in panels for e in p[:2] if t - high < e < t - low)})
        total = 0.0
        for a, b in pairwise(cuts):
            middle = 0.5 * (a + b)
            inside = [p for p in panels if p[0] <= middle <= p[1]]
            for node, weight in zip(nodes, weights, strict=True):
                u = middle + 0.5 * (b - a) * node
                x = self.evaluate(inside[0], u) if inside else (self.history(u, 0) if u < self.start else self.states)
                total += 0.5 * (b - a) * weight * g(t - u, x)
        return total


def _make_panel(motion, f, h):
    """Return the panel of length ``h`` from the present on; None where iterations do not converge."""
    times = motion.t + 0.5 * h * (NODES + 1.0)
    values = np.tile(motion.states, (DEGREE + 1, 1))
    series = TO_SERIES @ values
    for _ in range(100):
        motion.trial = (motion.t, motion.t + h, series, motion.piece)
        slopes = np.array([f(t, x, motion) for t, x in zip(times, values, strict=True)])
        whole = chebyshev.chebint(TO_SERIES @ slopes, axis=0)[: DEGREE + 1] * 0.5 * h
        whole[0] += motion.states - chebyshev.chebval(-1.0, whole)
        new = chebyshev.chebval(NODES, whole).T
        change = np.max(np.abs(new - values)) / (1.0 + np.max(np.abs(new)))
        values, series = new, whole
        if not np.isfinite(change):
            return None
        if change < 2e-15:
            return motion.t, motion.t + h, series, motion.piece
    return (motion.t, motion.t + h, series, motion.piece) if change < 1e-13 else None


def _find_end(motion, panel, read_times, event):
    """Return where the panel has to end, the lag that passes an end there and how, or the event (None)."""
    found = (panel[1], None, 0)
    grid = np.linspace(panel[0], panel[1], 41)

    def look(function, lag, way):
        nonlocal found
        values = [function(t) for t in grid]
        for a, b, left, right in zip(grid[:-1], grid[1:], values[:-1], values[1:], strict=True):
            if left < 0.0 <= right and a < found[0]:
                found = (brentq(function, a, b, xtol=1e-15, rtol=1e-15), lag, way)
                return

    motion.trial = panel
    for lag, read_time in read_times.items():

        def at(t, read_time=read_time):
            return read_time(t, motion.evaluate(panel, t), motion)

        low, high = motion.find_ends(
            motion.reading.get(lag, motion.find_piece(read_time(motion.t, motion.states, motion)))
        )
        if np.isfinite(high):
            look(lambda t, at=at, high=high: at(t) - high, lag, 1)
        if np.isfinite(low):
            look(lambda t, at=at, low=low: low - at(t), lag, -1)
    if event is not None:
        look(lambda t: event(t, motion.evaluate(panel, t), motion), "event", 1)
    return found


def integrate(f, read_times, history, states, t_end, h, event=None, reset=None, breaks=()):
    """Return the motion of x' = f(t, x, motion) up to ``t_end``, by panels no longer than ``h``.

    ``f`` reads the past by ``motion.read(lag, t, order)``; ``read_times`` are functions of (t, x, motion) by lag. An
    ``event`` function that rises through zero resets the states; ``breaks`` are further times at which panels end.
    """
    motion = Motion(history, states)
    # Panels that are too long diverge, and are halved.
    with np.errstate(all="ignore"):
        _fill(motion, f, read_times, t_end, h, event, reset, breaks)
    return motion


def _fill(motion, f, read_times, t_end, h, event, reset, breaks):
    while motion.t < t_end - 1e-14:
        length = min([h, t_end - motion.t, *(b - motion.t for b in breaks if b > motion.t + 1e-13)])
        motion.trial = None
        panel, end, what, way = _advance(motion, f, length, read_times, event)
        motion.panels.append((panel[0], panel[1], panel[2], motion.piece))
        motion.states, motion.trial = motion.evaluate(panel, end), None
        # A panel is kept whole as a series and ends where the next one begins.
        motion.panels[-1] = _cut(motion, panel, end)
        motion.t = end
        if what is not None or end in breaks:
            motion.piece += 1
            motion.ends.append(end)
        if what == "event":
            motion.events.append(end)
            motion.states = np.array(reset(end, motion.states, motion), dtype=float)
            motion.reading = {}
        elif what is not None:
            motion.reading[what] += way


def _advance(motion, f, length, read_times, event):
    """Return a panel of at most a length, where it ends, and what ends it; it goes on beyond that by little."""
    for _ in range(60):
        panel = _make_panel(motion, f, length)
        if panel is None:
            length *= 0.5
        elif not _mend_pieces(motion, panel, read_times):
            end, what, way = _find_end(motion, panel, read_times, event)
            if what is None or end - motion.t > 0.9 * length or length < 1e-9:
                return panel, end, what, way
            # A series is not continued far beyond what it was made of.
            length = 1.02 * (end - motion.t)
    raise RuntimeError(f"no panel at t = {motion.t}")


def _cut(motion, panel, end):
    """Return the part of a panel up to ``end`` as a series of its own."""
    times = panel[0] + 0.5 * (end - panel[0]) * (NODES + 1.0)
    return panel[0], end, TO_SERIES @ np.array([motion.evaluate(panel, t) for t in times]), motion.piece


def _mend_pieces(motion, panel, read_times):
    """Let lags that begin the panel at the end of what they read go the way they move; return whether any did."""
    motion.trial, mended = panel, False
    soon = panel[0] + 1e-3 * (panel[1] - panel[0])
    for lag, read_time in read_times.items():
        there, later = read_time(panel[0], motion.states, motion), read_time(soon, motion.evaluate(panel, soon), motion)
        low, high = motion.find_ends(motion.reading.setdefault(lag, motion.find_piece(there)))
        way = (
            1
            if later > high + 1e-13 and there >= high - 1e-12
            else -1
            if later < low - 1e-13 and there <= low + 1e-12
            else 0
        )
        motion.reading[lag] += way
        mended = mended or way != 0
    return mended
