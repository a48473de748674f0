"""Monitor functions: numbers recorded at every point, written as expressions over measures of the orbit."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

import numpy as np
import sympy

from pddecont.codegen import ArrayFunction, NumericModel, ParameterFunction
from pddecont.model import ExpressionError, Model, Scope, UndefinedNameError, parse_expression, translate_expression
from pddecont.orbit.measures import (
    measure_amplitude,
    measure_approach,
    measure_at,
    measure_maximum,
    measure_mean,
    measure_minimum,
    measure_time_in,
)
from pddecont.orbit.orbit import Orbit

Measure: TypeAlias = Callable[[Orbit], float]
ALONG = {"min": measure_minimum, "max": measure_maximum, "mean": measure_mean, "amplitude": measure_amplitude}


@dataclass(frozen=True, eq=False)
class Monitor:
    """A named expression over measures of an orbit and parameters."""

    name: str
    measures: tuple[Measure | None, ...]
    function: ParameterFunction

    def evaluate(self, orbit: Orbit) -> float:
        """Return the monitor at an orbit; NaN where a part of it is not defined."""
        parts = [0.0 if measure is None else measure(orbit) for measure in self.measures]
        return float(self.function.value(np.concatenate([orbit.parameters, parts]))[0])


def parse_monitor(
    numeric: NumericModel, name: str, text: str | float, others: Mapping[str, Monitor] | None = None
) -> Monitor:
    """Return the monitor that ``text`` writes, which may name ``others``.

    Raises
    ------
    ExpressionError
        If the text writes none, with the offset into it.
    """
    model, parser = numeric.model, _MeasureParser(numeric)
    period = parser.add(operator.attrgetter("period"))
    named = {key: parser.add(other.evaluate) for key, other in (others or {}).items()}
    scope = Scope(
        {**model.parameter_values, **named, "period": period},
        states=model.states,
        time=False,
        builtins=parser.builtins(),
        place="a monitor",
        missing=model.missing,
        no_delay_because="a state varies along the orbit: write max(...), mean(...) or at(segment, ...)",
    )
    try:
        expr = parse_expression(text, scope)
    except UndefinedNameError as exc:
        if exc.name in model.states:
            raise ExpressionError(
                f"state '{exc.name}' varies along the orbit: write max({exc.name}), mean({exc.name}), or "
                f"at(segment, {exc.name})",
                exc.offset,
            ) from exc
        raise
    function = ArrayFunction((expr,), (), (), (*model.parameter_symbols, *parser.symbols))
    pairs = zip(parser.measures, parser.symbols, strict=True)
    return Monitor(name, tuple(m if s in expr.free_symbols else None for m, s in pairs), ParameterFunction(function))


class _MeasureParser:
    """Turns calls of built-ins in a monitor's text into symbols that stand for measures."""

    def __init__(self, numeric: NumericModel):
        self.numeric, self.model = numeric, numeric.model
        self.inner = numeric.model.scope("a monitor", delayed=numeric.model.delayed_value)
        self.measures: list[Measure] = []
        self.symbols: list[sympy.Symbol] = []

    def add(self, measure: Measure) -> sympy.Symbol:
        """Return the symbol that stands for a measure."""
        self.measures.append(measure)
        self.symbols.append(sympy.Symbol(f"measure {len(self.measures)}", real=True))
        return self.symbols[-1]

    def builtins(self) -> dict[str, Callable[[ast.Call, Scope], sympy.Expr]]:
        """Return what translates a call of each built-in."""
        along = {name: self._along(reduce) for name, reduce in ALONG.items()}
        return {**along, "at": self._at, "time_in": self._time_in, "extremum": self._extremum}

    def _along(self, reduce: Callable[[Orbit, ArrayFunction], float]) -> Callable[[ast.Call, Scope], sympy.Expr]:
        def translate(node: ast.Call, _: Scope) -> sympy.Expr:
            function = self.numeric.function([translate_expression(_only_argument(node), self.inner)])
            return self.add(partial(_call, reduce, function))

        return translate

    def _at(self, node: ast.Call, _: Scope) -> sympy.Expr:
        if len(node.args) != 2:
            raise ExpressionError("at takes a segment and an expression: at(segment, expression)", node.col_offset)
        segment = _find_name(self.model, node.args[0], "segment", self.model.has_segment)
        function = self.numeric.function([translate_expression(node.args[1], self.inner)])
        return self.add(partial(_call, measure_at, segment, function))

    def _time_in(self, node: ast.Call, _: Scope) -> sympy.Expr:
        mode = _find_name(self.model, _only_argument(node), "mode", self.model.modes.__contains__)
        return self.add(partial(_call, measure_time_in, mode))

    def _extremum(self, node: ast.Call, _: Scope) -> sympy.Expr:
        event = _find_name(self.model, _only_argument(node), "event", self._has_function)
        return self.add(partial(_call, measure_approach, event))

    def _has_function(self, event: str) -> bool:
        return event in self.model.events and self.model.events[event].function is not None


def _call(measure: Callable[..., float], *arguments: object) -> float:
    """Return a measure of an orbit, the last argument; the others come first here so that it can be left open."""
    *more, orbit = arguments
    return measure(orbit, *more)


def _only_argument(node: ast.Call) -> ast.expr:
    if len(node.args) != 1:
        raise ExpressionError(f"{ast.unparse(node.func)} takes one argument, found {len(node.args)}", node.col_offset)
    return node.args[0]


def _find_name(model: Model, node: ast.expr, what: str, is_known: Callable[[str], bool]) -> str:
    # A segment's name may hold a >, which is written with blanks about it here.
    name = ast.unparse(node).replace(" ", "")
    if not is_known(name):
        known = [other for other in getattr(model, f"{what}s") if is_known(other)]
        article = "an" if what == "event" else "a"
        raise ExpressionError(
            f"'{name}' is not {article} {what}{model.hint(f'{what}s', name, known)} ({what}s: "
            f"{', '.join(known) or 'none'})",
            node.col_offset,
        )
    return name
