"""The compiled integrator from Python: a model at given parameters, its state, and what went wrong in words."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.delay.chain import Chain
from pddecont.delay.operator import DelayMethod
from pddecont.errors import ConvergenceError
from pddecont.model.codegen import NumericModel
from pddecont.model.diagnosis import not_finite
from pddecont.model.expression import TIME
from pddecont.simulate.functions import ModelFunctions
from pddecont.simulate.kernel.advance import begin, change, run
from pddecont.simulate.kernel.breaking import LEVELS as BREAKING_LEVELS
from pddecont.simulate.kernel.tables import (
    CONSTANT,
    LAST_EVENT,
    MODE,
    USED,
    ZENO_TIME,
    Log,
    Memory,
    Status,
    System,
    T,
    Values,
    Work,
    enlarged,
    new_log,
    new_memory,
    new_work,
)

Array = NDArray[np.float64]
STEPS_AT_ONCE = 20_000
# A cause for a simulation's end is looked for up to 2 to this power ahead, relative to the time.
LOOK_AHEAD = -30
DIRECTIONS = {"rising": 1, "falling": -1, "any": 0}


@dataclass(frozen=True)
class Method:
    """How to integrate: error allowed in a step, explicit or stiff, the mode an accumulating event hands over to, the longest step."""

    rtol: float = 1e-9
    atol: float = 1e-11
    stiff: bool = False
    stick: Mapping[str, str] = field(default_factory=dict)
    max_step: float = np.inf


@dataclass(frozen=True)
class Section:
    """Where returns are counted: at an event of the model, or where an expression crosses zero."""

    event: str | None = None
    expr: sympy.Expr | None = None
    direction: str = "rising"


@dataclass(frozen=True, eq=False)
class Simulator:
    """A model ready to be integrated, at any parameters."""

    numeric: NumericModel
    delay: DelayMethod
    method: Method = Method()
    section: Section = Section()
    history: tuple[sympy.Expr, ...] | None = None
    tangent: bool = False

    def __post_init__(self) -> None:
        if isinstance(self.delay, Chain) and self.delay.order > 4:
            raise ConvergenceError(f"a chain of order {self.delay.order} has growing solutions and cannot be simulated (orders 1 to 4 "
                                   "can); give the simulating step 'delay: {method: direct}' and the orbit step the chain")  # fmt: skip
        if self.tangent and self.method.stiff:
            raise ConvergenceError("Lyapunov exponents go with the explicit method; leave 'method: stiff' out")

    @cached_property
    def functions(self) -> ModelFunctions:
        """The model's compiled functions."""
        return ModelFunctions(self.numeric.model, self.section.expr, self.history)

    @cached_property
    def system(self) -> System:
        """The model in numbers."""
        model, functions, n = self.numeric.model, self.functions, self.numeric.n_states
        modes, events, resets = list(model.modes), list(model.events), list(model.resets)
        order, length = (self.delay.order, self.delay.n) if isinstance(self.delay, Chain) else (0, 0)
        pairs = np.array(model.delayed, dtype=np.int64).reshape(-1, 2)
        kept = np.unique(pairs[:, 0])
        place = np.full(n, -1)
        place[kept] = np.arange(len(kept))
        delayed = set(model.delayed_symbols)
        after = [events.index(e.after) if e.after is not None else -1 for e in model.events.values()]
        section = -1 if self.section.expr is None else len(events)
        after += [-1] * (section >= 0)
        segments = model.segments.values()
        return System(
            functions.field, functions.event, functions.reset, functions.history,
            functions.field_jacobian if self.tangent or self.method.stiff else 0, functions.event_jacobian,
            functions.reset_jacobian if self.tangent else 0,
            n, n + len(pairs) * order * length, int(self.tangent), np.ascontiguousarray(pairs[:, 0]), np.ascontiguousarray(pairs[:, 1]),
            kept, place, _integers(modes.index(s.mode) for s in segments), _integers(events.index(s.event) for s in segments),
            _integers(DIRECTIONS[s.direction] for s in segments), _integers(resets.index(s.reset) for s in segments),
            _integers(modes.index(s.to) for s in segments), _integers(after),
            _integers(bool(delayed & h.free_symbols) for h in functions.events), order, length, section,
            DIRECTIONS[self.section.direction], -1 if self.section.event is None else events.index(self.section.event),
            int(self.method.stiff), len(modes))  # fmt: skip

    @cached_property
    def work(self) -> Work:
        """Room for intermediate results."""
        return new_work(self.system)

    def values(self, p: Array, longest: float = 0.0) -> Values:
        """Return the model's numbers at parameters ``p``; the past is kept for ``longest``, or the longest delay."""
        model, numeric, method = self.numeric.model, self.numeric, self.method
        tau = np.asarray(numeric.delays.value(p), dtype=float)
        later = [float(numeric.event_delay(e.name).value(p)[0]) if e.delay is not None else 0.0 for e in model.events.values()]
        later += [0.0] * (self.section.expr is not None)
        bounds = [method.max_step]
        if not isinstance(self.delay, Chain):
            bounds += [x for x in tau if x > 0]
        if model.forced:
            bounds.append(float(numeric.period.value(p)[0]) / 2)
        names, modes = list(model.events), list(model.modes)
        stick = np.full(len(later), -1)
        for event, mode in method.stick.items():
            stick[names.index(event)] = modes.index(mode)
        return Values(np.array(p, dtype=float), tau, np.array(later), float(min(bounds)), method.rtol, method.atol,
                      max(longest, float(max(tau, default=0.0))), stick)  # fmt: skip

    def start(self, values: Values, states: Sequence[float] | Array | None = None, mode: str | None = None, *, constant: bool = False,
              t: float = 0.0) -> Memory:  # fmt: skip
        """Return the state of an integration that begins at ``t``.

        ``states`` replaces the history's value there. The history is the model's, or ``constant``: the states at the start.
        """
        model, system = self.numeric.model, self.system
        memory = new_memory(system, values)
        past = self.past(values.p, t)
        memory.y[: system.n] = past[0] if states is None else states
        if constant:
            memory.count[CONSTANT] = 1
            memory.constant[:] = memory.y[: system.n]
        if isinstance(self.delay, Chain):
            self._start_chain(memory, values, t, constant)
        if self.tangent:
            memory.y[system.n_full :] = np.random.default_rng(1).standard_normal(system.n_full)
        begin(system, values, memory, self.work, t, list(model.modes).index(mode or model.initial_mode))
        return memory

    def change(self, memory: Memory, values: Values, p: Array, longest: float = 0.0) -> tuple[Memory, Values]:
        """Let other parameters hold from the present time of an integration on; return the memory and the model's numbers there."""
        after = self.values(p, longest)
        # The echoes of every jump in the past may come anew.
        while len(memory.breaking_time) <= (memory.count[USED] + 2) * len(after.tau) * 2 + BREAKING_LEVELS:
            memory = enlarged(memory)
        change(self.system, after, memory, self.work, values)
        return memory, after

    def past(self, p: Array, t: float) -> list[Array]:
        """Return the history's states at ``t`` and their first three derivatives."""
        exprs = self.history or self.numeric.model.history
        function = self.numeric.function([d for e in exprs for d in (e, *(e.diff(TIME, k) for k in (1, 2, 3)))])
        n, m = self.numeric.n_states, len(self.numeric.model.delayed)
        numbers = function.value(np.array([t]), np.zeros((n, 1)), np.zeros((m, 1)), np.asarray(p))[:, 0].reshape(n, 4)
        return list(numbers.T)

    def _start_chain(self, memory: Memory, values: Values, t: float, constant: bool) -> None:
        assert isinstance(self.delay, Chain)
        n, order = self.delay.n, self.delay.order
        w = memory.y[self.numeric.n_states : self.system.n_full].reshape(-1, n, order)
        for i, (state, k) in enumerate(self.numeric.model.delayed):
            delta = values.tau[k] / n
            for stage in range(n):
                if constant:
                    w[i, stage, 0] = memory.constant[state]
                else:
                    past = self.past(values.p, t - (stage + 1) * delta)
                    w[i, stage] = [past[d][state] * delta**d for d in range(order)]

    def advance(self, values: Values, memory: Memory, t_stop: float, log: Log | None = None, heard: Callable[[float], None] | None = None,
                emptied: Callable[[Log], None] | None = None) -> tuple[Memory, Status]:  # fmt: skip
        """Integrate to ``t_stop`` or to the next return to the section; return the memory and which of the two it was.

        ``heard`` hears of times reached, ``emptied`` gets the log when it is full and leaves room in it.

        Raises
        ------
        ConvergenceError
            If events accumulate and do not stick, if the solution grows without bound, or if no step is small enough.
        """
        nothing = log if log is not None else new_log(self.system.n, 0, 0)
        while True:
            status = run(self.system, values, memory, nothing, self.work, t_stop, STEPS_AT_ONCE)
            if heard:
                heard(float(memory.clock[T]))
            if status in (Status.REACHED, Status.SECTION):
                return memory, Status(status)
            if status == Status.LOG_FULL and emptied is not None:
                emptied(nothing)
            elif status == Status.ROOM:
                memory = enlarged(memory)
            elif status != Status.PAUSED:
                raise ConvergenceError(self.complaint(memory, Status(status), values.p))

    def complaint(self, memory: Memory, status: Status, p: Array) -> str:
        """Return in words why an integration at parameters ``p`` came to a halt."""
        model, t = self.numeric.model, float(memory.clock[T])
        mode = list(model.modes)[memory.count[MODE]]
        if status in (Status.ZENO, Status.SLIDING):
            event = list(model.events)[memory.count[LAST_EVENT]]
            at = float(memory.clock[ZENO_TIME])
            if status == Status.ZENO:
                return (f"events of '{event}' accumulate at t = {at:.12g} (Zeno): the motion comes to rest there. Write a mode for it and "
                        f"name it in the step, 'stick: {{{event}: MODE}}'")  # fmt: skip
            return (f"event '{event}' leads, at t = {at:.12g}, to a mode whose flow leads straight back: both point at the surface (the "
                    f"motion slides along it). Write a mode for sliding and name it in the step, 'stick: {{{event}: MODE}}'")  # fmt: skip
        cause = self._without_value(memory, p)
        if cause:
            return f"the simulation ends at t = {t:.10g} in mode '{mode}': {cause}"
        if status == Status.NOT_FINITE:
            return (f"the solution is no longer finite near t = {t:.10g} in mode '{mode}'; it grows without bound there, or the vector "
                    "field cannot be evaluated: check its logarithms, roots and divisions")  # fmt: skip
        return (f"no step is small enough near t = {t:.10g} in mode '{mode}': the solution grows without bound there, or the vector field "
                "has a singularity or a jump that no event marks; a stiff model wants 'method: stiff'")  # fmt: skip

    def _without_value(self, memory: Memory, p: Array) -> str:
        """Return which part of the vector field has no finite value here or a short way ahead; empty if there is none.

        Ways ahead are tried along the present slope, from rounding up, with the delayed values read last.
        """
        model, n, t = self.numeric.model, self.numeric.n_states, float(memory.clock[T])
        mode = list(model.modes)[memory.count[MODE]]
        y, xd = memory.y[:n, None], np.array(self.work.xd[: len(model.delayed)])[:, None]
        named = [(f"{state}' of mode '{mode}'", f) for state, f in zip(model.states, model.modes[mode], strict=True)]
        slope = self.numeric.mode(mode).value(np.array([t]), y, xd, p)
        ahead = np.concatenate([[0.0], max(1.0, abs(t)) * 2.0 ** np.arange(-52, LOOK_AHEAD + 1)])
        with np.errstate(all="ignore"):
            states = y + np.where(np.isfinite(slope), slope, 0.0) * ahead
        finite = np.all(np.isfinite(states), axis=0)
        states, times = states[:, finite], t + ahead[finite]
        return not_finite(self.numeric, named, times, states, np.repeat(xd, len(times), axis=1), p) if len(times) else ""


def _integers(numbers: object) -> NDArray[np.int64]:
    return np.array(list(numbers), dtype=np.int64)  # type: ignore[call-overload]
