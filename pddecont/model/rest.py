"""Impacts that accumulate: what the last one of infinitely many makes of the states.

A reset g changes a motion that meets the surface u = 0 with the rate w = du/dt in the direction

    b = (g(x) - x) / (w(g(x)) - w(x)),

which is counted so that w grows by one along it. All impacts that are left together take the rate away: from x the
motion comes to x - b w(x). What it flies between them is of second order in w.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

import sympy

from pddecont.model.expression import TIME
from pddecont.model.parts import Event, Segment
from pddecont.model.validation import ALTERNATIVE
from pddecont.model.vanishing import vanishes, vanishes_where

Exprs = tuple[sympy.Expr, ...]


def find_push(states: Exprs, rate: sympy.Expr, reset: Exprs) -> Exprs | None:
    """Return the direction b in which a reset changes a motion whose function has the rate w at its surface.

    None if the reset does not change the rate, or if b has no value where the rate is zero.
    """
    after = dict(zip(states, reset, strict=True))
    gained = rate.xreplace(after) - rate
    if vanishes(sympy.expand(gained)):
        return None
    push = tuple(sympy.cancel((g - x) / gained) if g != x else sympy.S.Zero for x, g in after.items())
    for b in push:
        denominator = sympy.fraction(sympy.together(b))[1]
        if denominator.free_symbols and vanishes_where(denominator, rate, {*states, TIME}):
            return None
    return push


def find_resting(states: Exprs, rate: sympy.Expr, reset: Exprs) -> Exprs:
    """Return the states at rest on the surface that a motion comes to from the last impact that is followed.

    Where nothing is known of a rest that is what the reset makes of them.
    """
    push = find_push(states, rate, reset)
    return reset if push is None else tuple(sympy.cancel(x - b * rate) for x, b in zip(states, push, strict=True))


def make_resting(segment: Segment, written: str, mode: str) -> Segment:
    """Return the segment that one is where it ends with the last impact and leads to the mode of rest.

    Its reset is called as it is.
    """
    name = f"{written}{ALTERNATIVE}{mode}"
    return replace(segment, name=name, reset=name, to=mode, written=written, guard=sympy.true, rests=True)


def find_resets_to_rest(
    states: Exprs,
    delayed: Collection[sympy.Symbol],
    modes: Mapping[str, Exprs],
    events: Mapping[str, Event],
    resets: Mapping[str, Exprs],
    segments: Mapping[str, Segment],
) -> dict[str, Exprs]:
    """Return the resets of the segments that lead to rest and have none yet; ``delayed`` are delayed values."""
    found = {}
    for resting in segments.values():
        if resting.rests and resting.reset not in resets:
            impact = next(s for s in segments.values() if (s.written or s.name) == resting.written and not s.rests)
            function, reset = events[resting.event].function, resets[impact.reset]
            found[resting.reset] = find_reset_to_rest(states, delayed, modes[resting.mode], function, reset)
    return found


def find_reset_to_rest(
    states: Exprs, delayed: Collection[sympy.Symbol], flow: Exprs, function: sympy.Expr | None, reset: Exprs
) -> Exprs:
    """Return the states at rest where a function is zero along a flow, after the last impact that is followed.

    That is what the reset makes of them where the rate of the function reads ``delayed`` values.
    """
    rate = sympy.S.Zero if function is None else find_rate_along(function, states, flow)
    known = function is not None and not (rate.free_symbols | function.free_symbols) & set(delayed)
    return find_resting(states, rate, reset) if known else reset


def find_rate_along(function: sympy.Expr, states: Exprs, flow: Exprs) -> sympy.Expr:
    """Return how fast a function of states and time changes along a flow."""
    moving = (function.diff(x) * f for x, f in zip(states, flow, strict=True) if x in function.free_symbols)
    return sympy.expand(function.diff(TIME) + sum(moving, sympy.S.Zero))
