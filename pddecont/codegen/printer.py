"""The printer: expressions as lines of Python source, for arrays of points and for machine code.

Both kinds of source assign expressions to places in arrays, with common parts computed once, and name nothing but
arrays, functions, and the common parts c0, c1, ... They differ in the names of functions and in how fractions are
written.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import sympy
from sympy.core.relational import Relational
from sympy.printing.codeprinter import CodePrinter
from sympy.printing.numpy import NumPyPrinter
from sympy.printing.pycode import PythonCodePrinter

from pddecont.errors import PddecontError
from pddecont.model import FUNCTIONS, TIME

Symbols = Sequence[sympy.Symbol]
Names = Mapping[sympy.Symbol, str]
NOT_FINITE = (type(sympy.nan), type(sympy.zoo), type(sympy.oo))


class Printer(CodePrinter):
    """Writes expressions with symbols as places in arrays."""

    def __init__(self, names: Names) -> None:
        super().__init__({"fully_qualified_modules": False})
        self._names = names

    def write(self, expr: sympy.Expr) -> str:
        """Return an expression as source, as ``doprint`` does, which looks for what no expression of a model holds."""
        return self._names.get(expr) or str(self._print(expr))

    def _print_Symbol(self, expr: sympy.Symbol) -> str:
        return self._names.get(expr) or str(super()._print_Symbol(expr))


class ArrayPrinter(Printer, NumPyPrinter):
    """Writes functions with numpy's names."""


class ScalarPrinter(Printer, PythonCodePrinter):
    """Writes functions with the names of the module ``math``, and fractions as quotients of floats."""

    def _print_Rational(self, expr: sympy.Rational) -> str:
        return f"({expr.p}.0/{expr.q}.0)"

    # All comparisons of a condition are made: a compiler takes twice as long over skipping them.
    def _print_And(self, expr: sympy.And) -> str:
        return " & ".join(f"({self._print(part)})" for part in expr.args)

    def _print_Or(self, expr: sympy.Or) -> str:
        return " | ".join(f"({self._print(part)})" for part in expr.args)

    def _print_Not(self, expr: sympy.Not) -> str:
        return f"(True ^ ({self._print(expr.args[0])}))"


def name_symbols(states: Symbols, delayed: Symbols, parameters: Symbols) -> dict[sympy.Symbol, str]:
    """Return what each symbol is called in generated source: places in arrays, never the user's own names."""
    names = {TIME: "t"}
    for array, symbols in (("x", states), ("xd", delayed), ("p", parameters)):
        names |= {s: f"{array}[{i}]" for i, s in enumerate(symbols)}
    return names


def print_assignments(targets: Iterable[tuple[str, sympy.Expr]], printer: Printer) -> list[str]:
    """Return the lines that assign expressions to their targets, common parts first; those that are zero have none.

    Raises
    ------
    PddecontError
        If an expression is something that there is no code for.
    """
    written = [(target, expr) for target, expr in targets if expr != 0]
    lines, texts = print_values([expr for _, expr in written], printer)
    return lines + [f"{target} = {text}" for (target, _), text in zip(written, texts, strict=True)]


def print_values(exprs: Sequence[sympy.Expr], printer: Printer) -> tuple[list[str], list[str]]:
    """Return the lines that assign the common parts of expressions, and the expressions by means of these.

    Raises
    ------
    PddecontError
        If an expression is something that there is no code for.
    """
    check_codable(part for expr in exprs for part in _list_smooth_parts(expr))
    # What has no parts shares none.
    made = [expr for expr in exprs if expr.args]
    shared, reduced = sympy.cse(made, symbols=sympy.numbered_symbols("c"), order="canonical") if made else ([], [])
    left = iter(reduced)
    lines = [f"{symbol.name} = {printer.write(part)}" for symbol, part in shared]
    return lines, [printer.write(next(left) if expr.args else expr) for expr in exprs]


def _list_smooth_parts(expr: sympy.Expr) -> list[sympy.Expr]:
    """Return the expressions that a choice between numbers compares; any other expression is one itself."""
    if not isinstance(expr, sympy.Piecewise):
        return [expr]
    return [side for comparison in expr.atoms(Relational) for side in comparison.args]


def check_codable(exprs: Iterable[sympy.Expr]) -> None:
    """Raise PddecontError if an expression, or a derivative, is something that there is no code for."""
    seen: set[sympy.Basic] = set()
    for expr in exprs:
        if not expr.is_Symbol and (strange := _find_strange(expr, seen)):
            raise PddecontError(
                f"the model, or its derivative, holds {strange}, which is not a smooth function: write one mode for "
                "each side of the corner"
            )


def _find_strange(expr: sympy.Basic, seen: set[sympy.Basic]) -> str:
    """Return what there is no code for in an expression, what is not finite first; parts in ``seen`` are left out."""
    infinite, functions = [], []
    left = [expr]
    while left:
        part = left.pop()
        if part in seen:
            continue
        seen.add(part)
        left += part.args
        if isinstance(part, NOT_FINITE):
            infinite.append(str(part))
        elif isinstance(part, sympy.Function) and part.func not in FUNCTIONS:
            functions.append(str(part))
    return min(infinite or functions, default="")
