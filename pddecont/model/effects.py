"""A model without some of its effects: the terms, delays, events and modes that nothing left needs are gone."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import sympy

from pddecont.errors import PddecontError, suggest
from pddecont.model.expression import ExpressionError, substituted
from pddecont.model.system import IDENTITY, Model, delayed_symbol, symbol


@dataclass(frozen=True)
class LeftOut:
    """What a model lost with its effects, for a person to read."""

    effects: tuple[str, ...] = ()
    events: tuple[str, ...] = ()
    modes: tuple[str, ...] = ()
    delays: tuple[str, ...] = ()


def without(model: Model, off: Iterable[str]) -> tuple[Model, LeftOut]:
    """Return the model without the effects named in ``off``, and what went with them."""
    names = tuple(off)
    values: dict[sympy.Symbol, sympy.Expr] = {}
    dropped: set[str] = set()
    for name in names:
        if name not in model.effects:
            raise PddecontError(f"'{name}' is not an effect of model '{model.name}'{suggest(name, model.effects)} "
                                f"(effects: {', '.join(model.effects) or 'none'})")  # fmt: skip
        effect = model.effects[name]
        values |= {symbol(key): value for key, value in effect.set.items()}
        dropped |= set(effect.drop)
    if not names:
        return model, LeftOut()
    segments = {k: s for k, s in model.segments.items() if s.event not in dropped}
    reachable = _reachable(model.initial_mode, segments.values())
    segments = {k: s for k, s in segments.items() if s.mode in reachable}
    kept_events = {s.event for s in segments.values()}
    kept_events |= {e.after for e in model.events.values() if e.after and e.name in kept_events}

    def cut(expr: sympy.Expr) -> sympy.Expr:
        try:
            return substituted(sympy.sympify(expr), values)
        except ExpressionError as exc:
            raise PddecontError(f"without {', '.join(names)} the model is not what a model can be: {exc}") from exc

    modes = {k: tuple(map(cut, v)) for k, v in model.modes.items() if k in reachable}
    events = {k: replace(e, function=None if e.function is None else cut(e.function), delay=None if e.delay is None else cut(e.delay))
              for k, e in model.events.items() if k in kept_events}  # fmt: skip
    kept_resets = {IDENTITY, *(s.reset for s in segments.values())}
    resets = {k: tuple(map(cut, v)) for k, v in model.resets.items() if k in kept_resets}
    left = replace(model, modes=modes, events=events, resets=resets, segments=segments,
                   period=None if model.period is None else cut(model.period),
                   history=tuple(map(cut, model.history)), definitions={k: cut(v) for k, v in model.definitions.items()})  # fmt: skip
    left = _prune_delays(left)
    return left, LeftOut(names, tuple(sorted(set(model.events) - set(events))), tuple(sorted(set(model.modes) - set(modes))),
                         tuple(str(d) for d in model.delays if d not in left.delays))  # fmt: skip


def _reachable(start: str, segments: Iterable[object]) -> set[str]:
    steps = [(s.mode, s.to) for s in segments]  # type: ignore[attr-defined]
    seen, todo = {start}, [start]
    while todo:
        here = todo.pop()
        for mode, to in steps:
            if mode == here and to not in seen:
                seen.add(to)
                todo.append(to)
    return seen


def _prune_delays(model: Model) -> Model:
    """Return the model with only the delayed quantities that its expressions still read."""
    exprs = [e for group in (model.modes, model.resets) for body in group.values() for e in body]
    exprs += [e.function for e in model.events.values() if e.function is not None]
    used = set().union(*(e.free_symbols for e in exprs))
    pairs = [(i, k) for i, k in model.delayed if delayed_symbol(model.states[i], model.delays[k]) in used]
    kept = [k for k in range(len(model.delays)) if any(j == k for _, j in pairs)]
    return replace(model, delays=tuple(model.delays[k] for k in kept), delayed=tuple((i, kept.index(k)) for i, k in pairs))
