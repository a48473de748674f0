"""A model's expressions as machine code that the integrator calls; compiled once a model and kept on disk."""

from __future__ import annotations

import hashlib
import importlib.util
import os
import sys
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from pathlib import Path
from typing import Any, Protocol, cast
from weakref import WeakValueDictionary

import sympy
from numba import cfunc, types
from sympy.logic.boolalg import Boolean

from pddecont.codegen.cache import find_cache_folder
from pddecont.codegen.compilation import compiler_settings
from pddecont.codegen.printer import Names, ScalarPrinter, name_symbols, print_assignments
from pddecont.model import ABOVE, ON, TIME, Model, Segment, write_repulsions

_make_pointer: Callable[[Any], Any] = types.CPointer
DOUBLE_POINTER = _make_pointer(types.float64)
# void f(which, t, x, xd, p, out): ``which`` numbers the mode, event or reset.
SIGNATURE = types.void(types.int64, types.float64, DOUBLE_POINTER, DOUBLE_POINTER, DOUBLE_POINTER, DOUBLE_POINTER)
HEADER = """from math import acos, asin, atan, atan2, cos, cosh, e, exp, log, pi, sin, sinh, sqrt, tan, tanh


def generated(which, t, x, xd, p, out):
"""
# Derivatives of the history that a chain may start from: one less than its highest Taylor order, 4.
HISTORY_ORDERS = 4


@dataclass(frozen=True)
class FieldCases:
    """The vector fields that machine code tells apart, and the number of each mode's: digits below, the case above."""

    fields: tuple[tuple[sympy.Expr, ...], ...]
    digits: tuple[sympy.Symbol, ...]
    of_mode: tuple[int, ...]


def find_field_cases(model: Model) -> FieldCases:
    """Return the vector fields of a model; of equations one for all modes that slide along the same surfaces."""
    derived = model.derived
    if derived is None:
        return FieldCases(tuple(model.modes.values()), (), tuple(range(len(model.modes))))
    digits = tuple(switch.digit for switch in derived.equations.switches)
    cases: dict[tuple[int, ...], int] = {}
    of_mode = []
    for mode in model.modes:
        own = derived.equations.find_digits(mode) or ()
        on = tuple(k for k, d in enumerate(own) if d == ON)
        bits = sum(1 << k for k, d in enumerate(own) if d == ABOVE)
        of_mode.append(cases.setdefault(on, len(cases)) << len(digits) | bits)
    return FieldCases(tuple(map(derived.slide, cases)), digits, tuple(of_mode))


def _rule_of(segment: Segment) -> Boolean:
    return segment.guard if segment.rule is None else segment.rule


def _write_indicator(condition: Boolean) -> sympy.Expr:
    """Return the number that is 1 where a condition holds and 0 elsewhere."""
    return sympy.Piecewise((1, condition), (0, True))


class MachineCode(Protocol):
    """A compiled function; its address is valid as long as this object is."""

    @property
    def address(self) -> int:
        """Where the function begins."""


