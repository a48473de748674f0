"""A model's expressions as machine code that the integrator calls; compiled once a model and kept on disk."""

from __future__ import annotations

import hashlib
import importlib.util
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numba
import sympy
from sympy.printing.pycode import PythonCodePrinter

from pddecont.model.codegen import check_codable, symbol_names
from pddecont.model.expression import TIME
from pddecont.model.system import Model
from pddecont.simulate.kernel import cache_folder
from pddecont.simulate.kernel.calls import SIGNATURE

HEADER = """from math import acos, asin, atan, atan2, cos, cosh, e, exp, log, pi, sin, sinh, sqrt, tan, tanh


def generated(which, t, x, xd, p, out):
"""


@dataclass(frozen=True, eq=False)
class ModelFunctions:
    """Addresses of a model's functions; each is made when first asked for.

    ``section`` is one more event function, numbered after the model's own; ``history`` replaces the model's.
    """

    model: Model
    section: sympy.Expr | None = None
    history_exprs: tuple[sympy.Expr, ...] | None = None

    @cached_property
    def events(self) -> tuple[sympy.Expr, ...]:
        """The event functions by number; a delayed event has none, and 1 stands in its place."""
        functions = [sympy.Integer(1) if e.function is None else e.function for e in self.model.events.values()]
        return tuple(functions if self.section is None else [*functions, self.section])

    @cached_property
    def field(self) -> int:
        """F of each mode."""
        return self._address([list(f) for f in self.model.modes.values()])

    @cached_property
    def event(self) -> int:
        """H of each event."""
        return self._address([[h] for h in self.events])

    @cached_property
    def reset(self) -> int:
        """G of each reset."""
        return self._address([list(g) for g in self.model.resets.values()])

    @cached_property
    def history(self) -> int:
        """The history at t, and its derivatives of order ``which``."""
        exprs = self.history_exprs or self.model.history
        return self._address([[e.diff(TIME, k) if k else e for e in exprs] for k in range(4)])

    @cached_property
    def field_jacobian(self) -> int:
        """df/dx, row by row, then df/dxd, of each mode."""
        return self._address([self._matrix(f, self.model.state_symbols) + self._matrix(f, self.model.delayed_symbols)
                              for f in self.model.modes.values()])  # fmt: skip

    @cached_property
    def event_jacobian(self) -> int:
        """dh/dx, dh/dxd and dh/dt of each event."""
        symbols = (*self.model.state_symbols, *self.model.delayed_symbols, TIME)
        return self._address([self._matrix([h], symbols) for h in self.events])

    @cached_property
    def reset_jacobian(self) -> int:
        """dg/dx, dg/dxd and dg/dt, each row by row, of each reset."""
        model = self.model
        return self._address([self._matrix(g, model.state_symbols) + self._matrix(g, model.delayed_symbols) + self._matrix(g, [TIME])
                              for g in model.resets.values()])  # fmt: skip

    @staticmethod
    def _matrix(exprs: Sequence[sympy.Expr], symbols: Sequence[sympy.Symbol]) -> list[sympy.Expr]:
        return [e.diff(s) for e in exprs for s in symbols]

    def _address(self, cases: Sequence[Sequence[sympy.Expr]]) -> int:
        model = self.model
        text = function_text(cases, symbol_names(model.state_symbols, model.delayed_symbols, model.parameter_symbols))
        return int(compiled(text).address)  # type: ignore[attr-defined]


class _Printer(PythonCodePrinter):
    def __init__(self, names: dict[sympy.Symbol, str]):
        super().__init__({"fully_qualified_modules": False})
        self._names = names

    def _print_Symbol(self, expr: sympy.Symbol) -> str:
        return self._names.get(expr) or str(super()._print_Symbol(expr))

    def _print_Rational(self, expr: sympy.Rational) -> str:
        return f"({expr.p}.0/{expr.q}.0)"


def function_text(cases: Sequence[Sequence[sympy.Expr]], names: dict[sympy.Symbol, str]) -> str:
    """Return the source of a function that writes the expressions of case ``which`` to ``out``; zeros are left alone."""
    check_codable(sympy.sympify(e) for exprs in cases for e in exprs)
    printer = _Printer(names)
    lines = []
    for which, exprs in enumerate(cases):
        lines.append(f"    {'if' if which == 0 else 'elif'} which == {which}:")
        shared, reduced = sympy.cse(list(exprs), symbols=sympy.numbered_symbols("c"), order="canonical")
        body = [f"        {s.name} = {printer.doprint(e)}" for s, e in shared]
        body += [f"        out[{i}] = {printer.doprint(e)}" for i, e in enumerate(reduced) if e != 0]
        lines += body or ["        pass"]
    return HEADER + "\n".join([*lines, "    return", ""])


_loaded: dict[str, Callable[..., None]] = {}


def compiled(text: str) -> Callable[..., None]:
    """Return the machine code of a generated source; the source is kept beside it, as numba's cache needs a file."""
    if text not in _loaded:
        _loaded[text] = numba.cfunc(SIGNATURE, cache=True, error_model="numpy")(_module(text).generated)
    return _loaded[text]


def _module(text: str) -> Any:
    name = "model_" + hashlib.sha256(text.encode()).hexdigest()[:24]
    path = cache_folder() / f"{name}.py"
    if not path.exists() or path.read_text() != text:
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary = path.with_name(f".{name}.{os.getpid()}.part")
        temporary.write_text(text)
        os.replace(temporary, path)
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    # numba looks up by name the module that machine code from its cache came from.
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module
