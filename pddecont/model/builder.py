"""From a model file to the symbolic model.

Expressions are parsed, names resolved, cross-references checked, and all problems collected.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any

import sympy

from pddecont.errors import ModelError, Problem, suggest
from pddecont.model.added_states import AddedStates
from pddecont.model.conditions import list_differences
from pddecont.model.contacts import list_refusals
from pddecont.model.delayed_drift import add_drifts
from pddecont.model.derived_modes import DerivedModes, TooManySwitchesError, make_modes
from pddecont.model.document import Document, KeyPath, parse_document, read_text
from pddecont.model.equations import check_kind, declare_switches, read_equations
from pddecont.model.evaluation import evaluate
from pddecont.model.expression import INTEGRAL, TIME, Scope
from pddecont.model.findings import Findings
from pddecont.model.initial_digits import find_start_mode
from pddecont.model.lagged import find_reading_symbols, make_symbol
from pddecont.model.names import (
    collect_from_equations,
    collect_symbols,
    find_clashes,
    find_strange_units,
    find_unused_parameters,
    list_equations,
)
from pddecont.model.nonsmooth import SwitchCollector
from pddecont.model.parts import IDENTITY, Event, Segment
from pddecont.model.past_checks import list_negative_delays, measure_rates
from pddecont.model.past_reads import PastReads
from pddecont.model.periodicity import explain_non_periodic
from pddecont.model.rest import find_resets_to_rest
from pddecont.model.schema import DelayCondition, DelayedEvent, ModelFile
from pddecont.model.segments import check_segments, make_segments
from pddecont.model.sliding import UndecidedSlidingError
from pddecont.model.syntax import find_names
from pddecont.model.system import Effect, Model
from pddecont.model.validation import validate

Exprs = tuple[sympy.Expr, ...]
# Modes, events, resets, segments, and what they were made of.
Parts = tuple[Mapping[str, Exprs], Mapping[str, Event], Mapping[str, Exprs], Mapping[str, Segment], DerivedModes | None]


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
        # What changes along a motion, with the state it belongs to.
        self.variables: dict[sympy.Symbol, str] = {}
        names = {*file.states, *file.parameters, *file.definitions}
        self.collector = SwitchCollector(
            self.variables, {*file.switches, *file.jumps}, names, lambda e: evaluate(e, self.numbers)
        )
        self.defined: dict[str, sympy.Expr] = {}
        self.numbers = {make_symbol(k): v for k, v in file.parameters.items()}
        self.past = PastReads(file.states, self.numbers, self.variables)
        # What names stand for formulas, and what conditions define.
        explicit = {name: body for name, body in file.delays.items() if not isinstance(body, DelayCondition)}
        self.formulas = {**file.definitions, **explicit}
        self.added = AddedStates(file, self.past, self)

    def build(self) -> Model | None:
        """Return the model, or None where its names clash."""
        file = self.file
        for path, message in (*find_clashes(file), *find_strange_units(file)):
            self.add_error(path, message, key=True)
        check_kind(file, self)
        if self.problems:
            return None
        parameters = {name: make_symbol(name) for name in file.parameters}
        self.parameter_scope = Scope(parameters, time=False, place="a delay or a period")
        period = None
        if file.forcing:
            period = self.positive(("forcing", "period"), file.forcing.period, "the forcing period")
        self.state_symbols = {name: make_symbol(name) for name in file.states}
        base = self.state_symbols | {name: make_symbol(name) for name in self.added.delays} | parameters
        self.variables.update({make_symbol(name): name for name in (*file.states, *self.added.delays)})
        self.base = base | {name: make_symbol(name) for name in self.formulas}
        declare_switches(file, self.scope_with, self.collector, self)
        definitions = {name: self.definition(name) for name in self.formulas}
        self.scope = self.make_scope(base | definitions, "the model")
        self.added.read_conditions(self.scope)
        parts = self.derive() if file.equations else self.parts_by_hand()
        if parts is None:
            return None
        modes, events, resets, segments, derived = parts
        effects = {name: self.effect(name, body.set, body.drop) for name, body in file.effects.items()}
        history = self.added.add_histories(self.history(), self.collector.clocks.values())
        mode = self.initial_mode(modes) if derived is None else self.start_of(derived, history)
        used = (
            collect_symbols(modes, events, resets, segments.values(), period)
            if derived is None
            else collect_from_equations(derived.equations.leave_out_contacts(), period)
        )
        chain = self.past.make_chain_rule()
        moving = {s: find_reading_symbols(s, chain) for s in chain}
        used = {path: read.union(*(moving[s] for s in read & moving.keys())) for path, read in used.items()}
        self.check_time(period, used)
        for path, message in find_unused_parameters(file, set().union(*used.values(), self.past.list_symbols())):
            self.add_warning(path, message)
        lags = [(f"the delay {delay}", delay) for delay in self.past.delays]
        if derived is None:
            self.check_repeats(period, self.list_by_hand(modes, events, resets, segments) + lags)
        else:
            self.check_repeats(period, list_equations(derived.equations.leave_out_contacts()) + lags)
        self.check_past(modes if derived is None else {"": derived.equations.field}, used, history)
        delays, varying, delayed = self.past.arrange()
        return Model(
            file.name,
            file.reference,
            (*file.states, *(symbol.name for symbol in self.list_added())),
            dict(file.parameters),
            period,
            modes,
            events,
            resets,
            segments,
            effects,
            delays,
            delayed,
            mode,
            history,
            definitions,
            units=dict(file.units),
            derived=derived,
            varying=varying,
            integrals=tuple(self.past.integrals),
        )

    def check_past(
        self, fields: Mapping[str, Exprs], used: Mapping[KeyPath, set[sympy.Symbol]], history: Exprs
    ) -> None:
        """Check that no delay reads the future at the start, and that what rates make of rates fades."""
        states = tuple(map(make_symbol, (*self.file.states, *(s.name for s in self.list_added()))))
        symbols = {delay: symbol for symbol, (_, delay, _) in self.past.list_delayed()}
        for delay, message in list_negative_delays(self.past, states, history) if not self.problems else ():
            readers = [path for path, read in used.items() if symbols[delay] in read]
            self.add_error(readers[0] if readers else ("initial",), message, key=True)
        for name, field in fields.items():
            size = measure_rates(field, self.past)
            if size >= 1.0:
                path = ("modes", name) if name else ("equations",)
                self.add_error(
                    path,
                    f"the coefficients of delayed rates add up to {size:g} at the given parameters; expected less than "
                    "1: from there on perturbations of any frequency never decay",
                    key=True,
                )

    def list_added(self) -> list[sympy.Symbol]:
        """Return the states that the model has besides those of the file."""
        return [*(clock.state for clock in self.collector.clocks.values()), *self.added.symbols]

    def make_scope(self, symbols: Mapping[str, sympy.Expr], place: str) -> Scope:
        """Return the names that an expression of the model may use; laws that are not smooth only in equations."""
        builtins = {INTEGRAL: self.past.integrate}
        scope = Scope(symbols, states=self.file.states, delayed=self.past.read, place=place, builtins=builtins)
        if not self.file.equations:
            return scope
        return replace(scope, builtins=builtins | self.collector.builtins, logical=True)

    def parts_by_hand(self) -> Parts:
        """Return modes, events, resets and segments as the file writes them."""
        file = self.file
        modes = {name: self.mode(name, body) for name, body in file.modes.items()}
        events = {name: self.event(name, body) for name, body in file.events.items()}
        resets = {name: self.reset(name, body) for name, body in file.resets.items()}
        resets.setdefault(IDENTITY, tuple(self.state_symbols.values()))
        segments = make_segments(file, self.scope, self)
        modes = {name: (*body, *self.added.make_equations(body, resets.values())) for name, body in modes.items()}
        resets = {name: (*body, *self.added.symbols) for name, body in resets.items()}
        check_segments(file, segments, resets, self)
        if not self.problems:
            states = tuple(map(make_symbol, (*file.states, *(s.name for s in self.added.symbols))))
            resets |= find_resets_to_rest(states, self.past.symbols, modes, events, resets, segments)
        return modes, events, resets, segments, None

    def derive(self) -> Parts | None:
        """Return modes, events, resets and segments made of the file's equations; None where they cannot be."""
        delays = {
            name: self.positive(("jumps", name, "delay"), body.delay, "the delay of this jump", zero=True)
            for name, body in self.file.jumps.items()
            if body.delay is not None
        }
        equations = read_equations(self.file, self.scope, self.collector, self, delays)
        if self.problems:
            return None
        resets = [jump.reset[: len(self.file.states)] for jump in equations.jumps]
        more = self.added.make_equations(equations.field[: len(self.file.states)], resets)
        equations = equations.add_states(self.added.symbols, more)
        for key, why in list_refusals(equations, self.past.symbols):
            self.add_error(("jumps", *key), why)
        if self.problems:
            return None
        try:
            derived = make_modes(add_drifts(equations, self.past))
        except (UndecidedSlidingError, TooManySwitchesError) as exc:
            self.add_error(("equations",), str(exc), key=True)
            return None
        return (*derived.parts.values(), derived)

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

    def definition(self, name: str, above: tuple[str, ...] = ()) -> sympy.Expr:
        """Return a definition expanded to states and parameters; ``above`` are those whose texts lead to it."""
        path = ("definitions" if name in self.file.definitions else "delays", name)
        if name in above:
            if name not in self.defined:
                self.add_error(path, f"'{name}' is defined by itself: {' -> '.join((*above, name))}", key=True)
            return sympy.Integer(0)
        if name not in self.defined:
            text = self.formulas[name]
            scope = self.scope_with(text, "a definition", (*above, name))
            self.defined[name] = self.expression(path, text, scope)
        return self.defined[name]

    def scope_with(self, text: str | float, place: str, above: tuple[str, ...] = ()) -> Scope:
        """Return the scope of a text that reads definitions, each expanded when it is first read."""
        read = {name: self.definition(name, above) for name in find_names(text) if name in self.formulas}
        return self.make_scope(self.base | read, place)

    def mode(self, name: str, body: Mapping[str, str | float]) -> tuple[sympy.Expr, ...]:
        """Return the vector field of a mode, one expression a state."""
        path = ("modes", name)
        return tuple(
            self.expression((*path, key), given, self.scope) if given is not None else sympy.Integer(0)
            for key, given in self.body(path, body, self.file.states, f"mode '{name}'")
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
        self.check_reset(path, body, self.file.states, f"reset '{name}'")
        changed = {s: self.expression((*path, s), body[s], self.scope) for s in self.file.states if s in body}
        return tuple(changed.get(s, symbol) for s, symbol in self.state_symbols.items())

    def effect(self, name: str, values: Mapping[str, str | float], drop: Sequence[str]) -> Effect:
        """Return what leaving an effect out changes."""
        path = ("effects", name)
        for key in values:
            if key not in self.file.parameters:
                self.add_error(
                    (*path, "set", key), f"'{key}' is not a parameter{suggest(key, self.file.parameters)}", key=True
                )
        for i, event in enumerate(drop):
            known = self.file.jumps if self.file.equations else self.file.events
            if event not in known:
                what = "jump" if self.file.equations else "event"
                self.add_error((*path, "drop", i), f"{what} '{event}' is not defined{suggest(event, known)}")
        return Effect(
            {key: self.expression((*path, "set", key), v, self.parameter_scope) for key, v in values.items()},
            tuple(drop),
        )

    def initial_mode(self, modes: Collection[str]) -> str:
        """Return the initial mode of a model by hand: the first one unless the file names another."""
        mode = str(self.file.initial.get("mode", next(iter(modes), "")))
        if mode not in modes:
            self.add_error(("initial", "mode"), f"mode '{mode}' is not defined (modes: {', '.join(modes)})")
        return mode

    def start_of(self, derived: DerivedModes, history: Exprs) -> str:
        """Return the initial mode of a model given by its equations: that of the states at t = 0."""
        if "mode" in self.file.initial:
            return self.initial_mode(derived.modes)
        numbers = {**self.numbers, TIME: 0.0}
        known = dict(numbers)
        for symbol, past in zip(derived.equations.states, history, strict=True):
            known[symbol] = evaluate(past, numbers)
        known |= self.past.evaluate_at_start(known, history)
        try:
            return find_start_mode(derived, known)
        except UndecidedSlidingError as exc:
            self.add_error(("initial",), str(exc), key=True)
            return ""

    def history(self) -> Exprs:
        """Return the states for t <= 0."""
        given = self.file.initial
        for key in given:
            if key != "mode" and key not in self.file.states and key not in self.added.delays:
                self.add_error(("initial", key), f"'{key}' is not a state{suggest(key, self.file.states)}", key=True)
        scope = Scope(self.parameter_scope.symbols, place="the initial history")
        return tuple(
            self.expression(("initial", s), given[s], scope) if s in given else sympy.Integer(0)
            for s in self.file.states
        )

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

    def list_by_hand(
        self,
        modes: Mapping[str, Any],
        events: Mapping[str, Event],
        resets: Mapping[str, Any],
        segments: Mapping[str, Segment],
    ) -> list[tuple[str, sympy.Expr]]:
        """Return what the expressions of a model by hand are called, and the expressions."""
        states = [*self.file.states, *(symbol.name for symbol in self.list_added())]
        named = [
            (f"{s}' of mode '{name}'", f) for name, body in modes.items() for s, f in zip(states, body, strict=True)
        ]
        named += [(f"event '{e.name}'", e.function) for e in events.values() if e.function is not None]
        named += [
            (f"{s} of reset '{name}'", g) for name, body in resets.items() for s, g in zip(states, body, strict=True)
        ]
        return named + [
            (f"a condition of segment '{s.written}'", g) for s in segments.values() for g in list_differences(s.guard)
        ]

    def check_repeats(self, period: sympy.Expr | None, named: Sequence[tuple[str, sympy.Expr]]) -> None:
        """Check that expressions repeat after the forcing period, at the parameters' values."""
        if period is None or self.problems:
            return
        found = explain_non_periodic(named, evaluate(period, self.numbers), self.numbers)
        if found:
            self.add_error(("forcing", "period"), f"{found}; give the period of all that depends on t")
