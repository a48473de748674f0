"""Event functions that are zero at an end of a segment whatever the orbit.

A reset puts the motion on the surface, or its flow stays there.

A stick phase holds the slip at zero; the slip phase that follows begins there at every parameter. That is no meeting of
two events.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import sympy

from pddecont.model.expression import TIME
from pddecont.model.parts import Segment
from pddecont.model.system import Model


def vanishes_identically(model: Model, segments: Sequence[Segment], s: int, event: str, *, at_end: bool) -> bool:
    """Return whether an event's function is zero at the end (or start) of a segment for every orbit of a signature.

    The segment is number ``s``.
    """
    h = model.events[event].function
    if h is None or h.free_symbols & set(model.delayed_symbols):
        return False
    return _stays(model, segments, s, event) if at_end else _begins(model, segments, s, event, len(segments))


def find_rate(model: Model, event: str, mode: str) -> sympy.Expr:
    """Return how fast an event's function changes along the flow of a mode; it reads no delayed values."""
    function = model.events[event].function
    assert function is not None, "a delayed event has no event function"
    return _rate(function, model.state_symbols, model.modes[mode])


def _stays(model: Model, segments: Sequence[Segment], s: int, event: str) -> bool:
    rate = find_rate(model, event, segments[s].mode)
    return bool(rate.is_zero) and _begins(model, segments, s, event, len(segments))


def _begins(model: Model, segments: Sequence[Segment], s: int, event: str, left: int) -> bool:
    """Return whether segment ``s`` begins on the surface.

    It is followed back to a reset or an event that puts it there, ``left`` segments at most.
    """
    before, h = segments[(s - 1) % len(segments)], model.events[event].function
    if left == 0 or not before.event:
        return False
    after = _after(h, model.state_symbols, model.resets[before.reset])
    if after.is_zero:
        return True
    if after != h:
        return False
    return before.event == event or (
        bool(_rate(h, model.state_symbols, model.modes[before.mode]).is_zero)
        and _begins(model, segments, s - 1, event, left - 1)
    )


Exprs = tuple[sympy.Expr, ...]


@lru_cache(maxsize=1024)
def _after(h: sympy.Expr, states: Exprs, reset: Exprs) -> sympy.Expr:
    """Return a function of the states after a reset, in those before it."""
    changes = {state: g for state, g in zip(states, reset, strict=True) if g != state}
    return h if not changes.keys() & h.free_symbols else sympy.expand(h.xreplace(changes))


@lru_cache(maxsize=1024)
def _rate(h: sympy.Expr, states: Exprs, flow: Exprs) -> sympy.Expr:
    """Return how fast a function of states and time changes along a flow."""
    moving = ((state, f) for state, f in zip(states, flow, strict=True) if state in h.free_symbols)
    return sympy.expand(h.diff(TIME) + sum((h.diff(state) * f for state, f in moving), sympy.S.Zero))
