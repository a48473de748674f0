"""What a model reads of the past when parameters have fixed values, or when expressions read less of it."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

import sympy

from pddecont.model.expression import substitute
from pddecont.model.lagged import (
    DelayedValue,
    Integral,
    arrange_delays,
    close_reads,
    list_parameter_slopes,
    make_delayed_symbol,
    make_integral_symbol,
    make_symbol,
    read_integrand,
)
from pddecont.model.system import Model

Values = Mapping[sympy.Symbol, sympy.Expr]


def put_in_reads(model: Model, values: Values) -> tuple[Model, dict[sympy.Symbol, sympy.Expr]]:
    """Return a model with values put into its delays and integrals, and what each symbol of a read becomes.

    A delay of zero is none, and equal delays are one.
    """
    known: dict[sympy.Symbol, sympy.Expr] = dict(values)
    delays: list[sympy.Expr] = []
    delayed: list[DelayedValue] = []
    for read, symbol in zip(model.delayed, model.delayed_symbols, strict=True):
        lag, state = substitute(sympy.sympify(model.find_delay(read)), known), model.states[read.state]
        if lag == 0:
            # The rate at the present time is what the equations say; none of them may hold it.
            known[symbol] = sympy.nan if read.derivative else make_symbol(state)
            continue
        if lag not in delays:
            delays.append(lag)
        delayed.append(replace(read, delay=delays.index(lag)))
        known[symbol] = make_delayed_symbol(state, lag, read.derivative)
    integrals: list[Integral] = []
    for integral, symbol in zip(model.integrals, model.integral_symbols, strict=True):
        parts = (integral.integrand, integral.low, integral.high)
        put = Integral(*(substitute(sympy.sympify(part), known) for part in parts))
        if put.integrand == 0 or put.low == put.high:
            known[symbol] = sympy.S.Zero
            continue
        integrals.append(put)
        known[symbol] = make_integral_symbol(put, model.states)
    symbols = {symbol: known[symbol] for symbol in model.read_symbols}
    return _arrange(model, delays, delayed, integrals), symbols


def list_reads(model: Model) -> set[sympy.Symbol]:
    """Return the symbols of what a model's equations, and its delays and limits, read of the past.

    Those that only derivatives need are not among them.
    """
    if model.derived is None:
        functions = [event.function for event in model.events.values()]
        exprs = [e for part in (*model.modes.values(), *model.resets.values()) for e in part]
        exprs += [h for h in functions if h is not None]
    else:
        equations = model.derived.equations
        exprs = [*equations.field, *(s.argument for s in equations.switches)]
        exprs += [e for jump in equations.jumps for e in (*jump.reset, jump.function) if e is not None]
    known, found = set(model.read_symbols), set[sympy.Symbol]()
    inside = {s: [model.find_delay(r)] for r, s in zip(model.delayed, model.delayed_symbols, strict=True)}
    inside |= {s: [i.low, i.high] for i, s in zip(model.integrals, model.integral_symbols, strict=True)}
    ahead = {s for expr in exprs for s in expr.free_symbols} & known
    while ahead:
        found |= ahead
        ahead = {s for read in ahead for expr in inside[read] for s in expr.free_symbols} & known - found
    return found


def keep_reads(model: Model, used: Collection[sympy.Symbol]) -> Model:
    """Return a model that reads no more of the past than the symbols ``used``, and what those depend on."""
    needed = set(used)
    before = -1
    while len(needed) > before:
        before = len(needed)
        for read, symbol in zip(model.delayed, model.delayed_symbols, strict=True):
            needed |= model.find_delay(read).free_symbols if symbol in needed else set()
        for integral, symbol in zip(model.integrals, model.integral_symbols, strict=True):
            needed |= _list_needs(integral, model.states) if symbol in needed else set()
    delays = [*model.delays, *model.varying]
    delayed = [r for r, symbol in zip(model.delayed, model.delayed_symbols, strict=True) if symbol in needed]
    kept = sorted({read.delay for read in delayed})
    return _arrange(
        model,
        [delays[k] for k in kept],
        [replace(read, delay=kept.index(read.delay)) for read in delayed],
        [i for i, symbol in zip(model.integrals, model.integral_symbols, strict=True) if symbol in needed],
    )


def _list_needs(integral: Integral, states: tuple[str, ...]) -> set[sympy.Symbol]:
    """Return the symbols that an integral and its derivatives read."""
    needs = {make_integral_symbol(slope, states) for _, slope in list_parameter_slopes(integral, states)}
    for limit in (integral.low, integral.high):
        needs |= limit.free_symbols
        if limit != 0:
            needs |= read_integrand(integral, limit, states).free_symbols
    return needs


def _arrange(model: Model, delays: list[sympy.Expr], delayed: list[DelayedValue], integrals: list[Integral]) -> Model:
    known = set(model.parameter_symbols)
    varies = [not delay.free_symbols <= known for delay in delays]
    constant, varying, renumbered = arrange_delays(delays, list(dict.fromkeys(delayed)), varies)
    return replace(
        model,
        delays=constant,
        varying=varying,
        delayed=close_reads(renumbered, len(constant)),
        integrals=tuple(dict.fromkeys(integrals)),
    )
