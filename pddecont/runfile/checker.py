"""The problems of a run against its model, each at its place in the file, and the formulas in it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol, TypeAlias

import sympy

from pddecont.errors import Problem, suggest
from pddecont.model import ExpressionError, Model, Scope, parse_expression
from pddecont.runfile.durations import find_wrong_durations
from pddecont.runfile.formula import ParameterFormula

Path: TypeAlias = tuple[str | int, ...]


class ProblemMaker(Protocol):
    """Who turns a message into a problem at a place."""

    def __call__(self, path: Path, message: str, *, offset: int = 0, key: bool = False) -> Problem:
        """Return the problem at the value (or the key) at ``path``, ``offset`` characters into it."""
        ...


class Checker:
    """Collects what is wrong in a run on ``model``, and reads the formulas in it."""

    def __init__(self, model: Model, make_problem: ProblemMaker, place: str):
        self.model, self.place = model, place
        self.errors: list[Problem] = []
        self.warnings: list[Problem] = []
        self._make_problem = make_problem

    def add_error(self, path: Path, message: str, *, offset: int = 0, key: bool = False) -> None:
        """Note that something is wrong at a place in the run."""
        self.errors.append(self._make_problem(path, message, offset=offset, key=key))

    def add_warning(self, path: Path, message: str) -> None:
        """Note that something is suspicious at a place in the run."""
        self.warnings.append(self._make_problem(path, message, key=True))

    def parse(self, path: Path, text: str | float, scope: Scope) -> sympy.Expr:
        """Return the expression that ``text`` writes; 1, and a problem noted, where it writes none."""
        try:
            return parse_expression(text, scope)
        except ExpressionError as exc:
            self.add_error(path, str(exc), offset=exc.offset)
            return sympy.S.One

    def parse_formula(self, path: Path, text: str | float) -> ParameterFormula:
        """Return the number that ``text`` writes as an expression in the parameters."""
        expr = self.parse(path, text, self.model.parameter_scope("a run file"))
        return ParameterFormula(text, expr, self.model, self.place)

    def evaluate(self, path: Path, text: str | float, values: Mapping[str, float]) -> float:
        """Return the number that a formula stands for; 1, and a problem noted, where it stands for none."""
        return self.evaluate_formula(path, self.parse_formula(path, text), values)

    def evaluate_formula(self, path: Path, formula: ParameterFormula, values: Mapping[str, float]) -> float:
        """Return the number that a formula stands for; 1, and a problem noted, where it stands for none."""
        try:
            return self.model.evaluate(formula.expr, values)
        except ExpressionError as exc:
            self.add_error(path, str(exc), offset=exc.offset)
            return 1.0

    def check_settable(self, path: Path, name: str, *, key: bool = True) -> bool:
        """Return whether a name is a parameter that can be given a value; note a problem where it is none."""
        known = self.model.parameters
        if name not in known:
            self.add_error(
                path, f"'{name}' is not a parameter{suggest(name, known)} (parameters: {', '.join(known)})", key=key
            )
        elif name in self.model.fixed:
            self.add_error(path, explain_fixed(self.model, name), key=key)
        return name in known and name not in self.model.fixed

    def check_durations(self, path: Path, values: Mapping[str, float]) -> None:
        """Check that delays and the forcing period are lengths of time at some parameters."""
        for message, _ in find_wrong_durations(self.model, values):
            self.add_error(path, message)


def explain_fixed(model: Model, name: str) -> str:
    """Return why a parameter cannot be given."""
    reason = model.left_out.reasons["parameters"][name]
    return f"'{name}' is {reason}; keep the effect, or leave '{name}' as it is"
