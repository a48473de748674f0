"""Where events leave no way on: they accumulate, the motion comes to rest on a surface, or slides along it."""

from __future__ import annotations

from math import inf

from pddecont.native.calls import offset
from pddecont.native.integrator.core import Core
from pddecont.native.integrator.event_functions import evaluate_event, evaluate_event_slope
from pddecont.native.integrator.places import LAST_EVENT_TIME, SIMULTANEOUS, ZENO_TIME
from pddecont.native.integrator.ring import time_tolerance
from pddecont.native.integrator.status import Status

# More events at one moment than any model lists follow one another for ever.
MAX_SIMULTANEOUS = 1000
# So many ratios of gaps in a row, each this near to the one before, are a geometric series ...
SAME_RATIOS, SAME_RATIO = 8, 0.1
# ... whose end is reached when it is so near relative to the time, or when the event function, whose slope is known,
# is no larger than so many of its rounding errors within a gap.
NEAR_END, UNSEEN = 1e-10, 1000.0
# How far ahead a curvature is taken from a difference of slopes, relative to the time: near the root of the rounding.
AHEAD = 1e-6


def is_sliding(c: Core, event: int, crossing: int, old: int, new: int, t: float, resolution: float) -> bool:
    """Return whether the new mode's flow leads straight back through an event while the old one's still leads to it.

    Both vector fields then point at the surface (Filippov's criterion), and no motion leaves it. ``resolution`` is how
    far from zero the event function may have been, to rounding, when it was met.
    """
    if crossing == 0 or old == new:
        return False
    if not _ends_segment(c, event, -crossing, new):
        return False
    there, size = evaluate_event_slope(c, event, new, t, c.y)
    if there * crossing >= 0.0 or abs(evaluate_event(c, event, t, c.y)) > max(size, resolution):
        return False
    here, _ = evaluate_event_slope(c, event, old, t, c.y)
    return here * crossing > 0.0


def is_at_rest(c: Core, event: int, crossing: int, mode: int, t: float, resolution: float) -> bool:
    """Return whether the motion lies on the surface of an event after its reset.

    It is pressed on it, and leaves it by less than rounding. ``resolution`` is how far from zero the event function may
    have been, to rounding, when it was met.
    """
    if crossing == 0 or not _ends_segment(c, event, crossing, mode):
        return False
    slope, size = evaluate_event_slope(c, event, mode, t, c.y)
    size = max(size, resolution)
    if abs(evaluate_event(c, event, t, c.y)) > size:
        return False
    curvature = estimate_curvature(c, event, mode, t, slope)
    return curvature * crossing > 0.0 and slope * slope <= 2.0 * abs(curvature) * size


def detect_accumulation(c: Core, event: int, mode: int, t: float) -> int:
    """Follow the gaps between an event's repetitions; return ZENO once their end is near, REACHED before.

    Gaps that shrink by a ratio r each time end at t + gap r / (1 - r). ``mode`` is the one that the event ended: in the
    next one its function may stand still.
    """
    row = offset(c.accumulation, 4 * event)
    c.count[SIMULTANEOUS] = c.count[SIMULTANEOUS] + 1 if abs(t - c.clock[LAST_EVENT_TIME]) <= time_tolerance(t) else 0
    c.clock[LAST_EVENT_TIME] = t
    if c.count[SIMULTANEOUS] > MAX_SIMULTANEOUS:
        c.clock[ZENO_TIME] = t
        return Status.ZENO
    gap = t - row[0]
    ratio = gap / row[1] if row[1] > 0.0 else 0.0
    row[3] = row[3] + 1.0 if 0.0 < ratio < 1.0 and abs(ratio - row[2]) < SAME_RATIO else 0.0
    row[0], row[1], row[2] = t, gap, ratio
    if row[3] >= SAME_RATIOS:
        rest = gap * ratio / (1.0 - ratio)
        slope, size = inf, 0.0
        if c.after[event] < 0:
            slope, size = evaluate_event_slope(c, event, mode, t, c.y)
        # Below some gap nothing but rounding is left in the event function.
        if rest <= NEAR_END * max(1.0, abs(t)) or abs(slope) * gap <= UNSEEN * size:
            c.clock[ZENO_TIME] = t + rest
            return Status.ZENO
    return Status.REACHED


def estimate_curvature(c: Core, event: int, mode: int, t: float, slope: float) -> float:
    """Return the derivative along the flow of ``slope``, an event function's, from a short way ahead.

    ``c.slope`` holds the flow, as :func:`evaluate_event_slope` leaves it.
    """
    ahead = AHEAD * max(1.0, abs(t))
    y = c.trial
    for i in range(c.dimension):
        y[i] = c.y[i] + ahead * c.slope[i]
    later, _ = evaluate_event_slope(c, event, mode, t + ahead, y)
    return (later - slope) / ahead


def _ends_segment(c: Core, event: int, direction: int, mode: int) -> bool:
    """Return whether a segment of a mode ends where an event function crosses its zero in a direction."""
    for place in range(c.crossing_first[mode], c.crossing_first[mode + 1]):
        segment = c.crossing_segment[place]
        if c.segment_event[segment] == event and c.segment_direction[segment] * direction >= 0:
            return True
    return False
