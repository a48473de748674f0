"""A model's functions of numbers."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.codegen.numpy_backend import ArrayFunction
from pddecont.memo import cached_property
from pddecont.model import Model

if TYPE_CHECKING:
    from pddecont.codegen.machine_code import ModelFunctions

Array = NDArray[np.float64]
Ints = NDArray[np.intp]
# No states, at one point.
_NONE = np.zeros((0, 1))


@dataclass(frozen=True)
class ParameterFunction:
    """Expressions in the parameters alone: delays, the forcing period."""

    function: ArrayFunction

    def value(self, p: Array) -> Array:
        """Return the values, shape (n_out,); not finite where there is none."""
        values = [0.0] * self.function.n_out
        try:
            self.function.scalar(0.0, (), (), p.tolist(), values)
        except (ArithmeticError, ValueError):
            # Arrays know what floats refuse: infinity, and what is no number.
            return self.function.value(np.zeros(1), _NONE, _NONE, p)[:, 0]
        return np.array(values, dtype=np.float64)

    def derivatives(self, p: Array, free: tuple[int, ...]) -> Array:
        """Return the derivatives in the free parameters, shape (n_out, n_free)."""
        result, (outputs, variables) = np.zeros((self.function.n_out, len(free))), self.function.structure(free).dp
        if len(outputs):
            slopes = [0.0] * len(outputs)
            try:
                write = self.function.find_scalar_derivatives(free)
                write(0.0, (), (), p.tolist(), [0.0] * self.function.n_out, [], [], slopes, [])
            except (ArithmeticError, ValueError):
                slopes = self.function.derivatives(np.zeros(1), _NONE, _NONE, p, free).dp[:, 0].tolist()
            result[outputs, variables] = slopes
        return result


@dataclass(frozen=True, eq=False)
class NumericModel:
    """A model's functions of numbers: over arrays, and as machine code.

    Each is generated and compiled when first needed, and kept as long as this object.
    """

    model: Model
    _functions: dict[Hashable, ArrayFunction] = field(default_factory=dict, repr=False)
    _machine_code: dict[Hashable, ModelFunctions] = field(default_factory=dict, repr=False)
    _addresses: dict[tuple[str, tuple[str, ...]], list[tuple[int, int]]] = field(default_factory=dict, repr=False)

    def __reduce__(self) -> tuple[type[NumericModel], tuple[Model]]:
        # Functions are generated anew where a model arrives: they cannot be sent.
        return NumericModel, (self.model,)

    @property
    def n_states(self) -> int:
        """Number of states."""
        return len(self.model.states)

    @cached_property
    def parameter_values(self) -> Array:
        """The model file's parameter values, in the order of ``model.parameters``."""
        return np.array(list(self.model.parameters.values()), dtype=float)

    def list_reads(self, delay: int) -> list[tuple[int, Ints, Ints]]:
        """Return what is read by a delay: each derivative with the states and the numbers of the delayed values."""
        return self._reads.get(delay, [])

    @cached_property
    def _reads(self) -> dict[int, list[tuple[int, Ints, Ints]]]:
        found: dict[int, list[tuple[int, Ints, Ints]]] = {}
        for (delay, order), numbers in self.model.read_groups.items():
            states = np.array([self.model.delayed[i].state for i in numbers], dtype=np.intp)
            found.setdefault(delay, []).append((order, states, np.array(numbers, dtype=np.intp)))
        return found

    def with_fixed(self, p: Array) -> Array:
        """Return ``p`` with the parameters that effects left out set at their values."""
        if not self.model.fixed:
            return p
        p = p.copy()
        p[[self.parameter_index(name) for name in self.model.fixed]] = self._fixed.value(p)
        return p

    @cached_property
    def _fixed(self) -> ParameterFunction:
        return self.parameter_function(tuple(self.model.fixed.values()))

    def parameter_index(self, name: str) -> int:
        """Return the place of a parameter in ``p``."""
        return list(self.model.parameters).index(name)

    def function(self, exprs: Sequence[sympy.Expr]) -> ArrayFunction:
        """Return any expressions over this model as a function of arrays."""
        model = self.model
        return self._array_function(tuple(exprs), model.state_symbols, model.read_symbols)

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
        """Return :meth:`function` of a part of the model; its name is a shorter key than its expressions."""
        if (kind, name) not in self._functions:
            self._functions[kind, name] = self.function(exprs)
        return self._functions[kind, name]

    @cached_property
    def delays(self) -> ParameterFunction:
        """The delays as functions of the parameters."""
        return self.parameter_function(self.model.delays)

    def event_delay(self, name: str) -> ParameterFunction:
        """Return the delay of a delayed event as a function of the parameters, n_out = 1."""
        delay = self.model.events[name].delay
        assert delay is not None, f"event {name} is not a delayed event"
        return self.parameter_function((delay,))

    def single_delay(self, number: int) -> ParameterFunction:
        """Return a delay as a function of the parameters, n_out = 1."""
        return self.parameter_function((self.model.delays[number],))

    def varying_delay(self, number: int) -> ArrayFunction:
        """Return a delay that varies, n_out = 1."""
        return self._named("delay", str(number), [self.model.varying[number]])

    def integrand(self, number: int) -> ArrayFunction:
        """Return what is integrated over the past, n_out = 1; its t is the lag, its states those at that lag."""
        return self._named("integrand", str(number), [self.model.integrals[number].integrand])

    def limits(self, number: int) -> ArrayFunction:
        """Return the lags from which and to which is integrated, n_out = 2."""
        integral = self.model.integrals[number]
        return self._named("limits", str(number), [integral.low, integral.high])

    @cached_property
    def period(self) -> ParameterFunction:
        """The forcing period as a function of the parameters, n_out = 1 (0 for autonomous models)."""
        return self.parameter_function(() if self.model.period is None else (self.model.period,))

    def compile(self, history: tuple[sympy.Expr, ...] | None = None) -> ModelFunctions:
        """Return the model's functions as machine code; each is compiled when first needed.

        ``history`` replaces the model's.
        """
        # The compiler is imported by those who compute, and by no others.
        from pddecont.codegen.machine_code import ModelFunctions

        return self._machine_code.setdefault(history, ModelFunctions(self.model, history))

    def locate_code(self, kind: str, names: tuple[str, ...]) -> list[tuple[int, int]]:
        """Return where the machine code of some functions begins, and what each is known by there.

        ``kind`` is "fields", and they are modes, "resets" or "events". Addresses last as long as this object.
        """
        if (kind, names) not in self._addresses:
            self._addresses[kind, names] = self._locate_code(kind, names)
        return self._addresses[kind, names]

    def _locate_code(self, kind: str, names: tuple[str, ...]) -> list[tuple[int, int]]:
        find = {"fields": self.mode, "resets": self.reset, "events": self.event}[kind]
        functions, code = [find(name).exprs for name in names], self.compile()
        with code.lock:
            pages = getattr(code, kind)
            pages.add(functions)
            addresses = pages.list_addresses("value")
            places = [pages.find_place(exprs) for exprs in functions]
        return [(addresses[page], which << len(code.digits)) for page, which in places]

    def parameter_function(self, exprs: tuple[sympy.Expr, ...]) -> ParameterFunction:
        """Return expressions in the parameters alone as a function of them."""
        return ParameterFunction(self._array_function(exprs, (), ()))

    def _array_function(self, exprs: tuple[sympy.Expr, ...], states: Any, delayed: Any) -> ArrayFunction:
        key = exprs, states
        if key not in self._functions:
            chain = self.model.chain if states else {}
            self._functions[key] = ArrayFunction(exprs, states, delayed, self.model.parameter_symbols, chain)
        return self._functions[key]
