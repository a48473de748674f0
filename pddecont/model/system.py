"""The symbolic model: modes, events, resets, segments, delays as sympy expressions."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import sympy

from pddecont.errors import SignatureError, suggest
from pddecont.memo import cached_property
from pddecont.model.derived_modes import DerivedModes
from pddecont.model.evaluation import evaluate
from pddecont.model.expression import TIME, Scope
from pddecont.model.lagged import (
    ChainRule,
    DelayedValue,
    Integral,
    make_chain_rule,
    make_delayed_symbol,
    make_integral_symbol,
    make_symbol,
)
from pddecont.model.left_out import LeftOut
from pddecont.model.parts import Event, Segment
from pddecont.model.syntax import ExpressionError


@dataclass(frozen=True)
class Effect:
    """What a run without this effect changes: parameter values, events that never happen."""

    set: Mapping[str, sympy.Expr]
    drop: tuple[str, ...]


@dataclass(frozen=True)
class Model:
    """A piecewise-smooth delay differential equation in symbols.

    ``delays`` are expressions in the parameters, ``varying`` those delays that depend on states, delayed values or t
    too; ``delayed`` lists the delayed values that the model reads, in the order of ``delayed_symbols``, and
    ``integrals`` the integrals over the past. ``modes`` and ``resets`` hold one expression for each state. ``fixed``
    are parameters that effects left out set, in terms of the others.
    """

    name: str
    reference: str | None
    states: tuple[str, ...]
    parameters: Mapping[str, float]
    period: sympy.Expr | None
    modes: Mapping[str, tuple[sympy.Expr, ...]]
    events: Mapping[str, Event]
    resets: Mapping[str, tuple[sympy.Expr, ...]]
    segments: Mapping[str, Segment]
    effects: Mapping[str, Effect]
    delays: tuple[sympy.Expr, ...]
    delayed: tuple[DelayedValue, ...]
    initial_mode: str
    history: tuple[sympy.Expr, ...]
    definitions: Mapping[str, sympy.Expr] = field(default_factory=dict)
    fixed: Mapping[str, sympy.Expr] = field(default_factory=dict)
    left_out: LeftOut = field(default_factory=LeftOut)
    units: Mapping[str, str] = field(default_factory=dict)
    # Of a model given by its equations: what its modes, events, resets and segments are made of.
    derived: DerivedModes | None = None
    varying: tuple[sympy.Expr, ...] = ()
    integrals: tuple[Integral, ...] = ()

    @cached_property
    def forced(self) -> bool:
        """Whether the model depends on time explicitly."""
        return self.period is not None

    def list_segments(self, mode: str) -> tuple[Segment, ...]:
        """Return the segments that run in a mode, in declared order."""
        return self._segments_by_mode.get(mode, ()) if self.derived is None else tuple(self.derived.list_segments(mode))

    def has_segment(self, name: str) -> bool:
        """Return whether a segment has a name, with or without the mode that it leads to."""
        if name in self.segments:
            return True
        return name in self._ways if self.derived is None else self.derived.has_ending(name)

    def list_ways(self, segment: Segment) -> tuple[Segment, ...]:
        """Return the segments that one may be, those where the motion rests too: those of one name in the file."""
        return self._ways[segment.written or segment.name] if self.derived is None else self.derived.list_ways(segment)

    def list_rests(self, segment: Segment) -> tuple[Segment, ...]:
        """Return what a segment is where its event accumulates and the motion rests."""
        if self.derived is not None:
            return tuple(self.derived.list_rests(self.derived.find_ending(segment)))
        return tuple(way for way in self.list_ways(segment) if way.rests)

    @cached_property
    def _segments_by_mode(self) -> Mapping[str, tuple[Segment, ...]]:
        return _group((segment.mode, segment) for segment in self.segments.values())

    @cached_property
    def _ways(self) -> Mapping[str, tuple[Segment, ...]]:
        return _group((segment.written or segment.name, segment) for segment in self.segments.values())

    @cached_property
    def smooth(self) -> bool:
        """Whether the model has no events at all."""
        return not self.list_segments(self.initial_mode) and not self.segments

    @cached_property
    def state_symbols(self) -> tuple[sympy.Symbol, ...]:
        """One symbol a state."""
        return tuple(map(make_symbol, self.states))

    @cached_property
    def parameter_symbols(self) -> tuple[sympy.Symbol, ...]:
        """One symbol a parameter."""
        return tuple(map(make_symbol, self.parameters))

    @cached_property
    def delayed_symbols(self) -> tuple[sympy.Symbol, ...]:
        """One symbol a delayed value."""
        return tuple(make_delayed_symbol(self.states[d.state], self.find_delay(d), d.derivative) for d in self.delayed)

    @cached_property
    def integral_symbols(self) -> tuple[sympy.Symbol, ...]:
        """One symbol an integral over the past."""
        return tuple(make_integral_symbol(integral, self.states) for integral in self.integrals)

    @cached_property
    def read_symbols(self) -> tuple[sympy.Symbol, ...]:
        """What functions read of the past: the delayed values, then the integrals."""
        return (*self.delayed_symbols, *self.integral_symbols)

    @cached_property
    def chain(self) -> ChainRule:
        """How the values read change with what their delays and limits depend on."""
        return make_chain_rule(self.states, self.delays, self.varying, self.delayed, self.integrals)

    @cached_property
    def read_groups(self) -> Mapping[tuple[int, int], list[int]]:
        """The numbers of the delayed values by delay and derivative."""
        groups: dict[tuple[int, int], list[int]] = {}
        for number, read in enumerate(self.delayed):
            groups.setdefault((read.delay, read.derivative), []).append(number)
        return groups

    @cached_property
    def read_kinds(self) -> tuple[tuple[int, int], ...]:
        """All that is read of the past by single delays: each delay and derivative once."""
        return tuple(self.read_groups)

    def find_delay(self, read: DelayedValue) -> sympy.Expr:
        """Return how long ago a value is read."""
        return (*self.delays, *self.varying)[read.delay]

    @cached_property
    def parameter_values(self) -> dict[str, sympy.Expr]:
        """What each parameter's name stands for in a run's expressions.

        That is its symbol, or what an effect left out sets it to.
        """
        return {name: self.fixed.get(name, make_symbol(name)) for name in self.parameters}

    def hint(self, kind: str, name: str, known: Collection[str]) -> str:
        """Return what to say of a name that is no member of ``kind``.

        That is why it was left out, or a similar name that is known.
        """
        return self.left_out.hint(kind, name) or suggest(name, known)

    def missing(self, name: str) -> str:
        """Return why a state or definition was left out; empty if there never was one."""
        return self.left_out.hint("states", name) or self.left_out.hint("definitions", name)

    def scope(self, place: str, **changes: Any) -> Scope:
        """Return the names that an expression over this model may use (for monitors and run files)."""
        symbols = {name: make_symbol(name) for name in self.states} | self.parameter_values | dict(self.definitions)
        return Scope(symbols, states=self.states, place=place, time=self.forced, missing=self.missing, **changes)

    def parameter_scope(self, place: str) -> Scope:
        """Return the scope of an expression in the parameters alone."""
        return Scope(self.parameter_values, time=False, place=place)

    def delayed_value(self, state: str, delay: sympy.Expr, derivative: int = 0) -> sympy.Expr:
        """Return the symbol of a delayed value, or rate, that the model itself reads.

        Raise :class:`ExpressionError` for any other.
        """
        if delay == 0 and not derivative:
            return make_symbol(state)
        wanted = make_delayed_symbol(state, delay, derivative)
        if wanted in self.delayed_symbols:
            return wanted
        known = ", ".join(s.name for s in self.delayed_symbols)
        gone = self.left_out.hint("delayed", wanted.name)
        raise ExpressionError(
            f"only delayed values that the model itself reads can be used here ({known or 'none'}){gone}"
        )

    def history_scope(self) -> Scope:
        """Return the scope of an expression for the history before the start: parameters and t."""
        return Scope(self.parameter_values, place="the initial history")

    def evaluate(self, expr: sympy.Expr, values: Mapping[str, float] | None = None, time: float | None = None) -> float:
        """Return the number that an expression in the parameters (and t) stands for.

        Raise :class:`ExpressionError` if it has none.
        """
        numbers = {make_symbol(k): float(v) for k, v in {**self.parameters, **(values or {})}.items()}
        result = evaluate(expr, numbers if time is None else {**numbers, TIME: time})
        if not math.isfinite(result):
            raise ExpressionError("is not a finite real number at these parameters")
        return result


def _group(named: Iterable[tuple[str, Segment]]) -> dict[str, tuple[Segment, ...]]:
    groups: dict[str, list[Segment]] = {}
    for name, segment in named:
        groups.setdefault(name, []).append(segment)
    return {name: tuple(group) for name, group in groups.items()}


def check_signature(model: Model, signature: Sequence[str]) -> None:
    """Raise :class:`SignatureError` unless each segment leads to the mode of the next, the last to the first's."""
    for name in signature:
        if name not in model.segments:
            raise SignatureError(
                f"'{name}' is not a segment of this model{model.hint('segments', name, model.segments)} "
                f"(segments: {', '.join(model.segments) or 'none'})"
            )
    for here, there in zip(signature, [*signature[1:], *signature[:1]], strict=True):
        a, b = model.segments[here], model.segments[there]
        if a.to != b.mode:
            raise SignatureError(
                f"segment '{here}' leads to mode '{a.to}', but '{there}' runs in mode '{b.mode}'; "
                f"after '{here}' comes one of: {', '.join(find_followers(model, here)) or 'none'}"
            )


def find_followers(model: Model, segment: str) -> list[str]:
    """Return the segments that may follow ``segment``."""
    return [s.name for s in model.list_segments(model.segments[segment].to)]
