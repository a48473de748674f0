"""Contacts: jumps of equations at which a motion may rest, held by a force.

A motion rests at u = 0 with w = du/dt = 0. The force pushes in the direction b in which the reset of the jump does,
counted so that w grows by one along it, and is as large as w' = 0 asks for. That is sliding along w = 0: a contact is a
switch with the function w, and its digit h is 0 for motions below u = 0 that are free, 1 for those above, and in
between, or beyond, the force -h or 1 - h.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace

import sympy

from pddecont.model.expression import TIME
from pddecont.model.rest import find_push, find_rate_along
from pddecont.model.switches import ABOVE, BELOW, ON, Digits, Equations, Jump, Switch
from pddecont.model.vanishing import vanishes, vanishes_where

# From which side motions meet a stop, by the direction of its jump.
SIDES = {"rising": BELOW, "falling": ABOVE}


def add_contacts(equations: Equations) -> Equations:
    """Return equations with the forces of the contacts at which motions may rest."""
    made = equations
    for jump in equations.jumps:
        if jump.rests and not any(_explain(equations, jump, ())):
            made = _add_contact(made, jump, find_rate(equations, jump))
    return made


def find_rate(equations: Equations, jump: Jump) -> sympy.Expr:
    """Return du/dt of the function of a jump."""
    assert jump.function is not None
    return find_rate_along(jump.function, equations.states, equations.field)


def _add_contact(equations: Equations, jump: Jump, rate: sympy.Expr) -> Equations:
    push, side = find_push(equations.states, rate, jump.reset), SIDES[jump.direction]
    assert push is not None, "a reset without a direction makes no contact"
    digit = sympy.Symbol(f"{{{jump.name}}}", real=True)
    force = 1 - digit if side == ABOVE else -digit
    contact = Switch(jump.name, digit, rate, contact=jump.function, free=side)
    field = tuple(f + force * b for f, b in zip(equations.field, push, strict=True))
    return replace(equations, field=field, switches=(*equations.switches, contact))


def is_held(equations: Equations, jump: Jump, digits: Digits) -> bool:
    """Return whether a jump cannot happen where contacts hold a motion: it is theirs, or its function is constant."""
    for switch, digit in zip(equations.switches, digits, strict=True):
        if switch.contact is not None and digit == ON:
            if switch.name == jump.name:
                return True
            if jump.function is not None and _is_constant(jump.function, switch.contact, equations.states):
                return True
    return False


def _is_constant(function: sympy.Expr, zero: sympy.Expr, states: Collection[sympy.Symbol]) -> bool:
    """Return whether a function neither moves nor vanishes where another one is zero."""
    moving = {*states, TIME}
    for x in sorted(zero.free_symbols & set(states), key=str):
        slope = zero.diff(x)
        if slope != 0 and not slope.free_symbols:
            left = sympy.expand(function.xreplace({x: sympy.expand(x - zero / slope)}))
            return not left.free_symbols & moving and left != 0
    return False


def list_refusals(equations: Equations, delayed: Collection[sympy.Symbol]) -> Iterator[tuple[tuple[str, ...], str]]:
    """Yield why jumps at which motions should rest make no contact, and the keys at which the file says so.

    ``delayed`` are the delayed values that the model reads.
    """
    for jump in equations.jumps:
        if jump.rests:
            yield from (((jump.name, key), why) for key, why in _explain(equations, jump, delayed))


def _explain(equations: Equations, jump: Jump, delayed: Collection[sympy.Symbol]) -> Iterator[tuple[str, str]]:
    """Yield what keeps a motion from resting at a jump: the key in the file, and what is wrong there."""
    u, moving = jump.function, {*equations.states, TIME}
    if u is None:
        yield "rest", "a motion rests where a function is zero: 'rest' goes with 'at'"
        return
    if jump.direction not in SIDES:
        yield "rest", "a motion rests on the side from which it comes: say 'direction: rising' or 'falling'"
        return
    if not u.free_symbols & set(equations.states):
        yield "at", "a motion rests on a surface of states, and this function reads none"
        return
    rate = find_rate(equations, jump)
    if (u.free_symbols | rate.free_symbols) & set(delayed):
        yield "at", "a motion rests where neither this function nor its rate reads a delayed value"
        return
    digits = {s.digit for s in equations.switches}
    if (u.free_symbols | rate.free_symbols) & digits:
        yield "at", "the rate of this function jumps with a switch; a motion rests where forces change it smoothly"
        return
    after = dict(zip(equations.states, jump.reset, strict=True))
    if not vanishes(sympy.expand(u.xreplace(after) - u)):
        yield "reset", "this reset changes the function of 'at': a motion rests where impacts change its rate alone"
        return
    if not vanishes_where(rate.xreplace(after), rate, moving):
        yield "reset", f"this reset lets a motion go on that comes with rate zero ({rate}): it never rests"
        return
    push = find_push(equations.states, rate, jump.reset)
    if push is None:
        yield "reset", "this reset does not change the rate of the function of 'at' in one direction: no force holds"
        return
    yield from _explain_others(equations, jump, rate, push)


def _explain_others(
    equations: Equations, jump: Jump, rate: sympy.Expr, push: tuple[sympy.Expr, ...]
) -> Iterator[tuple[str, str]]:
    """Yield which switches and other jumps leave open what a motion does that rests at a jump."""
    assert jump.function is not None
    states = equations.states
    for switch in equations.switches:
        zeros = (vanishes_where(switch.argument, zero, {*states, TIME}) for zero in (jump.function, rate))
        if not switch.remembers and any(zeros):
            yield "rest", f"switch '{switch.name}' is zero where a motion rests: nothing decides on its side"
            return
        pushed = sum((switch.argument.diff(x) * b for x, b in zip(states, push, strict=True)), sympy.S.Zero)
        if not vanishes(sympy.expand(pushed)):
            yield "rest", f"what holds a motion here pushes it across switch '{switch.name}' too: nothing decides how"
            return
    read = rate.free_symbols | jump.function.free_symbols
    for other in equations.jumps:
        changed = {x for x, g in zip(states, other.reset, strict=True) if g != x}
        away = other.function is not None and _is_constant(other.function, jump.function, states)
        if other.name != jump.name and changed & read and not away:
            yield "rest", f"jump '{other.name}' moves what rests here: nothing decides whether it stays"
            return
