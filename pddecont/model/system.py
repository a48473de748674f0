"""The symbolic model: every expression parsed, every name resolved, every cross-reference checked."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import sympy

from pddecont.errors import ModelError, Problem, SignatureError, suggest
from pddecont.model.document import Document, KeyPath, parse_document, read_text
from pddecont.model.expression import TIME, ExpressionError, Scope, parse
from pddecont.model.schema import DelayedEvent, ModelFile
from pddecont.model.validation import validate

IDENTITY = "identity"


@dataclass(frozen=True)
class Event:
    """A zero of ``function`` along the orbit, or a moment ``delay`` after the event ``after``."""

    name: str
    function: sympy.Expr | None
    after: str | None = None
    delay: sympy.Expr | None = None


@dataclass(frozen=True)
class Segment:
    """The arc {mode, event, reset} of the paper's section 2.3 and the mode it leads to."""

    name: str
    mode: str
    event: str
    direction: str
    reset: str
    to: str


@dataclass(frozen=True)
class Effect:
    """What a run without this effect changes: parameter values, events that never happen."""

    set: Mapping[str, sympy.Expr]
    drop: tuple[str, ...]


@dataclass(frozen=True)
class Model:
    """A piecewise-smooth delay differential equation in symbols.

    ``delays`` are expressions in the parameters; ``delayed`` lists the delayed quantities as pairs (state number, delay
    number), in the order of ``delayed_symbols``. ``modes`` and ``resets`` hold one expression for each state.
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
    delayed: tuple[tuple[int, int], ...]
    initial_mode: str
    history: tuple[sympy.Expr, ...]
    definitions: Mapping[str, sympy.Expr] = field(default_factory=dict)

    @cached_property
    def forced(self) -> bool:
        """Whether the model depends on time explicitly."""
        return self.period is not None

    @cached_property
    def smooth(self) -> bool:
        """Whether the model has no events at all."""
        return not self.segments

    @cached_property
    def state_symbols(self) -> tuple[sympy.Symbol, ...]:
        """One symbol a state."""
        return tuple(map(symbol, self.states))

    @cached_property
    def parameter_symbols(self) -> tuple[sympy.Symbol, ...]:
        """One symbol a parameter."""
        return tuple(map(symbol, self.parameters))

    @cached_property
    def delayed_symbols(self) -> tuple[sympy.Symbol, ...]:
        """One symbol a delayed quantity."""
        return tuple(delayed_symbol(self.states[i], self.delays[k]) for i, k in self.delayed)

    def scope(self, place: str, **changes: Any) -> Scope:
        """Return the names that an expression over this model may use (for monitors and run files)."""
        symbols = {name: symbol(name) for name in (*self.states, *self.parameters)} | dict(self.definitions)
        return Scope(symbols, states=self.states, place=place, time=self.forced, **changes)

    def parameter_scope(self, place: str) -> Scope:
        """Return the scope of an expression in the parameters alone."""
        return Scope({name: symbol(name) for name in self.parameters}, time=False, place=place)

    def delayed_value(self, state: str, delay: sympy.Expr) -> sympy.Expr:
        """Return the symbol of a delayed value that the model itself reads; raise :class:`ExpressionError` for any other."""
        if delay == 0:
            return symbol(state)
        for i, k in self.delayed:
            if self.states[i] == state and self.delays[k] == delay:
                return delayed_symbol(state, delay)
        known = ", ".join(s.name for s in self.delayed_symbols)
        raise ExpressionError(f"only delayed values that the model itself reads can be used here ({known or 'none'})")

    def history_scope(self) -> Scope:
        """Return the scope of an expression for the history before the start: parameters and t."""
        return Scope({name: symbol(name) for name in self.parameters}, place="the initial history")

    def evaluate(self, expr: sympy.Expr, values: Mapping[str, float] | None = None) -> float:
        """Return the number that an expression in the parameters stands for."""
        numbers = {symbol(k): v for k, v in {**self.parameters, **(values or {})}.items()}
        return float(expr.evalf(17, subs=numbers))


def symbol(name: str) -> sympy.Symbol:
    """Return the symbol of a state or parameter."""
    return sympy.Symbol(name, real=True)


def delayed_symbol(state: str, delay: sympy.Expr) -> sympy.Symbol:
    """Return the symbol of a state's delayed value; its name cannot be typed as an identifier."""
    return sympy.Symbol(f"{state}(t - {delay})", real=True)


