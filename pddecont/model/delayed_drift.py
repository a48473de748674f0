"""How fast delayed values change the functions of switches: their states' equations, read as much earlier."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import sympy

from pddecont.model.expression import TIME
from pddecont.model.switches import Equations, Switch

# The state and the delay of a delayed value.
Delayed = Mapping[sympy.Symbol, tuple[str, sympy.Expr]]
Read = Callable[[str, sympy.Expr], sympy.Expr]


def add_drifts(equations: Equations, delayed: Delayed, read: Read) -> Equations:
    """Return the equations with what is known of how delayed values change their switches' functions.

    ``delayed`` are the values that the model reads; ``read(state, delay)`` returns the symbol of any other, which the
    model then reads too.
    """
    return replace(equations, switches=tuple(_add_drift(s, equations, delayed, read) for s in equations.switches))


def _add_drift(switch: Switch, equations: Equations, delayed: Delayed, read: Read) -> Switch:
    u, drift = switch.argument, sympy.S.Zero
    read_now = bool(u.free_symbols & set(equations.states))
    for symbol in sorted(u.free_symbols & set(delayed), key=str):
        # A surface of delayed values alone is crossed whatever the motion does now: its rate is not needed.
        rate = _find_rate(*delayed[symbol], equations, delayed, read) if read_now else None
        if rate is None:
            return replace(switch, drift=None)
        drift += u.diff(symbol) * rate
    return replace(switch, drift=drift)


def _find_rate(state: str, delay: sympy.Expr, equations: Equations, delayed: Delayed, read: Read) -> sympy.Expr | None:
    """Return the derivative of a delayed value; None if laws that jump, or jumps of its state, make it.

    The state's equation is read with every state, delayed value and time as much earlier.
    """
    number = next(k for k, x in enumerate(equations.states) if x.name == state)
    f, x = equations.field[number], equations.states[number]
    # The clocks of mod(t, T) are read at no other time.
    clocks = {y for k, y in enumerate(equations.states) if any(j.reset[k] == 0 for j in equations.jumps)}
    if f.free_symbols & ({s.digit for s in equations.switches} | clocks):
        return None
    if any(jump.reset[number] != x for jump in equations.jumps):
        return None
    earlier: dict[sympy.Symbol, sympy.Expr] = {TIME: TIME - delay}
    earlier |= {y: read(y.name, delay) for y in equations.states if y in f.free_symbols}
    earlier |= {s: read(name, tau + delay) for s, (name, tau) in delayed.items() if s in f.free_symbols}
    return f.xreplace(earlier)
