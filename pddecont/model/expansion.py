"""A model given by its equations, written by hand: with modes, events, resets and segments."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import sympy
from sympy.core.relational import Relational
from sympy.logic.boolalg import Boolean
from sympy.printing.str import StrPrinter

from pddecont.errors import PddecontError
from pddecont.model.parts import IDENTITY, Event, Segment
from pddecont.model.system import Model
from pddecont.model.transitions import find_rest, list_alternatives, list_leaders

COMPARISONS = {sympy.Gt: ">", sympy.Ge: ">=", sympy.Lt: "<", sympy.Le: "<="}

# A file by hand with more modes is no use to anybody.
MAX_MODES = 300


class _FormulaPrinter(StrPrinter):  # type: ignore[misc]
    """Prints what the parser of formulas reads."""

    def _print_Exp1(self, expr: sympy.Expr) -> str:
        return "exp(1)"

    def _print_Float(self, expr: sympy.Float) -> str:
        return repr(float(expr))


_PRINTER = _FormulaPrinter()


def expand_model(model: Model) -> dict[str, Any]:
    """Return a model as the mapping of a file with modes, events, resets and segments.

    Raises
    ------
    PddecontError
        If it has more modes than anybody reads.
    """
    if model.derived is not None and not model.derived.build_every(MAX_MODES):
        raise PddecontError(
            f"model '{model.name}' makes {model.derived.n_modes} modes; at most {MAX_MODES} are written by hand. "
            "'info' without '--expand' says what its switches do; effects left out ('--without') make it smaller"
        )
    states = model.states
    forcing = {} if model.period is None else {"forcing": {"period": write_formula(model.period)}}
    history = {
        s: float(e) if e.is_number else write_formula(e) for s, e in zip(states, model.history, strict=True) if e != 0
    }
    effects = {
        name: {"set": {k: write_formula(e) for k, e in effect.set.items()}, "drop": list(effect.drop)}
        for name, effect in model.effects.items()
        if set(effect.drop) <= set(model.events)
    }
    # The speed that is zero at rest is no event.
    needed = {s.event for s in model.segments.values()} | {e.after for e in model.events.values()}
    return {
        "name": model.name,
        **({"reference": model.reference} if model.reference else {}),
        "states": list(states),
        "parameters": dict(model.parameters),
        **({"units": dict(model.units)} if model.units else {}),
        **forcing,
        "modes": {
            name: {f"{s}'": write_formula(f) for s, f in zip(states, body, strict=True)}
            for name, body in model.modes.items()
        },
        "events": {event.name: _write_event(model, event) for event in model.events.values() if event.name in needed},
        "resets": {
            name: {s: write_formula(g) for s, x, g in zip(states, model.state_symbols, body, strict=True) if g != x}
            for name, body in model.resets.items()
            if name in {segment.reset for segment in model.segments.values() if not segment.rests} - {IDENTITY}
        },
        "segments": {s.written or s.name: _write_segment(model, s.name) for s in list_leaders(model.segments.values())},
        **({"effects": effects} if effects else {}),
        "initial": {"mode": model.initial_mode, **history},
    }


def write_formula(expr: sympy.Expr) -> str:
    """Return an expression as text that reads back as the same."""
    return str(_PRINTER.doprint(expr))


def write_condition(condition: Boolean) -> str:
    """Return a condition as text that reads back as the same."""
    if isinstance(condition, Relational):
        return f"{write_formula(condition.lhs)} {COMPARISONS[condition.func]} {write_formula(condition.rhs)}"
    parts = [f"({write_condition(part)})" for part in condition.args]
    if isinstance(condition, sympy.Not):
        return f"not {parts[0]}"
    return (" and " if isinstance(condition, sympy.And) else " or ").join(parts)


def _write_event(model: Model, event: Event) -> Any:
    if event.function is not None:
        return write_formula(event.function)
    assert event.delay is not None and event.after is not None
    if event.after not in model.events:
        raise PddecontError(
            f"'{event.name}' comes after '{event.after}', which is another event in each mode: no model by hand says so"
        )
    return {"after": event.after, "delay": write_formula(event.delay)}


def _list_possible(ways: Iterable[Segment]) -> Iterator[Segment]:
    """Yield the ways whose conditions may hold after those before: some differ by less than a double can tell."""
    left: Boolean = sympy.true
    for way in ways:
        numbers = {number: sympy.Float(float(number), 17) for number in way.guard.atoms(sympy.Float)}
        guard = way.guard.xreplace(numbers)
        if sympy.And(left, guard) != sympy.false:
            yield way
            left = sympy.And(left, sympy.Not(guard))


def _write_segment(model: Model, name: str) -> dict[str, Any]:
    segment = model.segments[name]
    ways = list_alternatives(model, segment)
    to: Any = segment.to
    if len(ways) > 1:
        held = list(_list_possible(ways[:-1]))
        to = [{"when": write_condition(way.guard), "mode": way.to} for way in held] + [{"mode": ways[-1].to}]
    reset = {} if segment.reset == IDENTITY else {"reset": segment.reset}
    resting = find_rest(model, segment)
    rest = {} if resting is None else {"rest": resting.to}
    return {"mode": segment.mode, "event": segment.event, "direction": segment.direction, **reset, "to": to, **rest}
