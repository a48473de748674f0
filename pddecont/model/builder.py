"""From a model file to the symbolic model.

Expressions are parsed, names resolved, cross-references checked, and all problems collected.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import sympy

from pddecont.errors import ModelError, Problem, suggest
from pddecont.model.conditions import list_differences
from pddecont.model.document import Document, KeyPath, parse_document, read_text
from pddecont.model.evaluation import count_terms, evaluate
from pddecont.model.expression import MAX_SIZE, TIME, Scope, substitute
from pddecont.model.findings import Findings
from pddecont.model.names import collect_symbols, find_clashes, find_strange_units, find_unused_parameters
from pddecont.model.periodicity import explain_non_periodic
from pddecont.model.schema import DelayedEvent, ModelFile
from pddecont.model.segments import check_segments, make_segments
from pddecont.model.syntax import ExpressionError
from pddecont.model.system import (
    IDENTITY,
    DelayedValue,
    Effect,
    Event,
    Model,
    Segment,
    make_delayed_symbol,
    make_symbol,
)
from pddecont.model.validation import validate


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


class _Builder(Findings):
    """Collects problems while it turns a validated file into a Model."""

    def __init__(self, document: Document, file: ModelFile):
        super().__init__(document)
        self.file = file
        self.delays: list[sympy.Expr] = []
        self.delayed: list[DelayedValue] = []
        self.numbers = {make_symbol(k): v for k, v in file.parameters.items()}

    def build(self) -> Model | None:
        """Return the model, or None where its names clash."""
        file = self.file
        for path, message in (*find_clashes(file), *find_strange_units(file)):
            self.add_error(path, message, key=True)
        if self.problems:
            return None
        parameters = {name: make_symbol(name) for name in file.parameters}
        self.parameter_scope = Scope(parameters, time=False, place="a delay or a period")
        period = None
        if file.forcing:
            period = self.positive(("forcing", "period"), file.forcing.period, "the forcing period")
        base = {name: make_symbol(name) for name in file.states} | parameters
        definitions = self.definitions(base)
        self.scope = Scope(base | definitions, states=file.states, delayed=self.delayed_value, place="the model")
        modes = {name: self.mode(name, body) for name, body in file.modes.items()}
        events = {name: self.event(name, body) for name, body in file.events.items()}
        resets = {name: self.reset(name, body) for name, body in file.resets.items()}
        resets.setdefault(IDENTITY, tuple(map(make_symbol, file.states)))
        segments = make_segments(file, self.scope, self)
        check_segments(file, segments, resets, self)
        effects = {name: self.effect(name, body.set, body.drop) for name, body in file.effects.items()}
        mode, history = self.initial()
        used = collect_symbols(modes, events, resets, segments.values(), period)
        self.check_time(period, used)
        for path, message in find_unused_parameters(
            file, set().union(*used.values(), *(d.free_symbols for d in self.delays))
        ):
            self.add_warning(path, message)
        self.check_repeats(period, modes, events, resets, segments)
        return Model(
            file.name,
            file.reference,
            tuple(file.states),
            dict(file.parameters),
            period,
            modes,
            events,
            resets,
            segments,
            effects,
            tuple(self.delays),
            tuple(self.delayed),
            mode,
            history,
            definitions,
            units=dict(file.units),
        )

    def positive(self, path: KeyPath, text: str | float, what: str, *, zero: bool = False) -> sympy.Expr:
        """Return an expression in the parameters, and check that it is positive (or zero) at their values."""
        known = len(self.problems)
        expr = self.expression(path, text, self.parameter_scope)
        if len(self.problems) > known:
            return expr
        self.check_sign(path, expr, what, zero=zero)
        return expr

    def check_sign(self, path: KeyPath, expr: sympy.Expr, what: str, *, zero: bool) -> None:
        """Check the sign of an expression at the parameters' values."""
        value = self.value_of(expr)
        if value is None:
            self.add_error(path, f"{what} is not a real number at the given parameters")
        elif value < 0 or (value == 0 and not zero):
            self.add_error(
                path,
                f"{what} is {value:g} at the given parameters; expected a {'non-negative' if zero else 'positive'} "
                "number",
            )

    def value_of(self, expr: sympy.Expr) -> float | None:
        """Return an expression's value at the parameters' values; None if it is no real number."""
        result = evaluate(expr, self.numbers)
        return result if math.isfinite(result) else None

    def delayed_value(self, state: str, delay: sympy.Expr) -> sympy.Expr:
        """Return the symbol for ``state(t - delay)`` and note the delay."""
        if delay == 0:
            return make_symbol(state)
        strangers = sorted(s.name for s in delay.free_symbols if s not in self.numbers)
        if strangers:
            raise ExpressionError(f"a delay is an expression in parameters, but this one holds {', '.join(strangers)}")
        value = self.value_of(delay)
        if value is None or value < 0:
            shown = "not a real number" if value is None else f"{value:g}"
            raise ExpressionError(
                f"the delay {delay} is {shown} at the given parameters; a delay is positive or zero "
                "(a value in the future cannot be read)"
            )
        if delay not in self.delays:
            self.delays.append(delay)
        read = DelayedValue(self.file.states.index(state), self.delays.index(delay))
        if read not in self.delayed:
            self.delayed.append(read)
        return make_delayed_symbol(state, delay)

    def definitions(self, base: Mapping[str, sympy.Expr]) -> dict[str, sympy.Expr]:
        """Return the definitions, in any order of writing, each expanded to states and parameters."""
        texts = self.file.definitions
        place_holders = {name: make_symbol(name) for name in texts}
        scope = Scope(
            {**base, **place_holders}, states=self.file.states, delayed=self.delayed_value, place="a definition"
        )
        raw = {name: self.expression(("definitions", name), text, scope) for name, text in texts.items()}
        done: dict[str, sympy.Expr] = {}

        def expand(name: str, above: tuple[str, ...]) -> sympy.Expr:
            if name in above:
                if name not in done:
                    self.add_error(
                        ("definitions", name), f"'{name}' is defined by itself: {' -> '.join((*above, name))}", key=True
                    )
                return sympy.Integer(0)
            if name not in done:
                inner = {
                    make_symbol(n): expand(n, (*above, name)) for n in texts if make_symbol(n) in raw[name].free_symbols
                }
                done[name] = self.put_in(("definitions", name), raw[name], inner)
            return done[name]

        return {name: expand(name, ()) for name in texts}

    def put_in(self, path: KeyPath, expr: sympy.Expr, values: Mapping[sympy.Symbol, sympy.Expr]) -> sympy.Expr:
        """Return a definition with others put in.

        Note a problem and return 0 where it grows too large or is not finite.
        """
        try:
            if count_terms(expr, {s: count_terms(e) for s, e in values.items()}) > MAX_SIZE:
                raise ExpressionError(f"more than {MAX_SIZE} terms with the definitions put in")
            return substitute(expr, values)
        except ExpressionError as exc:
            self.add_error(path, str(exc))
            return sympy.Integer(0)

    def mode(self, name: str, body: Mapping[str, str | float]) -> tuple[sympy.Expr, ...]:
        """Return the vector field of a mode, one expression a state."""
        path = ("modes", name)
        wanted = {f"{state}'": state for state in self.file.states}
        for key in body:
            if key not in wanted:
                hint = f"; write {key}'" if key in self.file.states else suggest(key, wanted)
                self.add_error(
                    (*path, key),
                    f"'{key}' is not the derivative of a state{hint} (states: {', '.join(self.file.states)})",
                    key=True,
                )
        for key in wanted:
            if key not in body:
                self.add_error(
                    path,
                    f"mode '{name}' does not say what {key} is; every mode gives the derivative of every state",
                    key=True,
                )
        return tuple(
            self.expression((*path, key), body[key], self.scope) if key in body else sympy.Integer(0) for key in wanted
        )

    def event(self, name: str, body: Any) -> Event:
        """Return an event: a function's zero, or a moment after another event."""
        path = ("events", name)
        if isinstance(body, DelayedEvent):
            delay = self.positive((*path, "delay"), body.delay, "the delay of this event", zero=True)
            source = self.file.events.get(body.after)
            if source is None:
                self.add_error(
                    (*path, "after"), f"event '{body.after}' is not defined{suggest(body.after, self.file.events)}"
                )
            elif body.after == name:
                self.add_error((*path, "after"), f"event '{name}' cannot come after itself")
            return Event(name, None, body.after, delay)
        return Event(name, self.expression(path, body, self.scope))

    def reset(self, name: str, body: Mapping[str, str | float]) -> tuple[sympy.Expr, ...]:
        """Return a reset, one expression a state."""
        path = ("resets", name)
        for key in body:
            if key not in self.file.states:
                self.add_error(
                    (*path, key),
                    f"reset '{name}' sets '{key}', which is not a state{suggest(key, self.file.states)} "
                    f"(states: {', '.join(self.file.states)})",
                    key=True,
                )
        return tuple(
            self.expression((*path, s), body[s], self.scope) if s in body else make_symbol(s) for s in self.file.states
        )

    def effect(self, name: str, values: Mapping[str, str | float], drop: Sequence[str]) -> Effect:
        """Return what leaving an effect out changes."""
        path = ("effects", name)
        for key in values:
            if key not in self.file.parameters:
                self.add_error(
                    (*path, "set", key), f"'{key}' is not a parameter{suggest(key, self.file.parameters)}", key=True
                )
        for i, event in enumerate(drop):
            if event not in self.file.events:
                self.add_error((*path, "drop", i), f"event '{event}' is not defined{suggest(event, self.file.events)}")
        return Effect(
            {key: self.expression((*path, "set", key), v, self.parameter_scope) for key, v in values.items()},
            tuple(drop),
        )

    def initial(self) -> tuple[str, tuple[sympy.Expr, ...]]:
        """Return the initial mode and the history."""
        given = self.file.initial
        first = next(iter(self.file.modes))
        mode = given.get("mode", first)
        if mode not in self.file.modes:
            self.add_error(("initial", "mode"), f"mode '{mode}' is not defined (modes: {', '.join(self.file.modes)})")
        for key in given:
            if key != "mode" and key not in self.file.states:
                self.add_error(("initial", key), f"'{key}' is not a state{suggest(key, self.file.states)}", key=True)
        scope = Scope(self.parameter_scope.symbols, place="the initial history")
        history = (
            self.expression(("initial", s), given[s], scope) if s in given else sympy.Integer(0)
            for s in self.file.states
        )
        return str(mode), tuple(history)

    def check_time(self, period: sympy.Expr | None, used: Mapping[KeyPath, set[sympy.Symbol]]) -> None:
        """Check that t is used where there is forcing, and only there."""
        where = [path for path, symbols in used.items() if TIME in symbols]
        if where and period is None and not self.file.forcing:
            group, name = where[0]
            self.add_error(
                where[0],
                f"'t' appears in {group} '{name}' but the model has no 'forcing'; add "
                "'forcing: {period: ...}' with the period of what depends on t",
                key=True,
            )
        if not where and period is not None and not self.problems:
            self.add_warning(("forcing",), "the model has 'forcing' but 't' appears in no mode, event or reset")

    def check_repeats(
        self,
        period: sympy.Expr | None,
        modes: Mapping[str, Any],
        events: Mapping[str, Event],
        resets: Mapping[str, Any],
        segments: Mapping[str, Segment],
    ) -> None:
        """Check that the model repeats after the forcing period, at the parameters' values."""
        if period is None or self.problems:
            return
        states = self.file.states
        named = [
            (f"{s}' of mode '{name}'", f) for name, body in modes.items() for s, f in zip(states, body, strict=True)
        ]
        named += [(f"event '{e.name}'", e.function) for e in events.values() if e.function is not None]
        named += [
            (f"{s} of reset '{name}'", g) for name, body in resets.items() for s, g in zip(states, body, strict=True)
        ]
        named += [
            (f"a condition of segment '{s.written}'", g) for s in segments.values() for g in list_differences(s.guard)
        ]
        found = explain_non_periodic(named, evaluate(period, self.numbers), self.numbers)
        if found:
            self.add_error(("forcing", "period"), f"{found}; give the period of all that depends on t")