@dataclass(frozen=True, eq=False)
class ModelFunctions:
    """Addresses of a model's functions as machine code; each is made when first needed.

    They are valid as long as this object is. ``section`` is one more event function, numbered after the model's own;
    ``history_exprs`` replace the model's history.
    """

    model: Model
    section: sympy.Expr | None = None
    history_exprs: tuple[sympy.Expr, ...] | None = None
    # Machine code lasts as long as these objects do.
    _loaded: list[MachineCode] = field(default_factory=list, repr=False)

    @cached_property
    def events(self) -> tuple[sympy.Expr, ...]:
        """The event functions by number; a delayed event has none, and 1 is in its place."""
        functions = [sympy.Integer(1) if e.function is None else e.function for e in self.model.events.values()]
        return tuple(functions if self.section is None else [*functions, self.section])

    @cached_property
    def cases(self) -> FieldCases:
        """The vector fields as the machine code numbers them."""
        return find_field_cases(self.model)

    @cached_property
    def field(self) -> int:
        """The address of f; ``which`` is the case of the mode."""
        return self._address([list(f) for f in self.cases.fields], self.cases.digits)

    @cached_property
    def event(self) -> int:
        """The address of h; ``which`` is the event."""
        return self._address([[h] for h in self.events])

    @cached_property
    def reset(self) -> int:
        """The address of g; ``which`` is the reset."""
        return self._address([list(g) for g in self.model.resets.values()])

    @cached_property
    def guard_numbers(self) -> tuple[int, ...]:
        """What each segment's condition is known by: its number among those that differ, with the digits below."""
        numbers = {rule: number for number, rule in enumerate(self._rules)}
        own, shift = self._digits, len(self.cases.digits)
        return tuple(numbers[_rule_of(s)] << shift | own.get(s.to, 0) for s in self.model.segments.values())

    @cached_property
    def guard(self) -> int:
        """The address of the conditions, 1 where they hold; ``which`` is their number. 0 if there are none."""
        if all(rule == sympy.true for rule in self._rules):
            return 0
        return self._address([[_write_indicator(rule)] for rule in self._rules], self.cases.digits)

    @cached_property
    def _rules(self) -> list[Boolean]:
        return list(dict.fromkeys(map(_rule_of, self.model.segments.values())))

    @cached_property
    def repulsion_numbers(self) -> tuple[int, ...]:
        """What the condition is known by that a surface repels the motion after each segment; -1 without one."""
        numbers = {rule: number for number, rule in enumerate(self._differing_repulsions)}
        own, shift = self._digits, len(self.cases.digits)
        return tuple(
            numbers[rule] << shift | own[segment.to] if rule in numbers else -1
            for segment, rule in zip(self.model.segments.values(), self._repulsions, strict=True)
        )

    @cached_property
    def repulsion(self) -> int:
        """The address of the conditions under which a surface repels a motion on it. 0 if there are none."""
        if not self._differing_repulsions:
            return 0
        return self._address([[_write_indicator(rule)] for rule in self._differing_repulsions], self.cases.digits)

    @cached_property
    def _repulsions(self) -> list[Boolean]:
        return write_repulsions(self.model)

    @cached_property
    def _differing_repulsions(self) -> list[Boolean]:
        return [rule for rule in dict.fromkeys(self._repulsions) if rule != sympy.false]

    @cached_property
    def _digits(self) -> dict[str, int]:
        """The digits of each mode as bits."""
        mask = (1 << len(self.cases.digits)) - 1
        return {mode: case & mask for mode, case in zip(self.model.modes, self.cases.of_mode, strict=True)}

    @cached_property
    def history(self) -> int:
        """The address of the history; ``which`` is the order of its derivative."""
        exprs = self.history_exprs or self.model.history
        return self._address([[e.diff(TIME, k) if k else e for e in exprs] for k in range(HISTORY_ORDERS)])

    @cached_property
    def field_jacobian(self) -> int:
        """The address of df/dx, row by row, then df/dxd; ``which`` is the case of the mode."""
        return self._address(
            [
                self._matrix(f, self.model.state_symbols) + self._matrix(f, self.model.delayed_symbols)
                for f in self.cases.fields
            ],
            self.cases.digits,
        )

    @cached_property
    def event_jacobian(self) -> int:
        """The address of dh/dx, dh/dxd and dh/dt; ``which`` is the event."""
        symbols = (*self.model.state_symbols, *self.model.delayed_symbols, TIME)
        return self._address([self._matrix([h], symbols) for h in self.events])

    @cached_property
    def reset_jacobian(self) -> int:
        """The address of dg/dx, dg/dxd and dg/dt, each row by row; ``which`` is the reset."""
        model = self.model
        return self._address(
            [
                self._matrix(g, model.state_symbols) + self._matrix(g, model.delayed_symbols) + self._matrix(g, [TIME])
                for g in model.resets.values()
            ]
        )

    @staticmethod
    def _matrix(exprs: Sequence[sympy.Expr], symbols: Sequence[sympy.Symbol]) -> list[sympy.Expr]:
        return [e.diff(s) for e in exprs for s in symbols]

    def _address(self, cases: Sequence[Sequence[sympy.Expr]], digits: Sequence[sympy.Symbol] = ()) -> int:
        model = self.model
        names = name_symbols(model.state_symbols, model.delayed_symbols, model.parameter_symbols)
        code = load_machine_code(write_machine_source(cases, names, digits))
        self._loaded.append(code)
        return code.address


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
    """Return the machine code of a generated source, from disk if it was compiled before."""
    with _loading:
        code = _in_use.get(text)
        if code is None:
            code = _in_use[text] = _load(text)
        return code


@cache
def _find_source_folder() -> Path | None:
    return find_cache_folder(Path(__file__).parent.glob("*.py"))


def _load(text: str) -> MachineCode:
    """Return the machine code of a source that is kept in a file beside it, as numba's cache needs one."""
    name, folder = "model_" + hashlib.sha256(text.encode()).hexdigest()[:24], _find_source_folder()
    if folder is None:
        namespace: dict[str, Any] = {}
        exec(compile(text, "<generated>", "exec"), namespace)  # the text comes from the printer, never from a file
        with compiler_settings(None):
            return cast(MachineCode, cfunc(SIGNATURE, error_model="numpy")(namespace["generated"]))
    path = folder / f"{name}.py"
    if not path.exists() or path.read_text() != text:
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary = path.with_name(f".{name}.{os.getpid()}.part")
        temporary.write_text(text)
        os.replace(temporary, path)
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    # While it loads machine code numba looks up by name the module that the code came from.
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
        with compiler_settings(folder):
            return cast(MachineCode, cfunc(SIGNATURE, cache=True, error_model="numpy")(module.generated))
    finally:
        del sys.modules[name]
