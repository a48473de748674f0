"""On which side of each event's surface a motion is: the signs between which crossings are looked for."""

from __future__ import annotations

from pddecont.simulate.integrator.calls import inlined, internal
from pddecont.simulate.integrator.event_functions import evaluate_event, evaluate_event_slope
from pddecont.simulate.integrator.state import FRESH, MODE


@internal
def note_sides(c, t):
    """Note on which side of each event's surface an arc begins; 0 on the surface itself."""
    mode = c.count[MODE]
    c.count[FRESH] = 0
    for segment in range(c.n_segments):
        event = c.segment_event[segment]
        if c.segment_mode[segment] == mode and c.after[event] < 0:
            c.side[segment] = _find_side(c, event, mode, t)
    if c.section >= 0:
        c.side[c.n_segments] = _find_side(c, c.section, mode, t)


@inlined
def update_side(c, place, event, t, whole):
    """Keep the sign of an event function where a step ends.

    It is what the search for crossings found, or where an event cuts the step (not ``whole``) what the function is
    there. A value that is zero to rounding leaves the sign as it was, and the crossing to the next step.
    """
    if whole:
        c.side[place] = c.found_side[place]
        return
    _, size = evaluate_event_slope(c, event, c.count[MODE], t, c.y)
    value = evaluate_event(c, event, t, c.y)
    if abs(value) > size:
        c.side[place] = 1 if value > 0.0 else -1


@internal
def _find_side(c, event, mode, t):
    """Return the sign of an event function at the present states, 0 if it is zero to rounding."""
    _, size = evaluate_event_slope(c, event, mode, t, c.y)
    value = evaluate_event(c, event, t, c.y)
    if abs(value) <= size:
        return 0
    return 1 if value > 0.0 else -1
