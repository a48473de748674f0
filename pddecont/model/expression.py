"""Text to sympy through a whitelist: numbers, declared names, arithmetic, a few functions, delayed values.

The text is parsed by Python's own grammar into a syntax tree and never evaluated; each node that is not on the list is
an error with its column.
"""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import sympy

from pddecont.errors import suggest
from pddecont.model.evaluation import FUNCTIONS as REAL_FUNCTIONS
from pddecont.model.evaluation import (
    apply_function,
    bound_derivative_terms,
    count_terms,
    evaluate,
    measure_depth,
    raise_power,
)
from pddecont.model.mistakes import is_infinite, is_moment, suggest_point
from pddecont.model.syntax import PRIME, ExpressionError, describe_node, parse_syntax, split_primes, unmask

MAX_LENGTH = 20_000
MAX_NODES = 5_000
MAX_DEPTH = 100
# Terms of an expression with its definitions put in, and of its derivative, when they are written out.
MAX_SIZE = 20_000
MAX_DERIVATIVE = 400_000
# Whole numbers up to here are kept exact; larger ones and fractions of larger ones become doubles.
EXACT = 2**53

FUNCTIONS: dict[str, tuple[Callable[..., sympy.Expr], int]] = {
    "sin": (sympy.sin, 1),
    "cos": (sympy.cos, 1),
    "tan": (sympy.tan, 1),
    "asin": (sympy.asin, 1),
    "acos": (sympy.acos, 1),
    "atan": (sympy.atan, 1),
    "atan2": (sympy.atan2, 2),
    "sinh": (sympy.sinh, 1),
    "cosh": (sympy.cosh, 1),
    "tanh": (sympy.tanh, 1),
    "exp": (sympy.exp, 1),
    "log": (sympy.log, 1),
    "sqrt": (sympy.sqrt, 1),
}
NONSMOOTH = {"abs", "sign", "sgn", "heaviside", "Heaviside", "min", "max", "Min", "Max", "Abs", "floor", "ceil", "mod"}
# The integral over the past, of which no delay is made.
INTEGRAL = "integral"
IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\Z")
TIME = sympy.Symbol("t", real=True)
PI_NAME = "pi"


class UndefinedNameError(ExpressionError):
    """An expression mentions a ``name`` that stands for nothing."""

    def __init__(self, name: str, message: str, offset: int):
        self.name = name
        super().__init__(message, offset)


Builtin = Callable[["ast.Call", "Scope"], sympy.Expr]


@dataclass(frozen=True)
class Scope:
    """What an expression may mention.

    ``symbols`` maps names to what they stand for; ``delayed(state, delay, derivative)`` returns the symbol of a delayed
    value or rate, or is None where delays are not allowed; ``time`` says whether ``t`` may appear; ``builtins`` are
    functions of syntax nodes (of monitors, of laws that are not smooth); ``place`` names the scope in messages;
    ``missing`` says why a name that once was there is not any more; ``logical`` says whether conditions may stand among
    arguments.
    """

    symbols: Mapping[str, sympy.Expr]
    states: Collection[str] = ()
    delayed: Callable[[str, sympy.Expr, int], sympy.Expr] | None = None
    time: bool = True
    builtins: Mapping[str, Builtin] = field(default_factory=dict)
    place: str = "this expression"
    no_delay_because: str = "delayed values are not allowed here"
    missing: Callable[[str], str] = lambda _: ""
    logical: bool = False


def parse_expression(text: str | float | int, scope: Scope) -> sympy.Expr:
    """Return the sympy expression that ``text`` writes; raise :class:`ExpressionError` with an offset into it."""
    if isinstance(text, bool):
        raise ExpressionError("expected an expression, found true/false")
    if isinstance(text, int | float):
        return _number(text)
    if is_infinite(text) and text not in scope.symbols:
        raise ExpressionError(f"expected a finite number, found '{text.strip()}'")
    if len(text) > MAX_LENGTH:
        raise ExpressionError(f"the expression has {len(text)} characters; at most {MAX_LENGTH} are read")
    if any(not c.isprintable() and c not in "\n\t" for c in text) and text.isascii():
        offset = next(i for i, c in enumerate(text) if not c.isprintable() and c not in "\n\t")
        raise ExpressionError(f"character {text[offset]!r} is not allowed", offset)
    if not text.isascii():
        offset = next(i for i, c in enumerate(text) if not c.isascii())
        raise ExpressionError(f"character '{text[offset]}' is not allowed; write names in plain letters", offset)
    hint = suggest_point(text)
    if hint:
        raise ExpressionError(f"'{text.strip()}' is not a number{hint}")
    tree = parse_syntax(text, logical=scope.logical)
    return translate_expression(tree, scope)


