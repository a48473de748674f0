"""Names in a model file: which stand for two things, which for nothing, and which are not used."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any

import sympy

from pddecont.errors import suggest
from pddecont.model.document import KeyPath
from pddecont.model.expression import TIME
from pddecont.model.parts import Event, Segment
from pddecont.model.schema import ModelFile
from pddecont.model.switches import Equations


def find_clashes(file: ModelFile) -> Iterator[tuple[KeyPath, str]]:
    """Yield the names that stand for two things: where the second stands, and a message."""
    owner: dict[str, str] = {}
    groups: Iterable[tuple[str, Iterable[str]]] = (
        ("states", file.states),
        ("parameters", file.parameters),
        ("definitions", file.definitions),
        ("delays", file.delays),
    )
    for group, names in groups:
        for i, name in enumerate(names):
            if name in owner:
                path = (group, i) if group == "states" else (group, name)
                yield path, f"'{name}' stands already among the {owner[name]}; rename one"
            owner[name] = group


def find_strange_units(file: ModelFile) -> Iterator[tuple[KeyPath, str]]:
    """Yield the units of what the model does not have: where they stand, and a message."""
    known = [*file.states, *file.parameters, *file.definitions, *file.delays, TIME.name]
    for name in file.units:
        if name not in known:
            yield ("units", name), f"'{name}' is no state, parameter or definition and not t{suggest(name, known)}"


def find_unused_parameters(file: ModelFile, symbols: Collection[sympy.Symbol]) -> Iterator[tuple[KeyPath, str]]:
    """Yield the parameters that are neither among the symbols used nor set by an effect: their place, and a message."""
    used = {s.name for s in symbols} | {name for effect in file.effects.values() for name in effect.set}
    for name in file.parameters:
        if name not in used:
            yield ("parameters", name), f"parameter '{name}' is not used in any mode, event, reset, condition or delay"


def collect_from_equations(equations: Equations, period: sympy.Expr | None) -> dict[KeyPath, set[sympy.Symbol]]:
    """Return the symbols in each equation, switch and jump, by where they stand in a file."""
    used: dict[KeyPath, set[sympy.Symbol]] = {}
    for state, f in zip(equations.states, equations.field, strict=True):
        used["equations", f"{state}'"] = set(f.free_symbols)
    for switch in equations.switches:
        exprs = (switch.argument, switch.low, switch.high, switch.grip)
        readers = [path for path, symbols in used.items() if switch.digit in symbols] or [("equations",)]
        for path in readers:
            used.setdefault(path, set()).update(*(e.free_symbols for e in exprs))
    for jump in equations.jumps:
        exprs = (*jump.reset, jump.when, *(e for e in (jump.function, jump.delay) if e is not None))
        used["jumps", jump.name] = set().union(*(e.free_symbols for e in exprs))
    used[("forcing",)] = set(period.free_symbols) if period is not None else set()
    return used


def list_equations(equations: Equations) -> list[tuple[str, sympy.Expr]]:
    """Return what the expressions of equations are called, and the expressions."""
    named = [(f"{x}'", f) for x, f in zip(equations.states, equations.field, strict=True)]
    named += [(f"switch '{s.name}'", s.argument) for s in equations.switches]
    for jump in equations.jumps:
        named += [] if jump.function is None else [(f"jump '{jump.name}'", jump.function)]
        named += [(f"{x} of jump '{jump.name}'", g) for x, g in zip(equations.states, jump.reset, strict=True)]
    return named


def collect_symbols(
    modes: Mapping[str, Any],
    events: Mapping[str, Event],
    resets: Mapping[str, Any],
    segments: Iterable[Segment],
    period: sympy.Expr | None,
) -> dict[KeyPath, set[sympy.Symbol]]:
    """Return the symbols in each expression of the model, by the path of the expression's mapping."""
    used: dict[KeyPath, set[sympy.Symbol]] = {}
    for group, members in (("modes", modes), ("resets", resets)):
        for name, exprs in members.items():
            used[(group, name)] = set().union(*(e.free_symbols for e in exprs))
    for name, event in events.items():
        used[("events", name)] = set().union(*(e.free_symbols for e in (event.function, event.delay) if e is not None))
    for segment in segments:
        if segment.written:
            used.setdefault(("segments", segment.written), set()).update(segment.guard.free_symbols)
    used[("forcing",)] = set(period.free_symbols) if period is not None else set()
    return used
