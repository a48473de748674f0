"""Event functions: their values, their slopes along the flow, and how far from zero they are zero to rounding."""

from __future__ import annotations

from pddecont.native.arrays import Floats
from pddecont.native.calls import call
from pddecont.native.integrator.core import Core
from pddecont.native.integrator.history import read_delayed, read_delayed_slopes
from pddecont.native.integrator.past_reads import read_for_derivatives
from pddecont.native.integrator.places import ZERO
from pddecont.native.integrator.rhs import evaluate_rhs
from pddecont.native.integrator.ring import time_tolerance

# Rounding in the terms of an event function, relative to them, and in the time, in tolerances of it; both leave some
# room above what a few operations make.
ROUNDING, TIME_ROUNDING = 1e-14, 4.0


def evaluate_event(c: Core, event: int, t: float, y: Floats) -> float:
    """Return the value of an event function."""
    if c.reads[event] == 1:
        read_delayed(c, t, y, c.xd, 0)
    c.gradient[0] = 0.0
    call(c.event[event], c.event_case[event], t, y, c.xd, c.p, c.gradient)
    # Functions beyond those of events are those of lags, whose zero is where something that they read begins or ends.
    return c.gradient[0] if event < c.n_events else c.gradient[0] - c.lag_time[ZERO]


def evaluate_event_slope(c: Core, event: int, mode: int, t: float, y: Floats) -> tuple[float, float]:
    """Return dh/dt along the flow of ``mode``, and how far from zero the function may be and still be zero to rounding.

    The latter is what rounding in its terms, and in the time at which it is evaluated, makes of it. The derivatives
    dh/dx, dh/dxd, dh/dt are left in ``c.gradient``, the flow in ``c.slope``.
    """
    n, m, gradient = c.n, c.n_pairs, c.gradient
    evaluate_rhs(c, mode, t, y, c.slope)
    for i in range(n + m + 1):
        gradient[i] = 0.0
    read_delayed(c, t, y, c.xd, 0)
    if c.is_general == 1:
        read_for_derivatives(c, t, y, c.xd)
    call(c.event_jacobian[event], c.event_case[event], t, y, c.xd, c.p, gradient)
    slope, moving = gradient[n + m], abs(gradient[n + m])
    size = moving * abs(t)
    for i in range(n):
        slope += gradient[i] * c.slope[i]
        moving += abs(gradient[i] * c.slope[i])
        size += abs(gradient[i] * y[i])
    if c.reads[event] == 1:
        read_delayed_slopes(c, t, y, c.slope, c.xd_slope)
        for i in range(m):
            slope += gradient[n + i] * c.xd_slope[i]
            moving += abs(gradient[n + i] * c.xd_slope[i])
            size += abs(gradient[n + i] * c.xd[i])
    return slope, ROUNDING * size + TIME_ROUNDING * time_tolerance(t) * moving


def find_flow_side(c: Core, event: int, mode: int, t: float, y: Floats) -> int:
    """Return the side of an event's surface that the flow of ``mode`` moves to at once; 0 if its slope is rounding."""
    slope, _ = evaluate_event_slope(c, event, mode, t, y)
    if abs(slope) <= slope_rounding(c, event):
        return 0
    return 1 if slope > 0.0 else -1


def slope_rounding(c: Core, event: int) -> float:
    """Return how much of the slope that :func:`evaluate_event_slope` found last may be rounding in its terms."""
    moving = abs(c.gradient[c.n + c.n_pairs])
    for i in range(c.n):
        moving += abs(c.gradient[i] * c.slope[i])
    if c.reads[event] == 1:
        for i in range(c.n_pairs):
            moving += abs(c.gradient[c.n + i] * c.xd_slope[i])
    return ROUNDING * moving
