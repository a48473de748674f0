"""What a model file's expressions read of the past, collected while they are read."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

import sympy

from pddecont.model.evaluation import evaluate
from pddecont.model.expression import TIME, Scope, translate_expression
from pddecont.model.lagged import (
    ChainRule,
    DelayedValue,
    Integral,
    arrange_delays,
    close_reads,
    list_parameter_slopes,
    make_chain_rule,
    make_delayed_symbol,
    make_integral_symbol,
    make_symbol,
)
from pddecont.model.memory import INFINITE, Memory, make_memory
from pddecont.model.syntax import ExpressionError, unmask

Made = TypeVar("Made")
WRITTEN = "integral(expression in s and x(t - s), s, low, high)"


@dataclass
class PastReads:
    """The delays, delayed values and integrals of a model while its expressions are read.

    ``numbers`` are the parameters' values, ``variables`` the symbols that change along a motion with the state they
    belong to, to which what is read is added. ``memories`` are the states that integrals over all the past become.
    """

    states: Sequence[str]
    numbers: Mapping[sympy.Symbol, float]
    variables: dict[sympy.Symbol, str]
    delays: list[sympy.Expr] = field(default_factory=list)
    delayed: list[DelayedValue] = field(default_factory=list)
    integrals: list[Integral] = field(default_factory=list)
    memories: list[Memory] = field(default_factory=list)

    def read(self, state: str, delay: sympy.Expr, derivative: int = 0) -> sympy.Expr:
        """Return the symbol for ``state(t - delay)``, or of its rate there, and note both."""
        if delay == 0 and not derivative:
            return make_symbol(state)
        self._check_delay(delay)
        if delay not in self.delays:
            self.delays.append(delay)
        read = DelayedValue(self.states.index(state), self.delays.index(delay), derivative)
        if read not in self.delayed:
            self.delayed.append(read)
        symbol = make_delayed_symbol(state, delay, derivative)
        self.variables[symbol] = state
        return symbol

    def varies(self, delay: sympy.Expr) -> bool:
        """Return whether a delay depends on more than parameters."""
        return not delay.free_symbols <= self.numbers.keys()

    def _check_delay(self, delay: sympy.Expr) -> None:
        known = {TIME, *self.variables, *self.numbers}
        strangers = sorted(s.name for s in delay.free_symbols - known)
        if strangers:
            raise ExpressionError(
                f"a delay is a smooth expression in states, t and parameters, but this one holds {', '.join(strangers)}"
            )
        if delay.free_symbols & {make_integral_symbol(integral, self.states) for integral in self.integrals}:
            raise ExpressionError("a delay cannot hold an integral; make the integral a state with an equation")
        if self.varies(delay):
            return
        value = evaluate(delay, self.numbers)
        if not math.isfinite(value) or value < 0:
            shown = f"{value:g}" if math.isfinite(value) else "not a real number"
            raise ExpressionError(
                f"the delay {delay} is {shown} at the given parameters; a delay is positive or zero "
                "(a value in the future cannot be read)"
            )

    def _check_limit(self, limit: sympy.Expr, node: ast.expr) -> None:
        if limit != 0:
            _placed(lambda: self._check_delay(limit), node)

    def list_delayed(self) -> Iterator[tuple[sympy.Symbol, tuple[str, sympy.Expr, int]]]:
        """Yield each delayed value's symbol, its state, its delay, and how often it is differentiated."""
        for read in self.delayed:
            state, delay = self.states[read.state], self.delays[read.delay]
            yield make_delayed_symbol(state, delay, read.derivative), (state, delay, read.derivative)

    def integrate(self, node: ast.Call, scope: Scope) -> sympy.Expr:
        """Return the symbol of ``integral(integrand, s, low, high)``; over all the past, what the memories make it."""
        if len(node.args) != 4 or not isinstance(node.args[1], ast.Name):
            raise ExpressionError(f"an integral is written {WRITTEN}", node.col_offset)
        name = unmask(node.args[1].id)
        if name in scope.symbols or name == "t":
            raise ExpressionError(
                f"'{name}' has a meaning of its own; choose another name for the variable of the integral",
                node.args[1].col_offset,
            )
        integrand = self._read_integrand(node.args[0], name, scope)
        low = translate_expression(node.args[2], scope)
        if _is_infinite(node.args[3]):
            return self._remember(integrand, low, node)
        high = translate_expression(node.args[3], scope)
        for limit, at in ((low, node.args[2]), (high, node.args[3])):
            self._check_limit(limit, at)
        if not self.varies(low) and not self.varies(high) and evaluate(high - low, self.numbers) < 0:
            raise ExpressionError("the integral ends before it begins at the given parameters", node.col_offset)
        return self.note(Integral(integrand, low, high))

    def _read_integrand(self, node: ast.expr, name: str, scope: Scope) -> sympy.Expr:
        """Return an integrand in t, the lag, and the states' symbols, their values at that lag."""
        lag = sympy.Symbol(f"({name})", real=True)
        past = {state: sympy.Symbol(f"{state}({name})", real=True) for state in self.states}

        def read(state: str, delay: sympy.Expr, derivative: int = 0) -> sympy.Expr:
            if delay != lag or derivative:
                raise ExpressionError(f"inside this integral states are read as {state}(t - {name})")
            return past[state]

        symbols = {**scope.symbols, name: lag}
        inner = Scope(symbols, states=self.states, delayed=read, time=False, place="an integral over the past")
        expr = translate_expression(node, inner)
        strangers = sorted(s.name for s in expr.free_symbols - {lag, *past.values(), *self.numbers})
        if strangers:
            raise ExpressionError(
                f"an integrand holds {name}, states as x(t - {name}), and parameters, but this one holds "
                f"{', '.join(strangers)}; what does not depend on {name} is a factor outside the integral",
                node.col_offset,
            )
        return expr.xreplace({lag: TIME, **{symbol: make_symbol(state) for state, symbol in past.items()}})

    def note(self, integral: Integral) -> sympy.Symbol:
        """Note an integral with all that its derivatives read; return its symbol."""
        self._add(integral)
        # Slopes of slopes are not read: functions are differentiated once.
        for _, slope in list_parameter_slopes(integral, self.states):
            self._add(slope)
        return make_integral_symbol(integral, self.states)

    def _add(self, integral: Integral) -> None:
        """Add an integral to those that are read, and what its limits read."""
        if integral in self.integrals:
            return
        self.integrals.append(integral)
        read = [name for name in self.states if make_symbol(name) in integral.integrand.free_symbols]
        self.variables[make_integral_symbol(integral, self.states)] = (read or list(self.states))[0]
        for limit in (integral.low, integral.high):
            for name in read if limit != 0 else ():
                self.read(name, limit)

    def _remember(self, integrand: sympy.Expr, low: sympy.Expr, node: ast.Call) -> sympy.Expr:
        """Return an integral over all the past in terms of states of its own."""
        if self.varies(low):
            raise ExpressionError("an integral to infinity begins at a lag of parameters", node.args[2].col_offset)
        self._check_limit(low, node.args[2])
        past = {name: self.read(name, low) for name in self.states if make_symbol(name) in integrand.free_symbols}
        made = _placed(lambda: make_memory(integrand, low, past, self.memories, self.numbers, self.states), node)
        for memory in made.memories:
            self.memories.append(memory)
            self.variables[memory.symbol] = memory.symbol.name
        return made.value

    def arrange(self) -> tuple[tuple[sympy.Expr, ...], tuple[sympy.Expr, ...], tuple[DelayedValue, ...]]:
        """Return the constant delays, those that vary, and the delayed values with all that derivatives read."""
        delays, varying, delayed = arrange_delays(self.delays, self.delayed, [self.varies(d) for d in self.delays])
        return delays, varying, close_reads(delayed, len(delays))

    def make_chain_rule(self) -> ChainRule:
        """Return how the values read change with what their delays and limits depend on."""
        delays, varying, delayed = self.arrange()
        return make_chain_rule(self.states, delays, varying, delayed, self.integrals)

    @property
    def symbols(self) -> set[sympy.Symbol]:
        """The symbols of all that is read of the past."""
        delayed = {symbol for symbol, _ in self.list_delayed()}
        return delayed | {make_integral_symbol(integral, self.states) for integral in self.integrals}

    def list_symbols(self) -> set[sympy.Symbol]:
        """Return the symbols that delays, integrals and memories hold."""
        exprs = [*self.delays, *(e for i in self.integrals for e in (i.integrand, i.low, i.high))]
        exprs += [m.equation for m in self.memories]
        return set().union(*(e.free_symbols for e in exprs))

    def evaluate_at_start(
        self, known: Mapping[sympy.Symbol, float], history: Sequence[sympy.Expr]
    ) -> dict[sympy.Symbol, float]:
        """Return the values read at t = 0, from what is known then; NaN for integrals."""
        found = {make_integral_symbol(integral, self.states): math.nan for integral in self.integrals}
        for symbol, (state, delay, derivative) in self.list_delayed():
            then = {**self.numbers, TIME: -evaluate(delay, {**known, **found})}
            past = history[self.states.index(state)]
            found[symbol] = evaluate(past.diff(TIME, derivative) if derivative else past, then)
        return found


def _is_infinite(node: ast.expr) -> bool:
    return isinstance(node, ast.Name) and unmask(node.id) in INFINITE


def _placed(make: Callable[[], Made], node: ast.expr) -> Made:
    """Return what ``make`` makes; its error is placed at ``node``."""
    try:
        return make()
    except ExpressionError as exc:
        raise ExpressionError(str(exc), node.col_offset) from exc
