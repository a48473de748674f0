"""A number that a run file writes as an expression in the parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import sympy

from pddecont.errors import RunError
from pddecont.model import ExpressionError, Model


@dataclass(frozen=True, eq=False)
class ParameterFormula:
    """An expression in the parameters of a model, as it was written and parsed; ``place`` names the file."""

    text: str | float
    expr: sympy.Expr
    model: Model
    place: str

    def evaluate(self, values: Mapping[str, float]) -> float:
        """Return the number at parameters of these ``values``.

        Raises
        ------
        RunError
            If it is none there.
        """
        try:
            return self.model.evaluate(self.expr, values)
        except ExpressionError as exc:
            raise RunError.at(self.place, 0, 0, f"'{self.text}': {exc}") from exc


def as_number(text: str) -> str | float:
    """Return text, from the command line or a key of a file, as a number where it is one."""
    try:
        return float(text)
    except ValueError:
        return text