def check_signature(model: Model, signature: Sequence[str]) -> None:
    """Raise :class:`SignatureError` unless each segment leads to the mode of the next, the last to that of the first."""
    for name in signature:
        if name not in model.segments:
            raise SignatureError(f"'{name}' is not a segment of this model{suggest(name, model.segments)} "
                                 f"(segments: {', '.join(model.segments) or 'none'})")  # fmt: skip
    for here, there in zip(signature, [*signature[1:], *signature[:1]], strict=True):
        a, b = model.segments[here], model.segments[there]
        if a.to != b.mode:
            raise SignatureError(f"segment '{here}' leads to mode '{a.to}', but '{there}' runs in mode '{b.mode}'; "
                                 f"after '{here}' comes one of: {', '.join(followers(model, here)) or 'none'}")  # fmt: skip


def followers(model: Model, segment: str) -> list[str]:
    """Return the segments that may follow ``segment``."""
    return [s.name for s in model.segments.values() if s.mode == model.segments[segment].to]


def load_model(path: str) -> tuple[Model, list[Problem]]:
    """Return the model in the file at ``path`` and its warnings; raise :class:`ModelError` with all that is wrong."""
    return parse_model(parse_document(read_text(path, ModelError), path, ModelError))


def parse_model(document: Document) -> tuple[Model, list[Problem]]:
    """Return the model in ``document`` and its warnings; raise :class:`ModelError` with all that is wrong."""
    file, problems = validate(document, ModelFile)
    if file is None:
        raise ModelError(problems)
    builder = _Builder(document, file)
    model = builder.build()
    if builder.problems or model is None:
        raise ModelError(builder.problems)
    return model, sorted(builder.warnings)


