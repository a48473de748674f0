"""Which states of a model read which, and the states that an effect leaves without a reader."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

import sympy
from sympy.utilities.iterables import strongly_connected_components

from pddecont.model.equation_reads import list_conditions, list_state_reads
from pddecont.model.lagged import find_reading_symbols, make_symbol
from pddecont.model.system import Model

Reads = Mapping[str, set[str]]


def find_owners(model: Model) -> dict[sympy.Symbol, set[str]]:
    """Return the states that each symbol of a model is read from, now or in the past, by delays that vary too."""
    owners = {make_symbol(name): {name} for name in model.states}
    owners |= {s: {model.states[d.state]} for d, s in zip(model.delayed, model.delayed_symbols, strict=True)}
    for integral, symbol in zip(model.integrals, model.integral_symbols, strict=True):
        owners[symbol] = {name for name in model.states if make_symbol(name) in integral.integrand.free_symbols}
    for s, ways in model.chain.items():
        inside = set().union(*(find_reading_symbols(inner, model.chain) for inner, _ in ways))
        owners[s] = owners[s].union(*(owners[other] for other in inside if other in owners))
    return owners


def find_reads(model: Model) -> tuple[Reads, set[str]]:
    """Return the states that each state's equations and resets read, and those that decide what happens.

    Those are in event functions and conditions. They are read now or delayed.
    """
    owners = find_owners(model)

    def states_in(exprs: Iterable[sympy.Expr]) -> set[str]:
        return set().union(*(owners[s] for e in exprs for s in e.free_symbols if s in owners))

    if model.derived is not None:
        reads = list_state_reads(model.derived.surfaces)
        return (
            {name: states_in(reads[i]) - {name} for i, name in enumerate(model.states)},
            states_in(list_conditions(model.derived.surfaces)),
        )
    bodies = [*model.modes.values(), *model.resets.values()]
    by_state = {name: states_in(body[i] for body in bodies) - {name} for i, name in enumerate(model.states)}
    functions = [e.function for e in model.events.values() if e.function is not None]
    return by_state, states_in([*functions, *(s.guard for s in model.segments.values())])


def find_unread_states(full: Model, left: Model, named: Collection[str]) -> list[str]:
    """Return the states of ``left`` that nothing left needs although something in ``full`` did.

    States that read one another stand and fall together. Such a group goes when nothing outside it reads it any more,
    and it is either what only fed others in ``full`` (a clock, a generator of forcing) or follows states that stay (a
    filter, a controller). The group of the model's first state stays, and so do those in ``named``, those that nothing
    ever read, and motions of their own that were coupled.
    """
    by_state, by_events = find_reads(full)
    now, now_by_events = find_reads(left)
    groups = strongly_connected_components((list(left.states), [(a, b) for a in left.states for b in sorted(now[a])]))
    kept = set(left.states)
    stays = {left.states[0], *named, *now_by_events}
    changed = True
    while changed:
        changed = False
        for group in map(set, groups):
            outside = kept - group
            if not group <= kept or group & stays or any(now[s] & group for s in outside):
                continue
            was_read = group & by_events or any(by_state[s] & group for s in set(full.states) - group)
            only_fed = all(by_state[s] <= group for s in group)
            follows = any(now[s] & outside for s in group)
            if was_read and (only_fed or follows):
                kept, changed = outside, True
    return [s for s in left.states if s not in kept]
