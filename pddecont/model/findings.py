"""What is wrong with a model file, or strange in it, each with its place, collected while the file is read."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping, Sequence

import sympy
from sympy.logic.boolalg import Boolean

from pddecont.errors import Problem, suggest
from pddecont.model.conditions import parse_condition
from pddecont.model.document import Document, KeyPath
from pddecont.model.expression import Scope, parse_expression
from pddecont.model.syntax import ExpressionError


class Findings:
    """Problems and warnings of a document, and its texts as expressions and conditions."""

    def __init__(self, document: Document):
        self.document = document
        self.problems: list[Problem] = []
        self.warnings: list[Problem] = []

    def add_error(self, path: KeyPath, message: str, *, offset: int = 0, key: bool = False) -> None:
        """Note a problem at a place of the file."""
        self.problems.append(self.document.problem(path, message, offset=offset, key=key))

    def add_warning(self, path: KeyPath, message: str) -> None:
        """Note a warning at a place of the file."""
        self.warnings.append(self.document.problem(path, message, key=True))

    def expression(self, path: KeyPath, text: str | float, scope: Scope) -> sympy.Expr:
        """Return the expression that a text writes; note a problem and return 0 where it writes none."""
        try:
            return parse_expression(text, scope)
        except ExpressionError as exc:
            self.add_error(path, str(exc), offset=exc.offset)
            return sympy.Integer(0)

    def condition(self, path: KeyPath, text: str | float, scope: Scope) -> Boolean:
        """Return the condition that a text writes; note a problem and return one that always holds where it is none."""
        try:
            return parse_condition(text, scope)
        except ExpressionError as exc:
            self.add_error(path, str(exc), offset=exc.offset)
            return sympy.true

    @contextlib.contextmanager
    def noting(self, path: KeyPath) -> Iterator[None]:
        """Note an expression's error within the ``with`` block as a problem at a place of the file."""
        try:
            yield
        except ExpressionError as exc:
            self.add_error(path, str(exc), offset=exc.offset)

    def body(
        self, path: KeyPath, given: Mapping[str, str | float], states: Sequence[str], what: str
    ) -> list[tuple[str, str | float | None]]:
        """Return the derivatives of all states as they are given, None where one is missing; note what is wrong."""
        wanted = {f"{state}'": state for state in states}
        for key in given:
            if key not in wanted:
                hint = f"; write {key}'" if key in states else suggest(key, wanted)
                self.add_error(
                    (*path, key),
                    f"'{key}' is not the derivative of a state{hint} (states: {', '.join(states)})",
                    key=True,
                )
        for key in wanted:
            if key not in given:
                self.add_error(
                    path, f"{what} does not say what {key} is; the derivative of every state is needed", key=True
                )
        return [(key, given.get(key)) for key in wanted]

    def check_reset(self, path: KeyPath, given: Mapping[str, str | float], states: Sequence[str], what: str) -> None:
        """Note what a reset sets that is no state."""
        for key in given:
            if key not in states:
                self.add_error(
                    (*path, key),
                    f"{what} sets '{key}', which is not a state{suggest(key, states)} (states: {', '.join(states)})",
                    key=True,
                )