def translate_expression(node: ast.expr, scope: Scope) -> sympy.Expr:
    """Return the sympy expression of a syntax node (used by built-in functions for their arguments)."""
    return require_finite(_Translator(scope).visit(node, 0))


def require_finite(expr: sympy.Expr) -> sympy.Expr:
    """Return ``expr`` with moderate numbers and the functions that there is code for.

    Raise :class:`ExpressionError` if it is not finite and real.
    """
    if expr.has(sympy.zoo, sympy.nan, sympy.oo, -sympy.oo):
        raise ExpressionError("the expression is not finite (a division by zero, or a number too large)")
    large = {n: _moderate(n) for n in expr.atoms(sympy.Rational) if _moderate(n) is not n}
    expr = expr.xreplace(large) if large else expr
    expr = expr.replace(sympy.cot, lambda a: 1 / sympy.tan(a))
    if expr.has(sympy.I) or any(f.func not in REAL_FUNCTIONS for f in expr.atoms(sympy.Function)):
        raise ExpressionError("the expression is not a real number wherever its parts are")
    if count_terms(expr) > MAX_SIZE or measure_depth(expr) > MAX_DEPTH:
        raise ExpressionError(
            f"the expression has more than {MAX_SIZE} terms or {MAX_DEPTH} levels with its definitions put in"
        )
    if bound_derivative_terms(expr) > MAX_DERIVATIVE:
        raise ExpressionError(
            f"the expression's derivative has more than {MAX_DERIVATIVE} terms; make products of fewer factors"
        )
    return expr


def make_power(a: sympy.Expr, b: sympy.Expr) -> sympy.Expr:
    """Return a power; that of two numbers in doubles, so that 9**9**9 cannot fill the memory with digits."""
    if a == 0 and not b.is_number:
        raise ExpressionError("a power of 0 whose exponent varies is not smooth")
    if not (a.is_number and b.is_number):
        return a**b
    result = raise_power(evaluate(a), evaluate(b))
    if not math.isfinite(result):
        raise ExpressionError("this power is not a finite real number")
    if a.is_Integer and b.is_Integer and abs(result) < EXACT:
        return a**b  # small whole numbers stay exact
    return _number(result)


def apply_symbolic(function: Any, args: Sequence[sympy.Expr]) -> sympy.Expr:
    """Return a function of expressions; that of numbers only if it is a finite real number."""
    if all(a.is_number for a in args):
        numbers = [evaluate(a) for a in args]
        result = raise_power(numbers[0], 0.5) if function is sympy.sqrt else apply_function(function, numbers)
        if not math.isfinite(result):
            raise ExpressionError("this is not a finite real number")
    return function(*args)


def substitute(expr: sympy.Expr, values: Mapping[sympy.Symbol, sympy.Expr]) -> sympy.Expr:
    """Return ``expr`` with expressions in the place of symbols.

    Raise :class:`ExpressionError` where it is no longer finite.
    """
    known: dict[sympy.Basic, sympy.Basic] = dict(values)

    def put(e: sympy.Basic) -> sympy.Basic:
        if e not in known:
            args = [put(a) for a in e.args]
            if all(a is b for a, b in zip(args, e.args, strict=True)):
                known[e] = e
            elif e.is_Pow:
                known[e] = make_power(*args)
            else:
                known[e] = apply_symbolic(e.func, args) if e.func in REAL_FUNCTIONS else e.func(*args)
        return known[e]

    return require_finite(put(expr))


