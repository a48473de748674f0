"""Symbols to array functions: values and derivatives over many points at once, common subexpressions shared.

Every generated function has the arguments ``t, x, xd, p`` (time, states, delayed values, parameters). States and delayed
values come with the points on the last axis, so ``x`` has shape (n_states, n_points), ``xd`` (n_delayed, n_points), ``t``
(n_points,), while ``p`` has shape (n_parameters,). The same text runs on scalars with the functions of ``math``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray
from sympy.printing.numpy import NumPyPrinter

from pddecont.model.expression import TIME
from pddecont.model.system import Model

Array = NDArray[np.float64]
Ints = NDArray[np.intp]
Symbols = Sequence[sympy.Symbol]

ARGUMENTS = "t, x, xd, p"
_NUMPY = {name: getattr(np, name) for name in ("sin", "cos", "tan", "sinh", "cosh", "tanh", "exp", "log", "sqrt", "sign", "pi")}
_NUMPY |= {"arcsin": np.arcsin, "arccos": np.arccos, "arctan": np.arctan, "arctan2": np.arctan2, "abs": np.abs}
_MATH = {name: getattr(math, name) for name in ("sin", "cos", "tan", "sinh", "cosh", "tanh", "exp", "log", "sqrt", "pi")}
_MATH |= {"arcsin": math.asin, "arccos": math.acos, "arctan": math.atan, "arctan2": math.atan2, "abs": abs,
          "sign": lambda v: math.copysign(1.0, v) if v else 0.0}  # fmt: skip


@dataclass(frozen=True)
class Derivatives:
    """A function's value (n_out, n_points) and those of its derivatives that are not zero, each of shape (n_entries, n_points).

    The function's :class:`Structure` says which entries these are.
    """

    value: Array
    dx: Array
    dxd: Array
    dp: Array
    dt: Array


@dataclass(frozen=True, eq=False)
class Structure:
    """Which derivatives of a function are not zero: (output, variable) of each entry of dx, dxd and dp, output of each of dt."""

    dx: tuple[Ints, Ints]
    dxd: tuple[Ints, Ints]
    dp: tuple[Ints, Ints]
    dt: Ints

    @cached_property
    def moved(self) -> Ints:
        """Outputs that move when a time or a delayed value does."""
        return np.union1d(self.dt, self.dxd[0]).astype(np.intp)

    @cached_property
    def moving(self) -> Ints:
        """Outputs that depend on a free parameter."""
        return np.unique(self.dp[0]).astype(np.intp)


@dataclass(frozen=True, eq=False)
class ArrayFunction:
    """A list of expressions compiled to functions over arrays of points; derivatives are made when first asked for."""

    exprs: tuple[sympy.Expr, ...]
    states: tuple[sympy.Symbol, ...]
    delayed: tuple[sympy.Symbol, ...]
    parameters: tuple[sympy.Symbol, ...]
    _compiled: dict[Any, Callable[..., None]] = field(default_factory=dict, repr=False, compare=False)
    _structures: dict[tuple[int, ...], Structure] = field(default_factory=dict, repr=False, compare=False)

    @property
    def n_out(self) -> int:
        """Number of expressions."""
        return len(self.exprs)

    def value(self, t: Array, x: Array, xd: Array, p: Array) -> Array:
        """Return the expressions' values, shape (n_out, n_points); not finite where an expression is not defined."""
        out = np.zeros((self.n_out, np.shape(t)[0]), dtype=np.result_type(x, xd, p, t))
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            self._function("value")(t, x, xd, p, out)
        return out

    def derivatives(self, t: Array, x: Array, xd: Array, p: Array, free: tuple[int, ...] = ()) -> Derivatives:
        """Return values and all derivatives that are not zero; those in parameters only for the numbers in ``free``."""
        n, where = np.shape(t)[0], self.structure(free)
        arrays = [np.zeros((m, n)) for m in (self.n_out, len(where.dx[0]), len(where.dxd[0]), len(where.dp[0]), len(where.dt))]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            self._function(free)(t, x, xd, p, *arrays)
        return Derivatives(*arrays)

    def structure(self, free: tuple[int, ...] = ()) -> Structure:
        """Return which derivatives are not zero."""
        if free not in self._structures:
            symbols = (self.states, self.delayed, [self.parameters[i] for i in free], [TIME])
            dx, dxd, dp, dt = (_places(self._slopes(group)) for group in symbols)
            self._structures[free] = Structure(dx, dxd, dp, dt[0])
        return self._structures[free]

    def _slopes(self, symbols: Symbols) -> dict[tuple[int, int], sympy.Expr]:
        """Return the derivatives that are not zero by (output, symbol), in order."""
        number = {s: k for k, s in enumerate(symbols)}
        places = [(i, number[s]) for i, e in enumerate(self.exprs) for s in sorted(e.free_symbols & set(number), key=number.__getitem__)]
        slopes = {(i, k): self.exprs[i].diff(symbols[k]) for i, k in places}
        return {place: slope for place, slope in slopes.items() if slope != 0}

    @cached_property
    def scalar(self) -> Callable[..., None]:
        """The function ``f(t, x, xd, p, out)`` of plain floats and lists, for one point."""
        return compile_source(self._source("value"), _MATH)

    @cached_property
    def uses_delayed(self) -> bool:
        """Whether any expression reads a delayed value."""
        return any(set(self.delayed) & e.free_symbols for e in self.exprs)

    @cached_property
    def linear(self) -> tuple[bool, ...]:
        """Whether each expression is linear in the states with coefficients that are parameters."""
        known = {*self.states, *self.parameters}
        return tuple(e.free_symbols <= known and all(e.diff(s).free_symbols <= set(self.parameters) for s in self.states)
                     for e in self.exprs)  # fmt: skip

    def _function(self, key: Any) -> Callable[..., None]:
        if key not in self._compiled:
            self._compiled[key] = compile_source(self._source(key), _NUMPY)
        return self._compiled[key]

    def _source(self, key: Any) -> str:
        names = symbol_names(self.states, self.delayed, self.parameters)
        if key == "value":
            return source({"value": self.exprs}, names)
        groups: dict[str, Sequence[sympy.Expr]] = {"value": self.exprs}
        free = [self.parameters[i] for i in key]
        for name, symbols in (("dx", self.states), ("dxd", self.delayed), ("dp", free), ("dt", [TIME])):
            groups[name] = list(self._slopes(symbols).values())
        return source(groups, names)


