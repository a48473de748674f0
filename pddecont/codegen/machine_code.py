"""A model's expressions as machine code that the integrator calls."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Protocol, TypeAlias
from weakref import WeakValueDictionary

import sympy
from sympy.logic.boolalg import Boolean

from pddecont.codegen.llvm_backend import compile_source
from pddecont.codegen.printer import Names, ScalarPrinter, name_symbols, print_values
from pddecont.codegen.runs import write_outputs
from pddecont.memo import cached_property
from pddecont.model import TIME, Model, find_slopes

HEADER = """from math import acos, asin, atan, atan2, cos, cosh, e, exp, log, pi, sin, sinh, sqrt, tan, tanh


def generated(which, t, x, xd, p, out):
"""
# Derivatives of the history that a chain may start from: one less than its highest Taylor order, 4.
HISTORY_ORDERS = 4

Exprs: TypeAlias = tuple[sympy.Expr, ...]
# What a function writes, by place; zeros may be left out.
Outputs: TypeAlias = Mapping[int, sympy.Expr]
Derive: TypeAlias = Callable[[Exprs], Outputs]


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

    def __init__(self, load: Callable[[list[Outputs]], int], kinds: Mapping[str, Derive]) -> None:
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
        return self._pages(self.model.state_symbols, self.model.read_symbols)

    @cached_property
    def events(self) -> Pages:
        """The event functions h, "value", and dh/dx, dh/dxd and dh/dt, "jacobian"."""
        return self._pages((*self.model.state_symbols, *self.model.read_symbols, TIME))

    @cached_property
    def resets(self) -> Pages:
        """The resets g, "value", and dg/dx, dg/dxd and dg/dt, each row by row, "jacobian"."""
        return self._pages(self.model.state_symbols, self.model.read_symbols, (TIME,))

    @cached_property
    def rules(self) -> Pages:
        """The conditions, "value": 1 where they hold, 0 elsewhere."""
        return Pages(lambda page: self._address(page, self.digits), {"value": number_outputs})

    @cached_property
    def history(self) -> int:
        """The address of the history; ``which`` is the order of its derivative."""
        exprs = self.history_exprs or self.model.history
        moving = {i: e for i, e in enumerate(exprs) if TIME in e.free_symbols}
        slopes = ({i: e.diff(TIME, k) for i, e in moving.items()} for k in range(1, HISTORY_ORDERS))
        return self._address([number_outputs(exprs), *slopes])

    def compile_cases(self, cases: Sequence[Sequence[sympy.Expr]]) -> int:
        """Return the address of a function of expressions over the model; ``which`` is the number of the case."""
        return self._address([number_outputs(exprs) for exprs in cases])

    def _pages(self, *blocks: Sequence[sympy.Symbol]) -> Pages:
        """Return functions with their derivatives in blocks of symbols, each a matrix row by row."""
        kinds: dict[str, Derive] = {"value": number_outputs, "jacobian": lambda f: self._differentiate(f, blocks)}
        return Pages(lambda page: self._address(page, self.digits), kinds)

    def _differentiate(self, exprs: Exprs, blocks: Sequence[Sequence[sympy.Symbol]]) -> Outputs:
        symbols = [symbol for block in blocks for symbol in block]
        # Where the derivatives in each symbol begin, and how far apart those of the rows are.
        ways: list[tuple[int, int]] = []
        begin = 0
        for block in blocks:
            ways += [(begin + k, len(block)) for k in range(len(block))]
            begin += len(exprs) * len(block)
        slopes = find_slopes(exprs, symbols, self.model.chain)
        places = {ways[k][0] + i * ways[k][1]: slope for (i, k), slope in slopes.items()}
        return {place: places[place] for place in sorted(places)}

    def _address(self, cases: Sequence[Outputs], digits: Sequence[sympy.Symbol] = ()) -> int:
        model = self.model
        names = name_symbols(model.state_symbols, model.read_symbols, model.parameter_symbols)
        code = load_machine_code(write_machine_source(cases, names, digits))
        self._loaded.append(code)
        return code.address


@cache
def write_rule(rule: Boolean) -> Exprs:
    """Return a condition as a number that is 1 where it holds and 0 elsewhere."""
    return (sympy.Piecewise((1, rule), (0, True)),)


def number_outputs(exprs: Sequence[sympy.Expr]) -> Outputs:
    """Return expressions by the places where they are written, one after another."""
    return dict(enumerate(exprs))


def write_machine_source(cases: Sequence[Outputs], names: Names, digits: Sequence[sympy.Symbol] = ()) -> str:
    """Return the source of a function that writes the expressions of case ``which`` to ``out``, but for zeros.

    ``digits`` are symbols that are 0 or 1: the lowest bits of ``which``, with the case above them.
    """
    own = {symbol: f"h{k}" for k, symbol in enumerate(digits)}
    printer, lines = ScalarPrinter({**names, **own}), []
    lines += [f"    {name} = float((which >> {k}) & 1)" for k, name in enumerate(own.values())]
    lines += [f"    which >>= {len(digits)}"] if digits else []
    for which, outputs in enumerate(cases):
        lines.append(f"    {'if' if which == 0 else 'elif'} which == {which}:")
        written = {place: expr for place, expr in outputs.items() if expr != 0}
        shared, values = print_values(list(written.values()), printer)
        body = [*shared, *write_outputs(zip(written, values, strict=True))]
        lines += [f"        {line}" for line in body or ["pass"]]
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