def _moderate(number: sympy.Rational) -> sympy.Expr:
    """Return a number that a double can hold as one."""
    if max(abs(number.p), number.q) <= EXACT:
        return number
    return _number(evaluate(number))


def _number(number: float) -> sympy.Expr:
    if isinstance(number, int) and abs(number) < EXACT:
        return sympy.Integer(number)
    try:
        number = float(number)
    except OverflowError:
        number = math.inf
    if math.isnan(number):
        raise ExpressionError("expected a finite number, found 'nan'")
    if math.isinf(number):
        raise ExpressionError("the number is infinite, or too large for double precision")
    return sympy.Float(number, 17)


class _Translator:
    def __init__(self, scope: Scope):
        self.scope = scope
        self.count = self.size = 0

    def visit(self, node: ast.expr, depth: int) -> sympy.Expr:
        """Return the expression of a syntax node."""
        self.count += 1
        if self.count > MAX_NODES or depth > MAX_DEPTH:
            raise ExpressionError(
                f"more than {MAX_NODES} terms or {MAX_DEPTH} levels; use definitions", node.col_offset
            )
        if isinstance(node, ast.Constant):
            if isinstance(node.value, bool) or not isinstance(node.value, int | float):
                raise ExpressionError(f"{node.value!r} is not a number", node.col_offset)
            try:
                return _number(node.value)
            except ExpressionError as exc:
                raise ExpressionError(str(exc), node.col_offset) from exc
        if isinstance(node, ast.Name):
            return self.name(node)
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.UAdd | ast.USub):
            value = self.visit(node.operand, depth + 1)
            return -value if isinstance(node.op, ast.USub) else value
        if isinstance(node, ast.BinOp):
            return self.binary(node, depth)
        if isinstance(node, ast.Call):
            return self.call(node, depth)
        raise ExpressionError(
            f"{describe_node(node)} is not allowed; an expression holds numbers, names, + - * / **, parentheses and "
            f"functions ({' '.join(FUNCTIONS)})",
            node.col_offset,
        )

    def name(self, node: ast.Name) -> sympy.Expr:
        """Return what a name stands for."""
        name = unmask(node.id)
        if name in self.scope.symbols:
            found = self.scope.symbols[name]
            self.size += count_terms(found)
            if self.size > MAX_SIZE:
                raise ExpressionError(f"more than {MAX_SIZE} terms with the definitions put in", node.col_offset)
            return found
        if name == "t":
            if not self.scope.time:
                raise ExpressionError(f"'t' is not allowed in {self.scope.place}", node.col_offset)
            return TIME
        if name == PI_NAME:
            return sympy.pi
        if name in FUNCTIONS or name in self.scope.builtins:
            raise ExpressionError(f"'{name}' is a function: write {name}(...)", node.col_offset)
        known = [*self.scope.symbols, "t", PI_NAME] if self.scope.time else [*self.scope.symbols, PI_NAME]
        listed = ", ".join(sorted(self.scope.symbols)[:12])
        hint = self.scope.missing(name) or suggest(name, known) or f" (known: {listed})"
        raise UndefinedNameError(name, f"'{name}' is not defined{hint}", node.col_offset)

    def binary(self, node: ast.BinOp, depth: int) -> sympy.Expr:
        """Return what an operator makes of two expressions."""
        if isinstance(node.op, ast.BitXor):
            raise ExpressionError("'^' is not a power here; write **", node.col_offset)
        a, b = self.visit(node.left, depth + 1), self.visit(node.right, depth + 1)
        if isinstance(node.op, ast.Add):
            return self.moderate(a + b, node)
        if isinstance(node.op, ast.Sub):
            return self.moderate(a - b, node)
        if isinstance(node.op, ast.Mult):
            return self.moderate(a * b, node)
        if isinstance(node.op, ast.Div):
            if b == 0:
                raise ExpressionError("division by zero", node.right.col_offset)
            return self.moderate(a / b, node)
        if isinstance(node.op, ast.Pow):
            return self.placed(lambda: make_power(a, b), node)
        raise ExpressionError("only + - * / and ** are allowed between terms", node.col_offset)

    def moderate(self, expr: sympy.Expr, node: ast.expr) -> sympy.Expr:
        """Return ``expr``, a fraction of large numbers as a double."""
        return self.placed(lambda: _moderate(expr), node) if isinstance(expr, sympy.Rational) else expr

    @staticmethod
    def placed(make: Callable[[], sympy.Expr], node: ast.expr) -> sympy.Expr:
        """Return what ``make`` makes; its error is placed at ``node``."""
        try:
            return make()
        except ExpressionError as exc:
            raise ExpressionError(str(exc), node.col_offset) from exc

    def call(self, node: ast.Call, depth: int) -> sympy.Expr:
        """Return a function's value, or a delayed value."""
        if not isinstance(node.func, ast.Name):
            raise ExpressionError(f"calling {describe_node(node.func)} is not allowed", node.col_offset)
        name = unmask(node.func.id)
        if node.keywords or any(isinstance(a, ast.Starred) for a in node.args):
            raise ExpressionError(f"{name}(...) takes plain arguments only", node.col_offset)
        state, derivative = split_primes(name)
        if state in self.scope.states:
            return self.delayed(state, derivative, node, depth)
        if name in self.scope.builtins:
            return self.scope.builtins[name](node, self.scope)
        if name in FUNCTIONS:
            function, n_args = FUNCTIONS[name]
            if len(node.args) != n_args:
                raise ExpressionError(f"{name} takes {n_args} argument(s), found {len(node.args)}", node.col_offset)
            args = [self.visit(arg, depth + 1) for arg in node.args]
            return self.placed(lambda: apply_symbolic(function, args), node)
        if name in NONSMOOTH and self.scope.place == "a delay":
            raise ExpressionError(f"'{name}' is not smooth, and a delay has to be", node.col_offset)
        if name in NONSMOOTH and not self.scope.logical:
            raise ExpressionError(
                f"'{name}' is not smooth: give the model as 'equations', where it is allowed, or write one mode for "
                "each side of its corner and an event function that is zero there",
                node.col_offset,
            )
        if name in self.scope.symbols:
            raise ExpressionError(
                f"'{name}' cannot be called: only a state can be delayed, as in x(t - tau)", node.col_offset
            )
        if self.scope.states and len(node.args) == 1 and is_moment(node.args[0]):
            hint = suggest(name, [*self.scope.states, *FUNCTIONS])
            raise ExpressionError(
                f"'{name}' is not a state and has no delayed values{hint} (states: {', '.join(self.scope.states)})",
                node.col_offset,
            )
        raise ExpressionError(
            f"unknown function '{name}'{self.scope.missing(name) or suggest(name, [*FUNCTIONS, *self.scope.builtins])}",
            node.col_offset,
        )

    def delayed(self, state: str, derivative: int, node: ast.Call, depth: int) -> sympy.Expr:
        """Return a delayed value, or rate."""
        written = f"{state}{derivative * PRIME}(t - delay)"
        if len(node.args) != 1:
            raise ExpressionError(f"a delayed value is written {written}", node.col_offset)
        if self.scope.delayed is None:
            raise ExpressionError(self.scope.no_delay_because, node.col_offset)
        if derivative > 1:
            raise ExpressionError(
                f"{written} is a second derivative; only values and first derivatives can be delayed", node.col_offset
            )
        symbols = {**self.scope.symbols, "t": TIME}
        integral = {name: builtin for name, builtin in self.scope.builtins.items() if name == INTEGRAL}
        inner = replace(self.scope, symbols=symbols, time=True, builtins=integral, place="a delay")
        argument = _Translator(inner).visit(node.args[0], depth + 1)
        delay = sympy.expand(TIME - argument)
        if derivative and delay == 0:
            raise ExpressionError(
                f"{state}'(t) is the derivative at the present time; write what it is equal to", node.col_offset
            )
        try:
            return self.scope.delayed(state, delay, derivative)
        except ExpressionError as exc:
            raise ExpressionError(str(exc), node.args[0].col_offset) from exc
