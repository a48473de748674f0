"""How fast delayed values change the functions of switches: their states' equations, read as much earlier."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

import sympy

from pddecont.model.expression import TIME
from pddecont.model.past_reads import PastReads
from pddecont.model.switches import Equations, Switch

# The state and the delay of a delayed value, and how often it is differentiated.
Delayed = Mapping[sympy.Symbol, tuple[str, sympy.Expr, int]]


def add_drifts(equations: Equations, past: PastReads) -> Equations:
    """Return the equations with what is known of how delayed values change their switches' functions.

    ``past`` is what the model reads; rates may need more, which the model then reads too.
    """
    delayed, unknown = dict(past.list_delayed()), past.symbols
    return replace(
        equations, switches=tuple(_add_drift(s, equations, delayed, unknown, past) for s in equations.switches)
    )


def _add_drift(
    switch: Switch, equations: Equations, delayed: Delayed, unknown: Collection[sympy.Symbol], past: PastReads
) -> Switch:
    u, drift = switch.argument, sympy.S.Zero
    read_now = bool(u.free_symbols & set(equations.states))
    for symbol in sorted(u.free_symbols & set(unknown), key=str):
        # A surface of delayed values alone is crossed whatever the motion does now: its rate is not needed.
        rate = _find_rate(delayed[symbol], equations, delayed, past) if read_now and symbol in delayed else None
        if rate is None:
            return replace(switch, drift=None)
        drift += u.diff(symbol) * rate
    return replace(switch, drift=drift)


def _find_rate(
    value: tuple[str, sympy.Expr, int], equations: Equations, delayed: Delayed, past: PastReads
) -> sympy.Expr | None:
    """Return the derivative of a delayed value; None if laws that jump, or jumps of its state, make it.

    The state's equation is read with every state, delayed value and time as much earlier.
    """
    state, delay, derivative = value
    if derivative or past.varies(delay):
        return None
    number = next(k for k, x in enumerate(equations.states) if x.name == state)
    f, x = equations.field[number], equations.states[number]
    # The clocks of mod(t, T) are read at no other time.
    clocks = {y for k, y in enumerate(equations.states) if any(j.reset[k] == 0 for j in equations.jumps)}
    if f.free_symbols & ({s.digit for s in equations.switches} | clocks):
        return None
    if any(jump.reset[number] != x for jump in equations.jumps):
        return None
    earlier: dict[sympy.Symbol, sympy.Expr] = {TIME: TIME - delay}
    earlier |= {y: past.read(y.name, delay) for y in equations.states if y in f.free_symbols}
    reads = {s: read for s, read in delayed.items() if s in f.free_symbols}
    if f.free_symbols & (past.symbols - reads.keys()) or any(past.varies(tau) for _, tau, _ in reads.values()):
        return None
    earlier |= {s: past.read(name, tau + delay, order) for s, (name, tau, order) in reads.items()}
    return f.xreplace(earlier)