def _places(entries: Iterable[tuple[int, int]]) -> tuple[Ints, Ints]:
    pairs = np.array(list(entries), dtype=np.intp).reshape(-1, 2)
    return pairs[:, 0], pairs[:, 1]


def symbol_names(states: Symbols, delayed: Symbols, parameters: Symbols) -> dict[sympy.Symbol, str]:
    """Return what each symbol is called in generated code: places in arrays, never the user's own names."""
    names = {TIME: "t"}
    for array, symbols in (("x", states), ("xd", delayed), ("p", parameters)):
        names |= {s: f"{array}[{i}]" for i, s in enumerate(symbols)}
    return names


class _Printer(NumPyPrinter):
    def __init__(self, names: Mapping[sympy.Symbol, str]):
        super().__init__({"fully_qualified_modules": False})
        self._names = names

    def _print_Symbol(self, expr: sympy.Symbol) -> str:
        return self._names.get(expr) or super()._print_Symbol(expr)


def source(groups: Mapping[str, Sequence[sympy.Expr]], names: Mapping[sympy.Symbol, str]) -> str:
    """Return the text of a function that fills one output array a group; entries that are zero are left alone."""
    targets = [(f"{name}[{i}]", entry) for name, entries in groups.items() for i, entry in enumerate(entries) if entry != 0]
    printer = _Printer(names)
    shared, exprs = sympy.cse([e for _, e in targets], symbols=sympy.numbered_symbols("c"), order="canonical")
    lines = [f"def generated({ARGUMENTS}, {', '.join(groups)}):"]
    lines += [f"    {s.name} = {printer.doprint(e)}" for s, e in shared]
    lines += [f"    {target} = {printer.doprint(e)}" for (target, _), e in zip(targets, exprs, strict=True)]
    return "\n".join([*lines, "    return"])


