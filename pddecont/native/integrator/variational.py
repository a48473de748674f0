"""The tangent at events, and where the jumps of the past come back through delays.

Where a neighbouring motion meets an event a time ``shift`` later, it follows the old vector field for so much longer.
Its jump comes back through a delay as much later as well: there the tangent jumps by the difference of the vector
fields times that shift.

References: Müller, Chaos Solitons Fractals 5 (1995), for the jump at an event; that at a delayed read is its
counterpart.
"""

from __future__ import annotations

from pddecont.native.calls import call, offset
from pddecont.native.integrator.core import Core
from pddecont.native.integrator.event_functions import evaluate_event_slope
from pddecont.native.integrator.history import choose_arcs, read_delayed, read_delayed_slopes
from pddecont.native.integrator.past_reads import read_for_derivatives
from pddecont.native.integrator.pieces import find_first_step
from pddecont.native.integrator.places import FIRST, MODE, SHIFT, T_START, USED
from pddecont.native.integrator.rhs import evaluate_rhs
from pddecont.native.integrator.ring import find_step_before


def find_event_shift(c: Core, event: int, mode: int, t: float) -> float:
    """Return by how much later, to first order, a motion displaced by the tangent meets an event."""
    slope, along = _evaluate_event_changes(c, event, mode, t)
    return -along / slope if slope != 0.0 else 0.0


def _evaluate_event_changes(c: Core, event: int, mode: int, t: float) -> tuple[float, float]:
    """Return the derivatives of an event function along the flow and along the tangent, delayed values included."""
    n, y = c.n, c.y
    slope, _ = evaluate_event_slope(c, event, mode, t, y)
    read_delayed(c, t, y, c.xd_slope, 1)
    along = 0.0
    for i in range(n):
        along += c.gradient[i] * y[c.n_full + i]
    for i in range(c.n_pairs):
        along += c.gradient[n + i] * c.xd_slope[i]
    return slope, along


def map_tangent(c: Core, reset: int, mode: int, t: float, shift: float) -> None:
    """Write the tangent after the reset, taken at the neighbour's own event, to the second row of ``c.slope``.

    With the shift of its event the neighbour has there y + (tangent) + f (shift), and the reset's derivatives map it.
    """
    n, m, y, full = c.n, c.n_pairs, c.y, c.n_full
    flow, moved, result = c.slope, offset(c.slope, 2 * c.dimension), offset(c.slope, c.dimension)
    evaluate_rhs(c, mode, t, y, flow)
    read_delayed(c, t, y, c.xd, 0)
    if c.is_general == 1:
        read_for_derivatives(c, t, y, c.xd)
    for i in range(n * (n + m + 1)):
        c.jacobian[i] = 0.0
    call(c.reset_jacobian[reset], c.reset_case[reset], t, y, c.xd, c.p, c.jacobian)
    for i in range(full):
        moved[i] = result[i] = y[full + i] + flow[i] * shift
    read_delayed(c, t, y, c.xd_slope, 1)
    for i in range(n):
        result[i] = c.jacobian[n * (n + m) + i] * shift
        for j in range(n):
            result[i] += c.jacobian[i * n + j] * moved[j]
        for j in range(m):
            result[i] += c.jacobian[n * n + i * m + j] * c.xd_slope[j]
    read_delayed_slopes(c, t, y, flow, c.xd_slope)
    for i in range(n):
        for j in range(m):
            result[i] += c.jacobian[n * n + i * m + j] * c.xd_slope[j] * shift


def set_tangent(c: Core, mode: int, t: float, shift: float) -> None:
    """Write the tangent after an event to ``c.y``: what :func:`map_tangent` left less the new field times the shift."""
    evaluate_rhs(c, mode, t, c.y, c.slope)
    for i in range(c.n_full):
        c.y[c.n_full + i] = c.slope[c.dimension + i] - c.slope[i] * shift


def jump_at_lag(c: Core, k: int, slot: int, target: int, later: int, t: float) -> None:
    """Let the tangent jump where lag ``k`` passes to piece ``target``; the ``later`` of both begins at the jump there.

    With the read time a(t) = t - lag and a jump at xi, a neighbour passes it (d xi - d a) / a' later.
    """
    y = c.y
    slope, along = _evaluate_event_changes(c, c.n_events + 2 * k, c.count[MODE], t)
    number = find_first_step(c, later)
    inside = number < c.count[FIRST] + c.count[USED]
    own = c.past_shift[number & c.mask] if inside else c.clock[SHIFT]
    shift = (own - along) / slope if slope != 0.0 else 0.0
    evaluate_rhs(c, c.count[MODE], t, y, offset(c.slope, c.dimension))
    c.reading[slot] = target
    evaluate_rhs(c, c.count[MODE], t, y, c.slope)
    for i in range(c.n_full):
        y[c.n_full + i] += (c.slope[c.dimension + i] - c.slope[i]) * shift


def choose_arcs_with_tangent(c: Core, t: float, middle: float) -> bool:
    """Choose the arcs that a step reads, as :func:`choose_arcs` does; return whether any is another one.

    The tangent jumps where an arc begins to be read.
    """
    mode, changed = c.count[MODE], False
    for k in range(c.n_delays):
        if c.count[USED] == 0 or c.tau[k] == 0.0 or middle - c.tau[k] < c.clock[T_START] or c.chain_n > 0:
            continue
        number = find_step_before(c, middle - c.tau[k], c.cursor[k])
        arc = c.past_arc[number & c.mask]
        if arc == c.reading[k]:
            continue
        changed = True
        shift = c.past_shift[number & c.mask] if c.reading[k] >= 0 else 0.0
        if shift != 0.0:
            evaluate_rhs(c, mode, t, c.y, offset(c.slope, c.dimension))
        c.reading[k], c.cursor[k] = arc, number
        if shift != 0.0:
            evaluate_rhs(c, mode, t, c.y, c.slope)
            for i in range(c.n_full):
                c.y[c.n_full + i] += (c.slope[c.dimension + i] - c.slope[i]) * shift
    return choose_arcs(c, middle) or changed
