"""Symbols to functions of arrays: values and derivatives over many points at once.

Every generated function has the arguments ``t, x, xd, p`` (time, states, delayed values, parameters). States and
delayed values come with the points on the last axis, so ``x`` has shape (n_states, n_points), ``xd`` (n_delayed,
n_points), ``t`` (n_points,), while ``p`` has shape (n_parameters,). The same source runs on scalars with the functions
of ``math``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import accumulate
from typing import Any, TypeAlias

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.codegen.printer import ArrayPrinter, Names, name_symbols, print_assignments
from pddecont.memo import cached_property
from pddecont.model import TIME, ChainRule, find_slopes

Array = NDArray[np.float64]
Ints = NDArray[np.intp]
# Derivatives by the numbers of the output and the symbol.
Slopes: TypeAlias = Mapping[tuple[int, int], sympy.Expr]

ARGUMENTS = "t, x, xd, p"
# What generated source may call: the names that numpy has for arrays, and the same names for floats.
_NUMPY = {
    name: getattr(np, name)
    for name in ("sin", "cos", "tan", "sinh", "cosh", "tanh", "exp", "log", "sqrt", "sign", "pi", "e")
}
_NUMPY |= {"arcsin": np.arcsin, "arccos": np.arccos, "arctan": np.arctan, "arctan2": np.arctan2, "abs": np.abs}
_MATH = {
    name: getattr(math, name) for name in ("sin", "cos", "tan", "sinh", "cosh", "tanh", "exp", "log", "sqrt", "pi", "e")
}
_MATH |= {
    "arcsin": math.asin,
    "arccos": math.acos,
    "arctan": math.atan,
    "arctan2": math.atan2,
    "abs": abs,
    "sign": lambda v: math.copysign(1.0, v) if v else 0.0,
}


@dataclass(frozen=True)
class Derivatives:
    """Values of a function and those of its derivatives that are not zero.

    ``value`` has shape (n_out, n_points), the others (n_entries, n_points); the :class:`Structure` of the function says
    which entries these are.
    """

    value: Array
    dx: Array
    dxd: Array
    dp: Array
    dt: Array


@dataclass(frozen=True, eq=False)
class Structure:
    """Which derivatives of a function are not zero.

    ``dx``, ``dxd`` and ``dp`` hold the outputs and the variables of the entries (n_entries,), ``dt`` the outputs.
    """

    dx: tuple[Ints, Ints]
    dxd: tuple[Ints, Ints]
    dp: tuple[Ints, Ints]
    dt: Ints

    @cached_property
    def moved(self) -> Ints:
        """Outputs that change when a time or a delayed value does."""
        return np.union1d(self.dt, self.dxd[0]).astype(np.intp)

    @cached_property
    def moving(self) -> Ints:
        """Outputs that depend on a free parameter."""
        return np.unique(self.dp[0]).astype(np.intp)


@dataclass(frozen=True, eq=False)
class ArrayFunction:
    """Expressions as functions over arrays of points; each source is made and compiled when first needed.

    Derivatives go through what ``chain`` says of values that are read by delays that vary.
    """

    exprs: tuple[sympy.Expr, ...]
    states: tuple[sympy.Symbol, ...]
    delayed: tuple[sympy.Symbol, ...]
    parameters: tuple[sympy.Symbol, ...]
    chain: ChainRule = field(default_factory=dict, repr=False)
    _compiled: dict[tuple[int, ...] | None, Callable[..., None]] = field(default_factory=dict, repr=False)
    _structures: dict[tuple[int, ...], Structure] = field(default_factory=dict, repr=False)
    _scalar: dict[tuple[int, ...], Callable[..., None]] = field(default_factory=dict, repr=False)

    def __reduce__(self) -> tuple[type[ArrayFunction], tuple[Any, ...]]:
        """Return what makes the function anew in another process, where it is compiled again."""
        return ArrayFunction, (self.exprs, self.states, self.delayed, self.parameters, self.chain)

    @property
    def n_out(self) -> int:
        """Number of expressions."""
        return len(self.exprs)

    def value(self, t: Array, x: Array, xd: Array, p: Array) -> Array:
        """Return the values of the expressions, shape (n_out, n_points); not finite where there is none."""
        out = np.zeros((self.n_out, np.shape(t)[0]), dtype=np.result_type(x, xd, p, t))
        with np.errstate(all="ignore"):
            self._function(None)(t, x, xd, p, out)
        return out

    def derivatives(self, t: Array, x: Array, xd: Array, p: Array, free: tuple[int, ...] = ()) -> Derivatives:
        """Return values and all derivatives that are not zero.

        Those in parameters are in the parameters numbered ``free``.
        """
        where = self.structure(free)
        sizes = self.n_out, len(where.dx[0]), len(where.dxd[0]), len(where.dp[0]), len(where.dt)
        # One array is made in less time than five.
        every, ends = np.zeros((sum(sizes), len(t))), accumulate(sizes)
        arrays = [every[end - size : end] for size, end in zip(sizes, ends, strict=True)]
        with np.errstate(all="ignore"):
            self._function(free)(t, x, xd, p, *arrays)
        return Derivatives(*arrays)

    def structure(self, free: tuple[int, ...] = ()) -> Structure:
        """Return which derivatives are not zero; those in parameters only for the numbers in ``free``."""
        if free not in self._structures:
            dx, dxd, dp, dt = (_places(slopes) for slopes in self._list_slopes(free).values())
            self._structures[free] = Structure(dx, dxd, dp, dt[0])
        return self._structures[free]

    def _list_slopes(self, free: tuple[int, ...]) -> dict[str, Slopes]:
        """Return the derivatives that are not zero, as :class:`Derivatives` names them."""
        dp = find_slopes(self.exprs, [self.parameters[i] for i in free], self.chain)
        return {"dx": self._slopes["dx"], "dxd": self._slopes["dxd"], "dp": dp, "dt": self._slopes["dt"]}

    @cached_property
    def _slopes(self) -> dict[str, Slopes]:
        """The derivatives that are not zero in what is no parameter."""
        groups = {"dx": self.states, "dxd": self.delayed, "dt": (TIME,)}
        found = find_slopes(self.exprs, [s for group in groups.values() for s in group], self.chain)
        first = 0
        slopes: dict[str, Slopes] = {}
        for name, group in groups.items():
            last = first + len(group)
            slopes[name] = {(i, k - first): e for (i, k), e in found.items() if first <= k < last}
            first = last
        return slopes

    @cached_property
    def scalar(self) -> Callable[..., None]:
        """The function ``f(t, x, xd, p, out)`` of floats and lists, for one point."""
        return compile_source(self._source(None), _MATH)

    def find_scalar_derivatives(self, free: tuple[int, ...]) -> Callable[..., None]:
        """Return the function of floats and lists that writes what :meth:`derivatives` returns, for one point."""
        if free not in self._scalar:
            self._scalar[free] = compile_source(self._source(free), _MATH)
        return self._scalar[free]

    @cached_property
    def uses_delayed(self) -> bool:
        """Whether any expression reads a delayed value."""
        return any(set(self.delayed) & e.free_symbols for e in self.exprs)

    @cached_property
    def linear(self) -> tuple[bool, ...]:
        """Whether each expression is linear in the states with coefficients that are parameters."""
        known = {*self.states, *self.parameters}
        bent = {i for (i, _), slope in self._slopes["dx"].items() if not slope.free_symbols <= set(self.parameters)}
        return tuple(i not in bent and e.free_symbols <= known for i, e in enumerate(self.exprs))

    def _function(self, free: tuple[int, ...] | None) -> Callable[..., None]:
        if free not in self._compiled:
            self._compiled[free] = compile_source(self._source(free), _NUMPY)
        return self._compiled[free]

    def _source(self, free: tuple[int, ...] | None) -> str:
        """Return the source of values and derivatives, in parameters numbered ``free``, or of values alone for None."""
        names = name_symbols(self.states, self.delayed, self.parameters)
        groups: dict[str, Sequence[sympy.Expr]] = {"value": self.exprs}
        if free is not None:
            groups |= {name: list(slopes.values()) for name, slopes in self._list_slopes(free).items()}
        return write_array_source(groups, names)


def _places(entries: Iterable[tuple[int, int]]) -> tuple[Ints, Ints]:
    outputs, variables = np.array(list(entries), dtype=np.intp).reshape(-1, 2).T.copy()
    return outputs, variables


def write_array_source(groups: Mapping[str, Sequence[sympy.Expr]], names: Names) -> str:
    """Return the source of a function that fills one output array a group; entries that are zero are not written."""
    targets = [(f"{name}[{i}]", entry) for name, entries in groups.items() for i, entry in enumerate(entries)]
    body = [f"    {line}" for line in print_assignments(targets, ArrayPrinter(names))]
    return "\n".join([f"def generated({ARGUMENTS}, {', '.join(groups)}):", *body, "    return"])


def compile_source(text: str, namespace: Mapping[str, Any]) -> Callable[..., None]:
    """Return the function that a generated source defines, with nothing but ``namespace`` in reach."""
    scope: dict[str, Any] = {"__builtins__": {}, **namespace}
    exec(compile(text, "<generated>", "exec"), scope)  # the text comes from the printer, never from a file
    function: Callable[..., None] = scope["generated"]
    return function
