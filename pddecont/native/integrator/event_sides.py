"""On which side of each event's surface a motion is: the signs between which crossings are looked for."""

from __future__ import annotations

from pddecont.native.integrator.core import Core
from pddecont.native.integrator.event_functions import evaluate_event, evaluate_event_slope, find_flow_side
from pddecont.native.integrator.places import FRESH, MODE


def note_sides(c: Core, t: float) -> None:
    """Note on which side of each event's surface an arc begins; 0 on the surface itself."""
    mode = c.count[MODE]
    c.count[FRESH] = 0
    for place in range(c.n_segments + 1):
        c.residue[place] = 0.0
    for place in range(c.crossing_first[mode], c.crossing_first[mode + 1]):
        segment = c.crossing_segment[place]
        c.side[segment] = _find_side(c, c.segment_event[segment], mode, t)
    if c.section >= 0:
        c.side[c.n_segments] = _find_side(c, c.section, mode, t)


def carry_sides(c: Core, handled: int, resolution: float, before: int, t: float) -> None:
    """Note on which side of each event's surface the motion is after an event that ended mode ``before``.

    A function that the reset left, or put, off its zero has the sign that it has there. On its zero, event ``handled``
    (-1: none) has the sign of the side that the flow moves to, whatever rounding made of its value; if its slope says
    nothing the next step decides (0). The others stay on the side where they were: what carries them over their surface
    at this very moment is a crossing yet to come. ``resolution`` is how far from zero, to rounding, ``handled`` was.
    """
    mode = c.count[MODE]
    c.count[FRESH] = 0
    if handled >= 0:
        # Another event at this moment may lead to a mode that looks for this one again.
        c.passed[handled] = find_flow_side(c, handled, mode, t, c.y)
    for place in range(c.crossing_first[mode], c.crossing_first[mode + 1]):
        segment = c.crossing_segment[place]
        event = c.segment_event[segment]
        side = _find_known_side(c, event, before)
        if side == 0:
            side = c.passed[event]
        _, size = evaluate_event_slope(c, event, mode, t, c.y)
        value = evaluate_event(c, event, t, c.y)
        c.residue[segment] = 0.0
        if abs(value) > (max(size, resolution) if event == handled else size):
            c.side[segment] = 1 if value > 0.0 else -1
        elif event == handled:
            c.side[segment] = c.passed[event]
            c.residue[segment] = abs(value)
        else:
            c.side[segment] = side
    if c.section >= 0:
        side = _find_side(c, c.section, mode, t)
        if side != 0:
            c.side[c.n_segments] = side


def _find_known_side(c: Core, event: int, mode: int) -> int:
    """Return the side of an event's surface that the motion was on in ``mode``; 0 if it was not looked for there."""
    for place in range(c.crossing_first[mode], c.crossing_first[mode + 1]):
        segment = c.crossing_segment[place]
        if c.segment_event[segment] == event:
            return c.side[segment]
    return 0


def update_side(c: Core, place: int, event: int, t: float, whole: bool) -> None:
    """Keep the sign of an event function where a step ends.

    It is what the search for crossings found, or where an event cuts the step (not ``whole``) what the function is
    there. A value that is zero to rounding leaves the sign as it was, and the crossing to the next step.
    """
    if whole:
        c.side[place] = c.found_side[place]
        if c.residue[place] > 0.0 and abs(evaluate_event(c, event, t, c.y)) > c.residue[place]:
            c.residue[place] = 0.0
        return
    _, size = evaluate_event_slope(c, event, c.count[MODE], t, c.y)
    value = evaluate_event(c, event, t, c.y)
    if abs(value) > max(size, c.residue[place]):
        c.side[place] = 1 if value > 0.0 else -1
        c.residue[place] = 0.0


def _find_side(c: Core, event: int, mode: int, t: float) -> int:
    """Return the sign of an event function at the present states, 0 if it is zero to rounding."""
    _, size = evaluate_event_slope(c, event, mode, t, c.y)
    value = evaluate_event(c, event, t, c.y)
    if abs(value) <= size:
        return 0
    return 1 if value > 0.0 else -1
