"""Recorded orbits of models with delays of every kind, judged without the program.

Smooth ones by Fourier collocation. Those with events by their own past: an orbit u is a motion just if the ordinary
differential equation z' = f(t, z, u in the past) from z = u at the start is u again, with the same events: nothing of
how motions are computed is needed but u's polynomials, as they are recorded.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp

from tests.fourier import find_fourier_orbit

FUNCTIONS = {"cos": np.cos, "sin": np.sin, "tanh": np.tanh, "exp": np.exp, "pi": np.pi}
NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)
FINE_NODES, FINE_WEIGHTS = np.polynomial.legendre.leggauss(40)
# Coefficients of Fourier series that are so small, in sizes of the states, are none.
RESOLVED = 1e-9
HARMONICS = (24, 48, 96, 192)
AT_EDGE = 1e-10
# Of an ordinary differential equation, and places in each interval of the mesh where states and events are looked at.
RTOL, ATOL, PLACES = 1e-11, 1e-13, np.linspace(0, 1, 7)
# An event function that small just after its own event says nothing of its side.
ON_SURFACE = 1e-6


@dataclass(frozen=True)
class Verdict:
    """The largest distance from the motion in sizes of the states, and what is wrong besides (empty: nothing)."""

    deviation: float
    fault: str = ""


def compile_field(formulas, parameters):
    """Return the function (t, z, read, integrate, remember) -> array of the formulas' values at parameter values."""
    body = ", ".join(f.python for f in formulas)
    return eval(f"lambda t, z, read, integrate, remember: [{body}]", {**FUNCTIONS, **parameters})


def check_smooth(model, orbit):
    """Return how far an orbit without events is from the one that Fourier collocation finds from it."""
    flow = model.modes[orbit.names[0].strip("()")]
    field = compile_field([flow[x] for x in model.states], orbit.parameters)
    n_states, past = len(model.states), Past(orbit)

    def flow_at(t, x, read):
        def late(lag, order=0):
            return read(t - lag, order)

        def integrate(g, low, high):
            low, high = (np.broadcast_to(limit, t.shape)[:, None] for limit in (low, high))
            lags = 0.5 * (low + high) + 0.5 * (high - low) * FINE_NODES
            return (0.5 * (high - low) * g(lags, read(t[:, None] - lags))) @ FINE_WEIGHTS

        def remember(g, rate, low):
            # Of a periodic function: one period, each time with the weights of all the periods before.
            lags = 0.5 * orbit.period * (FINE_NODES + 1)
            kernel = 0.5 * orbit.period * rate * np.exp(-rate * lags) / -np.expm1(-rate * orbit.period)
            return g(read(t[:, None] - low - lags)) @ (FINE_WEIGHTS * kernel)

        return np.array(field(t, x, late, integrate, remember))

    autonomous, found = model.period is None, None
    begin = 0.0
    if autonomous:
        # The series begins where its first state is largest.
        t = orbit.start + np.linspace(0, orbit.period, 4001)
        begin = t[int(np.argmax(past(t)[0]))]
    for n in HARMONICS:
        found = find_fourier_orbit(
            flow_at, found or (lambda t: past(t + begin)[:n_states]), orbit.period, n, free_period=autonomous, steps=8
        )
        if np.max(np.abs(found.coefficients[:, 0]) / orbit.sizes[:n_states]) < RESOLVED:
            break
    else:
        return Verdict(np.inf, "Fourier collocation is not resolved")
    if found.residual > 1e-9:
        return Verdict(np.inf, "Fourier collocation does not converge")
    return Verdict(_measure_distance(found, past, orbit, n_states, begin, autonomous))


def _measure_distance(found, past, orbit, n_states, begin, autonomous):
    times = orbit.period * np.arange(200) / 200
    shift = 0.0
    for _ in range(6 if autonomous else 0):
        rate = found(times + shift, 1)[0]
        shift += float(rate @ (past(times + begin)[0] - found(times + shift)[0]) / (rate @ rate))
    off = np.abs(past(times + begin)[:n_states] - found(times + shift)) / orbit.sizes[:n_states, None]
    return max(float(np.max(off)), abs(found.period - orbit.period) / orbit.period)


