"""States that a model has besides those of its file: memories of all the past, and delays that conditions define."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence

import sympy

from pddecont.model.evaluation import evaluate
from pddecont.model.expression import Scope
from pddecont.model.findings import Findings
from pddecont.model.implicit_delays import find_delay_at_start, make_delay_equation, split_condition
from pddecont.model.lagged import make_symbol
from pddecont.model.nonsmooth import Clock
from pddecont.model.past_reads import PastReads
from pddecont.model.schema import DelayCondition, ModelFile
from pddecont.model.syntax import ExpressionError

Exprs = tuple[sympy.Expr, ...]


class AddedStates:
    """The states added to those of a ``file`` while it is read; they come after its clocks.

    ``past`` is what is read of the past, ``findings`` notes what is wrong. ``delays`` are the names of delays that
    conditions define, ``conditions`` what is zero where those hold.
    """

    def __init__(self, file: ModelFile, past: PastReads, findings: Findings):
        self.file, self.past, self.findings = file, past, findings
        self.delays = tuple(name for name, body in file.delays.items() if isinstance(body, DelayCondition))
        self.conditions: dict[str, sympy.Expr] = {}

    @property
    def symbols(self) -> tuple[sympy.Symbol, ...]:
        """Their symbols."""
        memories = (memory.symbol for memory in self.past.memories)
        return (*memories, *map(make_symbol, self.delays))

    def read_conditions(self, scope: Scope) -> None:
        """Read the conditions that define delays."""
        for name in self.delays:
            body = self.file.delays[name]
            assert isinstance(body, DelayCondition)
            path = ("delays", name, "where")
            with self.findings.noting(path):
                left, right = split_condition(body.where)
                self.conditions[name] = self.findings.expression(path, left, scope) - self.findings.expression(
                    path, right, scope
                )

    def make_equations(self, field: Sequence[sympy.Expr], resets: Collection[Sequence[sympy.Expr]]) -> Exprs:
        """Return the derivatives of the added states, where those of the file's states are ``field``.

        A condition may not jump with a state that one of the ``resets`` moves.
        """
        states = tuple(map(make_symbol, self.file.states))
        equations = [memory.equation for memory in self.past.memories]
        for name in self.delays:
            equation, condition = sympy.S.Zero, self.conditions.get(name, make_symbol(name))
            with self.findings.noting(("delays", name, "where")):
                self._check_jumps(condition, states, resets)
                equation = make_delay_equation(condition, make_symbol(name), states, field, self.past)
            equations.append(equation)
        return tuple(equations)

    def _check_jumps(
        self, condition: sympy.Expr, states: Sequence[sympy.Symbol], resets: Collection[Sequence[sympy.Expr]]
    ) -> None:
        moved = {x.name for reset in resets for x, g in zip(states, reset, strict=False) if g != x}
        read = {s.name for s in condition.free_symbols if s in states}
        read |= {state for s, (state, _, _) in self.past.list_delayed() if s in condition.free_symbols}
        if read & moved:
            raise ExpressionError(
                f"a reset moves {', '.join(sorted(read & moved))}, and with it this delay jumps; a condition reads "
                "such a state inside an integral, or the delay is written as an expression"
            )

    def add_histories(self, history: Exprs, clocks: Iterable[Clock]) -> Exprs:
        """Return the histories of all states."""
        found = [*history, *(clock.at_start for clock in clocks)]
        for memory in self.past.memories:
            with self.findings.noting(("initial",)):
                found.append(memory.at_start(self.file.states, history))
        for name in self.delays:
            condition = self.conditions.get(name, make_symbol(name))
            given = self.file.initial.get(name)
            guess = None if given is None else evaluate(sympy.sympify(float(given)), self.past.numbers)
            with self.findings.noting(("delays", name, "where")):
                by_name = dict(zip(self.file.states, history, strict=True))
                found.append(find_delay_at_start(condition, make_symbol(name), self.past, by_name, guess))
        return tuple(found)
