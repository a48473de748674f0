"""The tangent at events and at the echoes of jumps.

Where a neighbouring motion meets an event a time ``shift`` later, it follows the old vector field for so much longer. Its jump comes
back through a delay as much later as well: there the tangent jumps by the difference of the vector fields times that shift.

References: Müller, Chaos Solitons Fractals 5 (1995), for the jump at an event; the echo is its counterpart for delayed reads.
"""

from __future__ import annotations

from pddecont.simulate.kernel.calls import at, call, inner
from pddecont.simulate.kernel.crossings import slope_and_size
from pddecont.simulate.kernel.past import last_before, prepare, read, read_slopes
from pddecont.simulate.kernel.slopes import slopes
from pddecont.simulate.kernel.tables import MODE, T_START, USED


@inner
def event_shift(c, event, mode, t):
    """Return by how much later, to first order, a motion displaced by the tangent meets an event."""
    n, m, y = c.n, c.n_pairs, c.y
    slope, _ = slope_and_size(c, event, mode, t, y)
    read(c, t, y, c.xd_slope, 1)
    moved = 0.0
    for i in range(n):
        moved += c.gradient[i] * y[c.n_full + i]
    for i in range(m):
        moved += c.gradient[n + i] * c.xd_slope[i]
    return -moved / slope if slope != 0.0 else 0.0


@inner
def before_reset(c, reset, mode, t, shift):
    """Write to the second row of ``c.slope`` the tangent of the reset of what a neighbour has where it meets the event."""
    n, m, y, full = c.n, c.n_pairs, c.y, c.n_full
    flow, moved, result = c.slope, at(c.slope, 2 * c.dimension), at(c.slope, c.dimension)
    slopes(c, mode, t, y, flow)
    read(c, t, y, c.xd, 0)
    for i in range(n * (n + m + 1)):
        c.jacobian[i] = 0.0
    call(c.reset_jacobian, reset, t, y, c.xd, c.p, c.jacobian)
    for i in range(full):
        moved[i] = result[i] = y[full + i] + flow[i] * shift
    read(c, t, y, c.xd_slope, 1)
    for i in range(n):
        result[i] = c.jacobian[n * (n + m) + i] * shift
        for j in range(n):
            result[i] += c.jacobian[i * n + j] * moved[j]
        for j in range(m):
            result[i] += c.jacobian[n * n + i * m + j] * c.xd_slope[j]
    read_slopes(c, t, y, flow, c.xd_slope)
    for i in range(n):
        for j in range(m):
            result[i] += c.jacobian[n * n + i * m + j] * c.xd_slope[j] * shift


@inner
def after_reset(c, mode, t, shift):
    """Put the tangent after an event into ``c.y``, from what :func:`before_reset` left."""
    slopes(c, mode, t, c.y, c.slope)
    for i in range(c.n_full):
        c.y[c.n_full + i] = c.slope[c.dimension + i] - c.slope[i] * shift


@inner
def prepare_with_echoes(c, t, middle):
    """Choose the arcs that a step reads, as :func:`prepare` does, and let the tangent jump where one begins to be read."""
    mode, changed = c.count[MODE], False
    for k in range(c.n_delays):
        if c.count[USED] == 0 or c.tau[k] == 0.0 or middle - c.tau[k] < c.clock[T_START] or c.chain_n > 0:
            continue
        number = last_before(c, middle - c.tau[k], c.cursor[k])
        arc = c.past_arc[number & c.mask]
        if arc == c.reading[k]:
            continue
        changed = True
        shift = c.past_shift[number & c.mask] if c.reading[k] >= 0 else 0.0
        if shift != 0.0:
            slopes(c, mode, t, c.y, at(c.slope, c.dimension))
        c.reading[k], c.cursor[k] = arc, number
        if shift != 0.0:
            slopes(c, mode, t, c.y, c.slope)
            for i in range(c.n_full):
                c.y[c.n_full + i] += (c.slope[c.dimension + i] - c.slope[i]) * shift
    return prepare(c, middle) or changed
