"""The first event in a step: zeros of functions along a dense output, none of which may only just be reached."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from tests.random_equations.sides import UnsureError

# A number that comes this near to zero without passing it grazes; what was zero at an event is looked at so much later.
GRAZING, LATER = 1e-6, 1e-5
SAMPLES = np.linspace(0.0, 1.0, 13)


def find_first(functions, dense, step, began, fresh, fixed):
    """Return the first event in a step between two times, as (time, what); None if there is none.

    ``functions`` are (what, function of states and time, direction). The arc ``began`` with the labels and jumps
    ``fresh`` on their zeros; ``fixed`` ones may pass theirs just there.
    """
    first, last = step
    found = []
    for what, function, direction in functions:
        start = first
        if what[0] in fresh or what[1] == "off":
            start = max(first, began + LATER)
            if start >= last:
                continue
        times = start + (last - start) * SAMPLES

        def g(t, function=function, direction=direction):
            return direction * function(dense(t), t)

        values = np.array([g(t) for t in times])
        if what[1] != "jump" and values[0] > GRAZING:
            if what[0] in fixed and what[0] in fresh:
                # It passed zero just where the arc before ended, as delayed values do at breaking points.
                return began, what
            raise UnsureError(f"{what} is beyond its surface already")
        up = np.flatnonzero((values[:-1] <= 0.0) & (values[1:] > 0.0))
        tops = [
            i
            for i in range(1, len(values) - 1)
            if values[i] <= 0.0 and values[i] >= values[i - 1] and values[i] >= values[i + 1]
        ]
        near = [i for i in tops if -values[i] < 4.0 * max(values[i] - values[i - 1], values[i] - values[i + 1])]
        for i in near:
            top = minimize_scalar(
                lambda t: -g(t), bounds=(times[i - 1], times[i + 1]), method="bounded", options={"xatol": 1e-9}
            )
            if abs(top.fun) < GRAZING and what[0] not in fixed:
                raise UnsureError(f"{what} grazes")
            if top.fun < 0:
                found.append((brentq(g, times[i - 1], top.x, xtol=1e-14), what))
        if len(up):
            i = up[0]
            found.append((brentq(g, times[i], times[i + 1], xtol=1e-14), what))
    return min(found, key=lambda f: f[0]) if found else None
