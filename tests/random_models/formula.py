"""Formulas written twice: as a model file spells them, and as Python on ``t``, ``z`` and ``past(delay)``.

The second text is evaluated by Python itself; nothing of the package parses, differentiates or compiles it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

FUNCTIONS = {"cos": math.cos, "sin": math.sin, "tanh": math.tanh, "pi": math.pi}


@dataclass(frozen=True)
class Formula:
    """One formula in both spellings."""

    yaml: str
    python: str

    def __add__(self, other):
        return self._join("+", other)

    def __sub__(self, other):
        return self._join("-", other)

    def __mul__(self, other):
        return self._join("*", other)

    __rmul__ = __mul__

    def __radd__(self, other):
        return as_formula(other)._join("+", self)

    def __rsub__(self, other):
        return as_formula(other)._join("-", self)

    def __truediv__(self, other):
        return self._join("/", other)

    def __pow__(self, n):
        return Formula(f"({self.yaml})**{n}", f"({self.python})**{n}")

    def _join(self, sign, other):
        other = as_formula(other)
        return Formula(f"({self.yaml} {sign} {other.yaml})", f"({self.python} {sign} {other.python})")


def as_formula(value):
    """Return a number as a formula, a formula as it is."""
    return value if isinstance(value, Formula) else Formula(f"({value})", f"({value})")


def name(parameter):
    """Return a parameter, or ``t``."""
    return Formula(parameter, parameter)


def call(function, argument):
    """Return cos, sin or tanh of a formula."""
    return Formula(f"{function}({argument.yaml})", f"{function}({argument.python})")


@dataclass(frozen=True)
class States:
    """The states of a model by name: ``states["x"]`` now, ``states["x", "tau"]`` a delay ago."""

    names: tuple[str, ...]

    def __getitem__(self, key):
        state, delay = key if isinstance(key, tuple) else (key, None)
        i = self.names.index(state)
        if delay is None:
            return Formula(state, f"z[{i}]")
        return Formula(f"{state}(t - {delay})", f"past({delay})[{i}]")


def compile_formulas(formulas, parameters):
    """Return the function (t, z, past) -> list of the formulas' values at parameter values."""
    body = ", ".join(f.python for f in formulas)
    return eval(f"lambda t, z, past: [{body}]", {**FUNCTIONS, **parameters})


def compile_formula(formula, parameters):
    """Return the function (t, z, past) -> value of one formula."""
    return eval(f"lambda t, z, past: {formula.python}", {**FUNCTIONS, **parameters})
