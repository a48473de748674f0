"""A model's expressions as machine code that the integrator calls."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import Protocol, TypeAlias
from weakref import WeakValueDictionary

import sympy
from sympy.logic.boolalg import Boolean

from pddecont.codegen.llvm_backend import compile_source
from pddecont.codegen.printer import Names, ScalarPrinter, name_symbols, print_assignments
from pddecont.model import TIME, Model, differentiate, find_reading_symbols

HEADER = """from math import acos, asin, atan, atan2, cos, cosh, e, exp, log, pi, sin, sinh, sqrt, tan, tanh


def generated(which, t, x, xd, p, out):
"""
# Derivatives of the history that a chain may start from: one less than its highest Taylor order, 4.
HISTORY_ORDERS = 4

Exprs: TypeAlias = tuple[sympy.Expr, ...]
Derive: TypeAlias = Callable[[Exprs], list[sympy.Expr]]


class MachineCode(Protocol):
    """A compiled function; its address is valid as long as this object is."""

    @property
    def address(self) -> int:
        """Where the function begins."""


class Pages:
    """Functions of one kind as machine code, page by page: what is added later does not touch what is there.

    ``kinds`` say by name what is compiled of a function: its expressions, their derivatives. A function is known by
    the number of its page and by ``which`` there.
    """

    def __init__(self, load: Callable[[list[list[sympy.Expr]]], int], kinds: Mapping[str, Derive]) -> None:
        self._load, self._kinds = load, kinds
        self._pages: list[list[Exprs]] = []
        self._places: dict[Exprs, tuple[int, int]] = {}
        self._addresses: dict[tuple[str, int], int] = {}

    def add(self, functions: Iterable[Exprs]) -> None:
        """Add those of some functions that are not there yet, as one page."""
        new = [exprs for exprs in dict.fromkeys(functions) if exprs not in self._places]
        self._places |= {exprs: (len(self._pages), which) for which, exprs in enumerate(new)}
        self._pages += [new] if new else []

    def find_place(self, exprs: Exprs) -> tuple[int, int]:
        """Return the number of a function's page, and ``which`` it is there."""
        return self._places[exprs]

    def list_addresses(self, kind: str) -> list[int]:
        """Return the address of each page's machine code, which is made when first needed."""
        for number, page in enumerate(self._pages):
            if (kind, number) not in self._addresses:
                self._addresses[kind, number] = self._load([self._kinds[kind](exprs) for exprs in page])
        return [self._addresses[kind, number] for number in range(len(self._pages))]


@dataclass(frozen=True, eq=False)
class ModelFunctions:
    """A model's functions as machine code; each is made when first needed.

    Addresses are valid as long as this object is. ``history_exprs`` replace the model's history.
    """

    model: Model
    history_exprs: tuple[sympy.Expr, ...] | None = None
    # Machine code lasts as long as these objects do.
    _loaded: list[MachineCode] = field(default_factory=list, repr=False)
    # Motions that are followed at the same time add their modes one after another.
    lock: threading.RLock = field(default_factory=threading.RLock, repr=False)

    @cached_property
    def digits(self) -> tuple[sympy.Symbol, ...]:
        """The symbols for the digits of switches: the lowest bits of ``which``, with the function's number above."""
        derived = self.model.derived
        return () if derived is None else tuple(switch.digit for switch in derived.equations.switches)

    @cached_property
    def fields(self) -> Pages:
        """The vector fields f, "value", and df/dx, row by row, then df/dxd, "jacobian"."""
        symbols = self.model.state_symbols, self.model.read_symbols
        return self._pages(lambda f: [slope for s in symbols for slope in self._matrix(f, s)])

    @cached_property
    def events(self) -> Pages:
        """The event functions h, "value", and dh/dx, dh/dxd and dh/dt, "jacobian"."""
        symbols = (*self.model.state_symbols, *self.model.read_symbols, TIME)
        return self._pages(lambda h: self._matrix(h, symbols))

    @cached_property
    def resets(self) -> Pages:
        """The resets g, "value", and dg/dx, dg/dxd and dg/dt, each row by row, "jacobian"."""
        symbols = self.model.state_symbols, self.model.read_symbols, (TIME,)
        return self._pages(lambda g: [slope for s in symbols for slope in self._matrix(g, s)])

    @cached_property
    def rules(self) -> Pages:
        """The conditions, "value": 1 where they hold, 0 elsewhere."""
        return Pages(lambda page: self._address(page, self.digits), {"value": list})

    @cached_property
    def history(self) -> int:
        """The address of the history; ``which`` is the order of its derivative."""
        exprs = self.history_exprs or self.model.history
        return self._address([[e.diff(TIME, k) if k else e for e in exprs] for k in range(HISTORY_ORDERS)])

    def compile_cases(self, cases: Sequence[Sequence[sympy.Expr]]) -> int:
        """Return the address of a function of expressions over the model; ``which`` is the number of the case."""
        return self._address(cases)

    def _pages(self, differentiate: Derive) -> Pages:
        return Pages(lambda page: self._address(page, self.digits), {"value": list, "jacobian": differentiate})

    def _matrix(self, exprs: Sequence[sympy.Expr], symbols: Sequence[sympy.Symbol]) -> list[sympy.Expr]:
        slopes: list[sympy.Expr] = []
        for expr in exprs:
            read = find_reading_symbols(expr, self.model.chain)
            slopes += [differentiate(expr, s, self.model.chain) if s in read else sympy.S.Zero for s in symbols]
        return slopes

    def _address(self, cases: Sequence[Sequence[sympy.Expr]], digits: Sequence[sympy.Symbol] = ()) -> int:
        model = self.model
        names = name_symbols(model.state_symbols, model.read_symbols, model.parameter_symbols)
        code = load_machine_code(write_machine_source(cases, names, digits))
        self._loaded.append(code)
        return code.address


@cache
def write_rule(rule: Boolean) -> Exprs:
    """Return a condition as a number that is 1 where it holds and 0 elsewhere."""
    return (sympy.Piecewise((1, rule), (0, True)),)


def write_machine_source(
    cases: Sequence[Sequence[sympy.Expr]], names: Names, digits: Sequence[sympy.Symbol] = ()
) -> str:
    """Return the source of a function that writes the expressions of case ``which`` to ``out``, but for zeros.

    ``digits`` are symbols that are 0 or 1: the lowest bits of ``which``, with the case above them.
    """
    own = {symbol: f"h{k}" for k, symbol in enumerate(digits)}
    printer, lines = ScalarPrinter({**names, **own}), []
    lines += [f"    {name} = float((which >> {k}) & 1)" for k, name in enumerate(own.values())]
    lines += [f"    which >>= {len(digits)}"] if digits else []
    for which, exprs in enumerate(cases):
        lines.append(f"    {'if' if which == 0 else 'elif'} which == {which}:")
        targets = [(f"out[{i}]", sympy.sympify(e)) for i, e in enumerate(exprs)]
        body = [f"        {line}" for line in print_assignments(targets, printer)]
        lines += body or ["        pass"]
    return HEADER + "\n".join([*lines, "    return", ""])


# The machine code that is in use, by its source: models that share a function share its code.
_in_use: WeakValueDictionary[str, MachineCode] = WeakValueDictionary()
_loading = threading.Lock()


def load_machine_code(text: str) -> MachineCode:
    """Return the machine code of a generated source; a source that is in use has its code already."""
    with _loading:
        code = _in_use.get(text)
        if code is None:
            code = _in_use[text] = compile_source(text)
        return code