class Past:
    """A recorded orbit at any times, as many at once as there are: values or rates (n_states, *shape)."""

    def __init__(self, orbit):
        self.orbit = orbit
        self.edges, self.halves = np.array(orbit.edges), np.array([0.5 * (n[-1] - n[0]) for n in orbit.nodes])
        series = []
        for nodes, values, half in zip(orbit.nodes, orbit.values, self.halves, strict=True):
            places = (nodes - nodes[0]) / half - 1
            series.append(np.linalg.solve(np.vander(places, increasing=True), values))
        self.series = np.array(series)

    def __call__(self, t, order=0, side=1):
        t, period = np.asarray(t, dtype=float), self.orbit.period
        nudge = side * AT_EDGE * period
        local = t - np.floor((t - self.orbit.start + nudge) / period) * period
        i = np.maximum(np.searchsorted(self.edges, local + nudge, side="right") - 1, 0)
        place, result = (local - self.edges[i]) / self.halves[i] - 1, 0.0
        for power in reversed(range(order, self.series.shape[1])):
            factor = np.prod(np.arange(power - order + 1, power + 1))
            result = result * place[..., None] + factor * self.series[i, power]
        return np.moveaxis(result / self.halves[i][..., None] ** order, -1, 0)

    def list_edges(self, low, high):
        """Return the edges of pieces between two times."""
        first, last = np.floor((np.array([low, high]) - self.orbit.start) / self.orbit.period)
        turns = np.arange(first, last + 1)
        edges = (self.edges + self.orbit.period * turns[:, None]).ravel()
        return edges[(edges > low) & (edges < high)]


class Flow:
    """Formulas of a model along its orbit's own past."""

    def __init__(self, formulas, past):
        self.field, self.past = compile_field(formulas, past.orbit.parameters), past

    def __call__(self, t, z, side):
        def read(lag, order=0):
            return self.past(t - lag, order, side)

        return np.array(self.field(t, z, read, lambda g, low, high: self._integrate(g, t, low, high), None))

    def _integrate(self, g, t, low, high):
        cuts = np.array([t - high, *self.past.list_edges(t - high, t - low), t - low])
        middles, halves = 0.5 * (cuts[1:] + cuts[:-1]), 0.5 * np.diff(cuts)
        times = middles[:, None] + halves[:, None] * NODES
        return float(np.sum(halves[:, None] * WEIGHTS * g(t - times, self.past(times))))


def check_own_past(model, orbit):
    """Return how far an orbit with events is from what its own past makes of its start, in a period."""
    past, n_states = Past(orbit), len(model.states)
    flows = {m: Flow([flow[x] for x in model.states], past) for m, flow in model.modes.items()}
    events = {e: Flow([f], past) for e, f in model.events.items()}
    sizes, worst, z, begin = orbit.sizes[:n_states], 0.0, orbit.first_state()[:n_states], orbit.start
    for name, end in zip(orbit.names, orbit.ends, strict=True):
        mode = name[1:-1] if orbit.eventless else model.segments[name].mode
        t, states = _follow(flows[mode], z, begin, end, past)
        sides = np.where(np.arange(len(t)) % len(PLACES) == len(PLACES) - 1, -1, 1)
        known = np.array([past(s, side=side)[:n_states] for s, side in zip(t, sides, strict=True)])
        worst = max(worst, float(np.max(np.abs(states - known) / sizes)))
        fault, late = _check_events(model, mode, name, events, t, states, sides)
        if fault:
            return Verdict(worst, f"{fault} in '{name}'")
        worst, z = max(worst, late / orbit.period), states[-1]
        reset = None if orbit.eventless else model.segments[name].reset
        for state, formula in (model.resets[reset] if reset else {}).items():
            z[model.states.index(state)] = Flow([formula], past)(end, states[-1].copy(), -1)[0]
        after = past(end, side=1)[:n_states]
        worst, begin = max(worst, float(np.max(np.abs(z - after) / sizes))), end
    return Verdict(worst)


def _follow(flow, z, begin, end, past):
    """Return times and states at places of each interval of the mesh between two times."""
    cuts = [begin, *past.list_edges(begin + 1e-9, end - 1e-9), end]
    times, states = [], []
    for a, b in pairwise(cuts):
        middle = 0.5 * (a + b)
        t = a + PLACES * (b - a)
        found = solve_ivp(
            lambda s, y, middle=middle: flow(s, y, 1 if s < middle else -1),
            (a, b), z, method="DOP853", rtol=RTOL, atol=ATOL, t_eval=np.append(t[:-1], b), first_step=b - a,
        )  # fmt: skip
        z = found.y[:, -1].copy()
        times.append(t)
        states.append(found.y.T)
    return np.concatenate(times), np.concatenate(states)


def _check_events(model, mode, name, events, t, states, sides):
    """Return what is wrong with a segment's events, and by how much time its own comes early or late."""
    late = 0.0
    for segment, given in model.segments.items():
        if given.mode != mode:
            continue
        function, sign = events[given.event], {"rising": 1, "falling": -1}[given.direction]
        h = np.array([sign * function(s, x, side)[0] for s, x, side in zip(t, states, sides, strict=True)])
        if segment == name:
            rate = (h[-1] - h[-2]) / (t[-1] - t[-2])
            if rate <= 0:
                return "the event function does not cross zero", late
            late, h = abs(h[-1]) / rate, h[:-1]
        away = np.flatnonzero(np.abs(h) > ON_SURFACE)
        h = h[away[0] :] if len(away) else h[:0]
        if np.any((h[:-1] < -ON_SURFACE) & (h[1:] > ON_SURFACE)):
            return f"'{given.event}' happens before", late
    return "", late