def compile_source(text: str, namespace: Mapping[str, Any]) -> Callable[..., None]:
    """Return the function that generated ``text`` defines, with nothing but ``namespace`` in reach."""
    scope: dict[str, Any] = {"__builtins__": {}, **namespace}
    exec(compile(text, "<generated>", "exec"), scope)  # the text comes from `source`, never from a file
    return scope["generated"]


@dataclass(frozen=True)
class ParameterFunction:
    """Expressions in the parameters alone: delays, the forcing period."""

    function: ArrayFunction

    def value(self, p: Array) -> Array:
        """Return the values, shape (n_out,)."""
        empty = np.zeros((0, 1))
        return self.function.value(np.zeros(1), empty, empty, p)[:, 0]

    def derivatives(self, p: Array, free: tuple[int, ...]) -> Array:
        """Return the derivatives in the free parameters, shape (n_out, n_free)."""
        empty = np.zeros((0, 1))
        result = np.zeros((self.function.n_out, len(free)))
        result[self.function.structure(free).dp] = self.function.derivatives(np.zeros(1), empty, empty, p, free).dp[:, 0]
        return result


@dataclass(frozen=True, eq=False)
class NumericModel:
    """A model's functions over arrays; each is generated and compiled when first used, once a process."""

    model: Model
    _functions: dict[tuple[str, str], ArrayFunction] = field(default_factory=dict, repr=False, compare=False)

    @property
    def n_states(self) -> int:
        """Number of states."""
        return len(self.model.states)

    @cached_property
    def parameter_values(self) -> Array:
        """The model file's parameter values, in the order of ``model.parameters``."""
        return np.array(list(self.model.parameters.values()), dtype=float)

    def with_fixed(self, p: Array) -> Array:
        """Return ``p`` with the parameters that effects left out set at their values."""
        if not self.model.fixed:
            return p
        p = p.copy()
        p[[self.parameter_index(name) for name in self.model.fixed]] = self._fixed.value(p)
        return p

    @cached_property
    def _fixed(self) -> ParameterFunction:
        return ParameterFunction(_array_function(tuple(self.model.fixed.values()), (), (), self.model.parameter_symbols))

    def parameter_index(self, name: str) -> int:
        """Return the place of a parameter in ``p``."""
        return list(self.model.parameters).index(name)

    def function(self, exprs: Sequence[sympy.Expr]) -> ArrayFunction:
        """Return the compiled form of any expressions over this model."""
        model = self.model
        return _array_function(tuple(exprs), model.state_symbols, model.delayed_symbols, model.parameter_symbols)

    def mode(self, name: str) -> ArrayFunction:
        """Return the vector field f of a mode, n_out = n_states."""
        return self._named("mode", name, self.model.modes[name])

    def event(self, name: str) -> ArrayFunction:
        """Return the event function h of an event that has one, n_out = 1."""
        function = self.model.events[name].function
        assert function is not None, f"event {name} is a delayed event"
        return self._named("event", name, [function])

    def reset(self, name: str) -> ArrayFunction:
        """Return the reset g, n_out = n_states."""
        return self._named("reset", name, self.model.resets[name])

    def _named(self, kind: str, name: str, exprs: Sequence[sympy.Expr]) -> ArrayFunction:
        if (kind, name) not in self._functions:
            self._functions[kind, name] = self.function(exprs)
        return self._functions[kind, name]

    @cached_property
    def delays(self) -> ParameterFunction:
        """The delays as functions of the parameters."""
        return ParameterFunction(_array_function(self.model.delays, (), (), self.model.parameter_symbols))

    def event_delay(self, name: str) -> ParameterFunction:
        """Return the delay of a delayed event as a function of the parameters, n_out = 1."""
        delay = self.model.events[name].delay
        assert delay is not None, f"event {name} is not a delayed event"
        return ParameterFunction(_array_function((delay,), (), (), self.model.parameter_symbols))

    @cached_property
    def period(self) -> ParameterFunction:
        """The forcing period as a function of the parameters, n_out = 1 (0 for autonomous models)."""
        exprs = () if self.model.period is None else (self.model.period,)
        return ParameterFunction(_array_function(exprs, (), (), self.model.parameter_symbols))


@cache
def _array_function(exprs: tuple[sympy.Expr, ...], states: Any, delayed: Any, parameters: Any) -> ArrayFunction:
    return ArrayFunction(exprs, states, delayed, parameters)
