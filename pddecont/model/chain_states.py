"""A delay equation as the ordinary differential equations of the paper: every stage of the chain a state of its own.

Stage i of n with delta = tau / n and scaled variables w_k = delta^k u_i^(k), k < M (eqs. (2.4), (3.14)):

    w_k' = w_{k+1} / delta,  k < M - 1;        w_{M-1}' = M! (u_{i-1} - sum_{k<M} w_k / k!) / delta

The orbits are those of ``delay.chain``, which eliminates the stages; this form shows what they cost.
"""

from __future__ import annotations

from dataclasses import replace
from math import factorial

import sympy

from pddecont.model.derived_modes import make_modes
from pddecont.model.lagged import make_symbol
from pddecont.model.system import Model


def name_stage(state: str, delay: int, stage: int, k: int) -> str:
    """Return the name of w_k of a stage of the chain of ``state`` through a delay.

    It cannot be typed as an identifier.
    """
    return f"{state}[{delay}, {stage}, {k}]"


def add_chain_states(model: Model, order: int, n: int) -> Model:
    """Return the model with chains of ``n`` stages of ``order`` in place of its delays.

    The variables of the chains are states, after the model's own.
    """
    names: list[str] = []
    equations: list[sympy.Expr] = []
    delayed: dict[sympy.Symbol, sympy.Symbol] = {}
    for read, value in zip(model.delayed, model.delayed_symbols, strict=True):
        state, delay = read.state, read.delay
        delta, before = model.delays[delay] / n, make_symbol(model.states[state])
        for stage in range(1, n + 1):
            own = [name_stage(model.states[state], delay, stage, k) for k in range(order)]
            w = list(map(make_symbol, own))
            taylor = sum(w[k] / factorial(k) for k in range(order))
            names += own
            equations += [*(w[k + 1] / delta for k in range(order - 1)), factorial(order) * (before - taylor) / delta]
            before = w[0]
        delayed[value] = before
    stages = tuple(map(make_symbol, names))

    def body(exprs: tuple[sympy.Expr, ...], more: tuple[sympy.Expr, ...]) -> tuple[sympy.Expr, ...]:
        return (*(e.xreplace(delayed) for e in exprs), *more)

    events = {
        k: e if e.function is None else replace(e, function=e.function.xreplace(delayed))
        for k, e in model.events.items()
    }
    if model.derived is not None:
        left = model.derived.equations.change(lambda e: e.xreplace(delayed), ())
        derived = make_modes(left.add_states(stages, tuple(equations)))
        model = replace(model, derived=derived, **derived.parts)
    else:
        model = replace(
            model,
            modes={k: body(v, tuple(equations)) for k, v in model.modes.items()},
            events=events,
            resets={k: body(v, stages) for k, v in model.resets.items()},
            segments={k: replace(s, guard=s.guard.xreplace(delayed)) for k, s in model.segments.items()},
        )
    return replace(
        model,
        states=(*model.states, *names),
        delays=(),
        delayed=(),
        history=(*model.history, *(sympy.Integer(0) for _ in names)),
        definitions={k: v.xreplace(delayed) for k, v in model.definitions.items()},
    )
