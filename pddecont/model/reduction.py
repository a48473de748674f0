"""What is left of a model when some parameters have fixed values and some events never happen.

One thing is cut after another, in the order of the functions below: values, events and modes, states, delays, forcing.
Each says what it took and why.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace

import sympy

from pddecont.model.conditions import list_differences, substitute_in
from pddecont.model.dependence import find_owners, find_unread_states
from pddecont.model.derived_modes import DerivedModes, make_modes
from pddecont.model.equation_reads import list_expressions
from pddecont.model.expression import TIME, require_finite, substitute
from pddecont.model.lagged import find_reading_symbols, make_symbol
from pddecont.model.parts import IDENTITY, Segment
from pddecont.model.reduced_reads import keep_reads, put_in_reads
from pddecont.model.syntax import ExpressionError
from pddecont.model.system import Model

KINDS = ("states", "modes", "events", "resets", "segments", "delayed", "delays", "forcing", "definitions")
Reasons = dict[str, dict[str, str]]


@dataclass(frozen=True)
class ReferencedNames:
    """What the expressions of a run name: identifiers, and modes that its motions start in or are put into."""

    identifiers: frozenset[str] = frozenset()
    modes: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Reduction:
    """A model on its way, what it was, and the reasons so far."""

    full: Model
    model: Model
    named: ReferencedNames
    reasons: Reasons = field(default_factory=lambda: {kind: {} for kind in KINDS})

    def to(self, model: Model) -> Reduction:
        """Return the same with less of the model."""
        return replace(self, model=model)


def reduce_model(
    model: Model, fixed: Mapping[str, sympy.Expr], dropped: Collection[str], named: ReferencedNames
) -> Reduction:
    """Return what is left with the parameters ``fixed`` and without the events ``dropped``.

    It is the model itself if there are none.
    """
    cut = Reduction(model, model, named)
    if fixed or dropped:
        cut = _values(cut, fixed, dropped)
        cut = _forcing(_delays(_states(cut if cut.model.derived else _events_and_modes(cut, dropped))))
    return cut


def _values(cut: Reduction, fixed: Mapping[str, sympy.Expr], dropped: Collection[str]) -> Reduction:
    """Put in the values of parameters; a delay of zero is none, and equal delays are one.

    The modes of a model given by its equations are made anew, without the jumps ``dropped``.
    """
    model = cut.model
    values: dict[sympy.Symbol, sympy.Expr] = {make_symbol(name): value for name, value in fixed.items()}
    reading, symbols = put_in_reads(model, values)
    values |= symbols

    def put_in(expr: sympy.Expr) -> sympy.Expr:
        return substitute(sympy.sympify(expr), values)

    def in_all(bodies: Mapping[str, tuple[sympy.Expr, ...]]) -> dict[str, tuple[sympy.Expr, ...]]:
        return {name: tuple(map(put_in, body)) for name, body in bodies.items()}

    events = {
        k: replace(
            e,
            function=None if e.function is None else put_in(e.function),
            delay=None if e.delay is None else put_in(e.delay),
        )
        for k, e in model.events.items()
    }
    numbers = {
        name: _number(model, fixed[name]) if name in fixed else value for name, value in model.parameters.items()
    }
    if model.derived is not None:
        made = _derive_anew(cut, model.derived, put_in, dropped)
    else:
        made = replace(
            model,
            modes=in_all(model.modes),
            events=events,
            resets=in_all(model.resets),
            segments={k: replace(s, guard=substitute_in(s.guard, values)) for k, s in model.segments.items()},
        )
    return cut.to(
        replace(
            made,
            fixed=fixed,
            parameters=numbers,
            delays=reading.delays,
            varying=reading.varying,
            delayed=reading.delayed,
            integrals=reading.integrals,
            period=None if model.period is None else put_in(model.period),
            history=tuple(map(put_in, model.history)),
            definitions={k: put_in(v) for k, v in model.definitions.items()},
        )
    )


def _derive_anew(
    cut: Reduction, derived: DerivedModes, put_in: Callable[[sympy.Expr], sympy.Expr], dropped: Collection[str]
) -> Model:
    """Return the model with modes, events, resets and segments made of what is left of its equations."""
    model, now = cut.model, make_modes(derived.equations.change(put_in, dropped))
    kinds: dict[str, tuple[Collection[str], str]] = {
        "modes": (model.modes, "no switch left makes it"),
        "events": (model.events, "nothing left makes it"),
        "resets": (model.resets, "no jump left applies it"),
        "segments": (model.segments, "no event left ends it"),
    }
    for kind, (before, why) in kinds.items():
        cut.reasons[kind] |= {name: why for name in before if name not in now.parts[kind]}
    digits = derived.find_digits(model.initial_mode) or ()
    known = {s.name: d for s, d in zip(derived.equations.switches, digits, strict=True)}
    start = tuple(known.get(s.name, s.free) for s in now.equations.switches)
    return replace(model, **now.parts, derived=now, initial_mode=now.find_mode(start))


def _number(model: Model, value: sympy.Expr) -> float:
    try:
        return model.evaluate(value)
    except (TypeError, ValueError):
        return math.nan


def _events_and_modes(cut: Reduction, dropped: Collection[str]) -> Reduction:
    """Take out the events that cannot happen any more, and the modes that only they led to."""
    model, why = cut.model, cut.reasons
    changing = {*model.state_symbols, *model.read_symbols, TIME}
    never = {name: "it never happens" for name in model.events if name in dropped}
    never |= {
        e.name: "its function changes no more"
        for e in model.events.values()
        if e.name not in never and e.function is not None and not e.function.free_symbols & changing
    }
    reached_before = _reachable({model.initial_mode}, model.segments.values())
    starts = {
        model.initial_mode,
        *(m for m in model.modes if m not in reached_before),
        *(cut.named.modes & set(model.modes)),
    }
    while True:
        segments = {k: s for k, s in model.segments.items() if s.event not in never and s.guard != sympy.false}
        reached = _reachable(starts, segments.values())
        segments = {k: s for k, s in segments.items() if s.mode in reached}
        ending = {s.event for s in segments.values()}
        late = {
            e.name: f"'{e.after}', which it comes after, never happens"
            for e in model.events.values()
            if e.after is not None and e.name not in never and e.after not in ending
        }
        if not late:
            break
        never |= late
    why["events"] |= never | {
        k: "no segment left ends at it" for k in model.events if k not in never and k not in ending
    }
    why["modes"] |= {k: "no segment left leads to it" for k in model.modes if k not in reached}
    why["segments"] |= {k: _explain_segment(s, never) for k, s in model.segments.items() if k not in segments}
    unused = set(model.resets) - {IDENTITY, *(s.reset for s in segments.values())}
    why["resets"] |= {k: "no segment left applies it" for k in model.resets if k in unused}
    return cut.to(
        replace(
            model,
            segments=segments,
            modes={k: v for k, v in model.modes.items() if k in reached},
            events={k: v for k, v in model.events.items() if k in ending},
            resets={k: v for k, v in model.resets.items() if k not in unused},
        )
    )


def _explain_segment(segment: Segment, never: Collection[str]) -> str:
    """Return why a segment is left out."""
    if segment.event in never:
        return f"its event '{segment.event}' never happens"
    return "its condition never holds" if segment.guard == sympy.false else f"its mode '{segment.mode}' is not reached"


def _reachable(starts: Iterable[str], segments: Iterable[Segment]) -> set[str]:
    steps = [(s.mode, s.to) for s in segments]
    seen = set(starts)
    todo = list(seen)
    while todo:
        here = todo.pop()
        for mode, to in steps:
            if mode == here and to not in seen:
                seen.add(to)
                todo.append(to)
    return seen


def _states(cut: Reduction) -> Reduction:
    """Take out the states that nothing left reads."""
    model = cut.model
    used = _in_definitions(cut)
    named = {s for s in model.states if s in cut.named.identifiers or make_symbol(s) in used}
    named |= set().union(*(names for s, names in find_owners(model).items() if s in used))
    gone = find_unread_states(cut.full, model, named)
    if not gone:
        return cut
    cut.reasons["states"] |= dict.fromkeys(gone, "nothing left reads it")
    kept = [i for i, s in enumerate(model.states) if s not in gone]

    def rows(body: tuple[sympy.Expr, ...]) -> tuple[sympy.Expr, ...]:
        return tuple(body[i] for i in kept)

    if model.derived is not None:
        derived = model.derived.keep_states(kept)
        model = replace(model, derived=derived, **derived.parts)
    else:
        modes, resets = ({k: rows(v) for k, v in group.items()} for group in (model.modes, model.resets))
        model = replace(model, modes=modes, resets=resets)
    return cut.to(
        replace(
            model,
            states=tuple(model.states[i] for i in kept),
            history=rows(model.history),
            delayed=tuple(replace(d, state=kept.index(d.state)) for d in model.delayed if d.state in kept),
        )
    )


def _delays(cut: Reduction) -> Reduction:
    """Take out the delayed quantities that no expression reads any more, and the definitions that read what is gone."""
    model, full = cut.model, cut.full
    used = _in_definitions(cut) | _in_expressions(model)
    left = keep_reads(model, used)
    values = {make_symbol(name): value for name, value in model.fixed.items()}
    _, now = put_in_reads(full, values)
    written = _in_expressions(full)
    reads = [(read, s) for read, s in zip(full.delayed, full.delayed_symbols, strict=True) if s in written]
    zero = {s for read, s in reads if now[s] == make_symbol(full.states[read.state]) or now[s] is sympy.nan}
    for _, s in reads:
        if now[s] not in left.delayed_symbols:
            cut.reasons["delayed"][s.name] = "its delay is 0" if s in zero else "nothing left reads it"
    every = zip(full.delayed, full.delayed_symbols, strict=True)
    kept = {full.find_delay(read) for read, s in every if now[s] in left.delayed_symbols}
    for read, s in reads:
        if full.find_delay(read) not in kept:
            why = "it is 0" if s in zero else "nothing left is delayed by it"
            cut.reasons["delays"][str(full.find_delay(read))] = why
    for s in full.integral_symbols:
        if s in written and now[s] not in left.integral_symbols:
            cut.reasons["delayed"][s.name] = "it is 0" if now[s] == 0 else "nothing left reads it"
    there = {*left.state_symbols, *left.read_symbols, *left.parameter_symbols, TIME}
    lost = [name for name, e in model.definitions.items() if not e.free_symbols <= there]
    cut.reasons["definitions"] |= dict.fromkeys(lost, "it reads what is left out")
    return cut.to(replace(left, definitions={k: v for k, v in model.definitions.items() if k not in lost}))


def _forcing(cut: Reduction) -> Reduction:
    """Take out the forcing where t, which appeared, appears no more."""
    model = cut.model
    if model.period is None or _timed(model) or not _timed(cut.full):
        return cut
    cut.reasons["forcing"]["period"] = "'t' appears nowhere any more"
    return cut.to(replace(model, period=None))


def _in_definitions(cut: Reduction) -> set[sympy.Symbol]:
    """Return what the definitions that a run names read."""
    return set().union(*(e.free_symbols for name, e in cut.model.definitions.items() if name in cut.named.identifiers))


def _in_expressions(model: Model) -> set[sympy.Symbol]:
    return set().union(*(e.free_symbols for e in _expressions(model)))


def _timed(model: Model) -> bool:
    return any(TIME in find_reading_symbols(e, model.chain) for e in _expressions(model))


def _expressions(model: Model) -> list[sympy.Expr]:
    """Return all that is evaluated along a motion: vector fields, resets, event functions, conditions.

    Of a model given by its equations it is what its modes are made of.
    """
    if model.derived is not None:
        return list_expressions(model.derived.surfaces)
    bodies = [e for group in (model.modes, model.resets) for body in group.values() for e in body]
    bodies += [e.function for e in model.events.values() if e.function is not None]
    return bodies + [e for s in model.segments.values() for e in list_differences(s.guard)]


def check_finite(model: Model) -> None:
    """Raise :class:`ExpressionError` if a formula of the model, or a parameter's value, is not finite."""
    later = [e.delay for e in model.events.values() if e.delay is not None]
    for expr in [
        *_expressions(model),
        *model.delays,
        *model.varying,
        *later,
        *model.history,
        *([] if model.period is None else [model.period]),
    ]:
        require_finite(expr)
    for name, value in model.parameters.items():
        if not math.isfinite(value):
            raise ExpressionError(f"parameter '{name}' is not finite")
