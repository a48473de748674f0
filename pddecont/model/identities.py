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
    if h is None or h.free_symbols & set(model.read_symbols):
        return False
    ends = _stays if at_end else _begins
    return ends(model, segments, s, h, len(segments))


def find_rate(model: Model, event: str, mode: str) -> sympy.Expr:
    """Return how fast an event's function changes along the flow of a mode; it reads no delayed values."""
    function = model.events[event].function
    assert function is not None, "a delayed event has no event function"
    return _rate(function, model.state_symbols, model.modes[mode])


def _stays(model: Model, segments: Sequence[Segment], s: int, h: sympy.Expr, left: int) -> bool:
    """Return whether a function is zero all along segment ``s``: where it begins, and so is its rate."""
    if left == 0 or not _begins(model, segments, s, h, left):
        return False
    rate = _rate(h, model.state_symbols, model.modes[segments[s].mode])
    return bool(rate.is_zero) or (not rate.is_number and _stays(model, segments, s, rate, left - 1))


def _begins(model: Model, segments: Sequence[Segment], s: int, h: sympy.Expr, left: int) -> bool:
    """Return whether a function is zero where segment ``s`` begins.

    It is followed back to a reset or an event that makes it zero, ``left`` segments at most.
    """
    before = segments[(s - 1) % len(segments)]
    if left == 0 or not before.event or h.free_symbols & set(model.read_symbols):
        return False
    after = _after(h, model.state_symbols, model.resets[before.reset])
    if after.is_zero:
        return True
    if after != h:
        return False
    return model.events[before.event].function == h or _stays(model, segments, s - 1, h, left - 1)


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