class _Builder:
    """Collects problems while it turns a validated file into a Model."""

    def __init__(self, document: Document, file: ModelFile):
        self.document, self.file = document, file
        self.problems: list[Problem] = []
        self.warnings: list[Problem] = []
        self.delays: list[sympy.Expr] = []
        self.delayed: list[tuple[int, int]] = []
        self.used: set[str] = set()
        self.numbers = {symbol(k): v for k, v in file.parameters.items()}

    def complain(self, path: KeyPath, message: str, *, offset: int = 0, key: bool = False) -> None:
        self.problems.append(self.document.problem(path, message, offset=offset, key=key))

    def warn(self, path: KeyPath, message: str) -> None:
        self.warnings.append(self.document.problem(path, message, key=True))

    def expression(self, path: KeyPath, text: str | float, scope: Scope) -> sympy.Expr:
        try:
            return parse(text, scope)
        except ExpressionError as exc:
            self.complain(path, str(exc), offset=exc.offset)
            return sympy.Integer(0)

    def build(self) -> Model | None:
        file = self.file
        self.check_names()
        if self.problems:
            return None
        parameters = {name: symbol(name) for name in file.parameters}
        self.parameter_scope = Scope(parameters, time=False, place="a delay or a period")
        period = None
        if file.forcing:
            period = self.positive(("forcing", "period"), file.forcing.period, "the forcing period")
        base = {name: symbol(name) for name in file.states} | parameters
        definitions = self.definitions(base)
        self.scope = Scope(base | definitions, states=file.states, delayed=self.delayed_value, place="the model")
        modes = {name: self.mode(name, body) for name, body in file.modes.items()}
        events = {name: self.event(name, body) for name, body in file.events.items()}
        resets = {name: self.reset(name, body) for name, body in file.resets.items()}
        resets.setdefault(IDENTITY, tuple(map(symbol, file.states)))
        segments = {name: Segment(name, *(getattr(body, key) for key in ("mode", "event", "direction", "reset", "to")))
                    for name, body in file.segments.items()}  # fmt: skip
        self.check_segments(segments, resets)
        effects = {name: self.effect(name, body.set, body.drop) for name, body in file.effects.items()}
        mode, history = self.initial()
        used = self.free_symbols(modes, events, resets, period)
        self.check_time(period, used)
        self.check_unused(used, definitions)
        return Model(file.name, file.reference, tuple(file.states), dict(file.parameters), period, modes, events, resets,
                     segments, effects, tuple(self.delays), tuple(self.delayed), mode, history, definitions)  # fmt: skip

    def check_names(self) -> None:
        owner: dict[str, str] = {}
        groups: Iterable[tuple[str, Iterable[str]]] = (
            ("states", self.file.states), ("parameters", self.file.parameters), ("definitions", self.file.definitions))
        for group, names in groups:
            for i, name in enumerate(names):
                path = (group, i) if group == "states" else (group, name)
                if name in owner:
                    self.complain(path, f"'{name}' stands already among the {owner[name]}; rename one", key=True)
                owner[name] = group

    def positive(self, path: KeyPath, text: str | float, what: str, *, zero: bool = False) -> sympy.Expr:
        known = len(self.problems)
        expr = self.expression(path, text, self.parameter_scope)
        if len(self.problems) > known:
            return expr
        self.check_sign(path, expr, what, zero=zero)
        return expr

    def check_sign(self, path: KeyPath, expr: sympy.Expr, what: str, *, zero: bool) -> None:
        value = self.value_of(expr)
        if value is None:
            self.complain(path, f"{what} is not a real number at the given parameters")
        elif value < 0 or (value == 0 and not zero):
            self.complain(path, f"{what} is {value:g} at the given parameters; expected a {'non-negative' if zero else 'positive'} "
                                "number")  # fmt: skip

    def value_of(self, expr: sympy.Expr) -> float | None:
        try:
            return float(expr.evalf(17, subs=self.numbers))
        except (TypeError, ValueError):
            return None

    def delayed_value(self, state: str, delay: sympy.Expr) -> sympy.Expr:
        """Return the symbol for ``state(t - delay)`` and note the delay."""
        if delay == 0:
            return symbol(state)
        strangers = sorted(s.name for s in delay.free_symbols if s not in self.numbers)
        if strangers:
            raise ExpressionError(f"a delay is an expression in parameters, but this one holds {', '.join(strangers)}")
        value = self.value_of(delay)
        if value is None or value < 0:
            shown = "not a real number" if value is None else f"{value:g}"
            raise ExpressionError(f"the delay {delay} is {shown} at the given parameters; a delay is positive or zero "
                                  "(a value in the future cannot be read)")  # fmt: skip
        if delay not in self.delays:
            self.delays.append(delay)
        pair = (self.file.states.index(state), self.delays.index(delay))
        if pair not in self.delayed:
            self.delayed.append(pair)
        return delayed_symbol(state, delay)

    def definitions(self, base: Mapping[str, sympy.Expr]) -> dict[str, sympy.Expr]:
        """Return the definitions, in any order of writing, each expanded to states and parameters."""
        texts = self.file.definitions
        place_holders = {name: symbol(name) for name in texts}
        scope = Scope({**base, **place_holders}, states=self.file.states, delayed=self.delayed_value, place="a definition")
        raw = {name: self.expression(("definitions", name), text, scope) for name, text in texts.items()}
        done: dict[str, sympy.Expr] = {}

        def expand(name: str, above: tuple[str, ...]) -> sympy.Expr:
            if name in above:
                if name not in done:
                    self.complain(("definitions", name), f"'{name}' is defined by itself: {' -> '.join((*above, name))}", key=True)
                return sympy.Integer(0)
            if name not in done:
                inner = [n for n in texts if symbol(n) in raw[name].free_symbols]
                done_here = raw[name].subs({symbol(n): expand(n, (*above, name)) for n in inner})
                done[name] = done_here
            return done[name]

        return {name: expand(name, ()) for name in texts}

    def mode(self, name: str, body: Mapping[str, str | float]) -> tuple[sympy.Expr, ...]:
        path = ("modes", name)
        wanted = {f"{state}'": state for state in self.file.states}
        for key in body:
            if key not in wanted:
                hint = f"; write {key}'" if key in self.file.states else suggest(key, wanted)
                self.complain((*path, key), f"'{key}' is not the derivative of a state{hint} "
                                            f"(states: {', '.join(self.file.states)})", key=True)  # fmt: skip
        for key in wanted:
            if key not in body:
                self.complain(path, f"mode '{name}' does not say what {key} is; every mode gives the derivative of every state",
                              key=True)  # fmt: skip
        return tuple(self.expression((*path, key), body[key], self.scope) if key in body else sympy.Integer(0) for key in wanted)

    def event(self, name: str, body: Any) -> Event:
        path = ("events", name)
        if isinstance(body, DelayedEvent):
            delay = self.positive((*path, "delay"), body.delay, "the delay of this event", zero=True)
            source = self.file.events.get(body.after)
            if source is None:
                self.complain((*path, "after"), f"event '{body.after}' is not defined{suggest(body.after, self.file.events)}")
            elif body.after == name:
                self.complain((*path, "after"), f"event '{name}' cannot come after itself")
            return Event(name, None, body.after, delay)
        return Event(name, self.expression(path, body, self.scope))

    def reset(self, name: str, body: Mapping[str, str | float]) -> tuple[sympy.Expr, ...]:
        path = ("resets", name)
        for key in body:
            if key not in self.file.states:
                self.complain((*path, key), f"reset '{name}' sets '{key}', which is not a state{suggest(key, self.file.states)} "
                                            f"(states: {', '.join(self.file.states)})", key=True)  # fmt: skip
        return tuple(self.expression((*path, s), body[s], self.scope) if s in body else symbol(s) for s in self.file.states)

    def check_segments(self, segments: Mapping[str, Segment], resets: Mapping[str, Any]) -> None:
        file = self.file
        for name, segment in segments.items():
            for key, value, known, what in (
                ("mode", segment.mode, file.modes, "runs in mode"), ("event", segment.event, file.events, "ends at event"),
                ("reset", segment.reset, resets, "applies reset"), ("to", segment.to, file.modes, "leads to mode"),
            ):  # fmt: skip
                if value not in known:
                    kind = what.split()[-1]
                    self.complain(("segments", name, key), f"segment '{name}' {what} '{value}', which is not defined "
                                                           f"({kind}s: {', '.join(known) or 'none'}){suggest(value, known)}")  # fmt: skip
        used = {s.event for s in segments.values()} | {e.after for e in file.events.values() if isinstance(e, DelayedEvent)}
        for name in file.events:
            if name not in used:
                self.complain(("events", name), f"event '{name}' ends no segment; add a segment with 'event: {name}' or remove it",
                              key=True)  # fmt: skip
        if not segments and len(file.modes) > 1:
            self.complain(("modes",), f"{len(file.modes)} modes but no segments lead from one to another; add segments", key=True)
        for name in file.resets:
            if name != IDENTITY and name not in {s.reset for s in segments.values()}:
                self.warn(("resets", name), f"reset '{name}' is not used by any segment")
        reached = {s.to for s in segments.values()} | {str(file.initial.get("mode", next(iter(file.modes))))}
        for name in file.modes:
            if name not in reached:
                self.warn(("modes", name), f"no segment leads to mode '{name}'")

    def effect(self, name: str, values: Mapping[str, str | float], drop: Sequence[str]) -> Effect:
        path = ("effects", name)
        for key in values:
            if key not in self.file.parameters:
                self.complain((*path, "set", key), f"'{key}' is not a parameter{suggest(key, self.file.parameters)}", key=True)
        for i, event in enumerate(drop):
            if event not in self.file.events:
                self.complain((*path, "drop", i), f"event '{event}' is not defined{suggest(event, self.file.events)}")
        return Effect({key: self.expression((*path, "set", key), v, self.parameter_scope) for key, v in values.items()}, tuple(drop))

    def initial(self) -> tuple[str, tuple[sympy.Expr, ...]]:
        given = self.file.initial
        first = next(iter(self.file.modes))
        mode = given.get("mode", first)
        if mode not in self.file.modes:
            self.complain(("initial", "mode"), f"mode '{mode}' is not defined (modes: {', '.join(self.file.modes)})")
        for key in given:
            if key != "mode" and key not in self.file.states:
                self.complain(("initial", key), f"'{key}' is not a state{suggest(key, self.file.states)}", key=True)
        scope = Scope(self.parameter_scope.symbols, place="the initial history")
        history = (self.expression(("initial", s), given[s], scope) if s in given else sympy.Integer(0) for s in self.file.states)
        return str(mode), tuple(history)

    @staticmethod
    def free_symbols(modes: Mapping[str, Any], events: Mapping[str, Event], resets: Mapping[str, Any],
                     period: sympy.Expr | None) -> dict[KeyPath, set[sympy.Symbol]]:  # fmt: skip
        """Return the symbols in each expression of the model, by the path of the expression's mapping."""
        used: dict[KeyPath, set[sympy.Symbol]] = {}
        for group, members in (("modes", modes), ("resets", resets)):
            for name, exprs in members.items():
                used[(group, name)] = set().union(*(e.free_symbols for e in exprs))
        for name, event in events.items():
            used[("events", name)] = set().union(*(e.free_symbols for e in (event.function, event.delay) if e is not None))
        used[("forcing",)] = set(period.free_symbols) if period is not None else set()
        return used

    def check_time(self, period: sympy.Expr | None, used: Mapping[KeyPath, set[sympy.Symbol]]) -> None:
        where = [path for path, symbols in used.items() if TIME in symbols]
        if where and period is None and not self.file.forcing:
            group, name = where[0]
            self.complain(where[0], f"'t' appears in {group} '{name}' but the model has no 'forcing'; add "
                                    "'forcing: {period: ...}' with the period of what depends on t", key=True)  # fmt: skip
        if not where and period is not None and not self.problems:
            self.warn(("forcing",), "the model has 'forcing' but 't' appears in no mode, event or reset")

    def check_unused(self, used: Mapping[KeyPath, set[sympy.Symbol]], definitions: Mapping[str, sympy.Expr]) -> None:
        symbols = set().union(*used.values(), *(d.free_symbols for d in self.delays))
        in_effects = {name for effect in self.file.effects.values() for name in effect.set}
        for name in self.file.parameters:
            if symbol(name) not in symbols and name not in in_effects:
                self.warn(("parameters", name), f"parameter '{name}' is not used in any mode, event, reset or delay")
