"""What is evaluated along the motions of equations with switches, whichever modes they come to."""

from __future__ import annotations

import sympy

from pddecont.model.sliding import Surfaces


def list_state_reads(surfaces: Surfaces) -> list[list[sympy.Expr]]:
    """Return for each state the expressions that its rate and its resets are made of.

    Where a motion slides, a digit stands for what its switch's rate reads.
    """
    equations, rates = surfaces.equations, surfaces.rates
    bodies = [equations.field, *(jump.reset for jump in equations.jumps)]
    found = []
    for i in range(len(equations.states)):
        exprs = [body[i] for body in bodies]
        seen: set[sympy.Symbol] = set()
        for expr in exprs:
            for k, switch in enumerate(equations.switches):
                rate = rates[k]
                if surfaces.slides[k] and rate is not None and switch.digit in expr.free_symbols - seen:
                    seen.add(switch.digit)
                    exprs.append(rate)
        found.append(exprs)
    return found


def list_conditions(surfaces: Surfaces) -> list[sympy.Expr]:
    """Return the expressions that decide when something happens, and which mode follows."""
    equations = surfaces.equations
    rates = zip(surfaces.rates, surfaces.slides, strict=True)
    found = [e for s in equations.switches for e in (s.argument, s.low, s.high)]
    found += [rate for rate, slides in rates if rate is not None and (slides or equations.jumps)]
    return found + [jump.function for jump in equations.jumps if jump.function is not None]


def list_expressions(surfaces: Surfaces) -> list[sympy.Expr]:
    """Return all that is evaluated along a motion: the field, resets, what decides when something happens."""
    resets = [g for jump in surfaces.equations.jumps for g in jump.reset]
    return [*surfaces.equations.field, *resets, *list_conditions(surfaces)]
