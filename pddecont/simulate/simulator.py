"""The compiled integrator from Python: a model at given parameters, and the state of an integration."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.codegen import ModelFunctions, NumericModel
from pddecont.delay import DelayMethod
from pddecont.errors import ConvergenceError
from pddecont.memo import cached_property
from pddecont.model import TIME, Model, add_rests, explain_direct_only, list_rates, reads_generally
from pddecont.native.integrator import CONSTANT, LEVELS, MODE, USED, Status, T
from pddecont.simulate.diagnosis import diagnose_halt
from pddecont.simulate.failure import MotionFailure, describe_failure
from pddecont.simulate.integrator import (
    IntegratorState,
    Log,
    ParameterValues,
    System,
    Workspace,
    change_parameters,
    enlarge,
    initialise,
    make_log,
    make_state,
    run,
)
from pddecont.simulate.known_past import make_constant_past, make_history_past, read_values
from pddecont.simulate.method import Method
from pddecont.simulate.model_numbers import make_values
from pddecont.simulate.part_tables import PartTables
from pddecont.simulate.reached_system import ReachedSystem
from pddecont.simulate.returns import ReturnSection
from pddecont.simulate.start_modes import read_mode, read_start_modes

Array = NDArray[np.float64]
# Steps between two reports of progress: some hundredths of a second.
STEPS_AT_ONCE = 20_000
# A chain of a higher Taylor order has solutions that grow (paper, section 2.2).
MAX_CHAIN_ORDER = 4
# The seed of the first tangent: any direction grows in that of the largest exponent.
TANGENT_SEED = 1


@dataclass(frozen=True, eq=False)
class Simulator:
    """A model ready to be integrated, at any parameters.

    ``history`` replaces the model's history; ``tangent`` integrates a tangent along with the states.

    Raises
    ------
    ConvergenceError
        If the chain of the delay method has growing solutions or cannot hold what the model reads, or a tangent is
        asked of the stiff method or of a model whose tangent is not known.
    """

    numeric: NumericModel
    delay: DelayMethod
    method: Method = field(default_factory=Method)
    section: ReturnSection = field(default_factory=ReturnSection)
    history: tuple[sympy.Expr, ...] | None = None
    tangent: bool = False

    def __post_init__(self) -> None:
        model = add_rests(self.numeric.model, self.method.stick.items())
        if model is not self.numeric.model:
            object.__setattr__(self, "numeric", NumericModel(model))
        order, _ = self.delay.simulated_stages
        if order > MAX_CHAIN_ORDER:
            raise ConvergenceError(
                f"a chain of order {order} has growing solutions and cannot be simulated (orders 1 to 4 "
                "can); give the simulating step 'delay: {method: direct}' and the orbit step the chain"
            )
        _refuse_delay_method(model, self.delay)
        if self.tangent:
            _refuse_tangent(model)
        if self.tangent and self.method.stiff:
            raise ConvergenceError("Lyapunov exponents go with the explicit method; leave 'method: stiff' out")

    @cached_property
    def functions(self) -> ModelFunctions:
        """The model's functions as machine code."""
        return self.numeric.compile(self.history)

    @cached_property
    def reached(self) -> ReachedSystem:
        """The model in the integrator's numbers, as far as motions have come."""
        return ReachedSystem(self.numeric, self.functions, self.delay, self.method, self.section, tangent=self.tangent)

    @property
    def tables(self) -> PartTables:
        """The modes, events and segments that motions have come to, by number."""
        return self.reached.tables

    @property
    def system(self) -> System:
        """The model in numbers."""
        return self.reached.system

    @property
    def past_columns(self) -> NDArray[np.int64]:
        """The states whose past delayed values are read from."""
        return self.system.kept

    @property
    def work(self) -> Workspace:
        """The arrays for intermediate results."""
        return self.reached.work

    def values(self, p: Array, longest: float = 0.0) -> ParameterValues:
        """Return the model's numbers at parameters ``p``; the past is kept for ``longest``, or the longest delay."""
        return make_values(self.numeric, self.tables, self.delay, self.method, p, longest)

    def start(
        self,
        values: ParameterValues,
        states: Sequence[float] | Array | None = None,
        mode: str | None = None,
        *,
        constant: bool = False,
        t: float = 0.0,
    ) -> IntegratorState:
        """Return the state of an integration that begins at ``t``.

        ``states`` (n_states,) replaces the value of the history there. The history is the model's, or ``constant``: the
        states at the start. Without a ``mode`` it is the model's, of equations that of the states.
        """
        system = self.system
        state = make_state(system, values)
        past = self.evaluate_history(values.p, t)
        state.y[: system.n] = past[0] if states is None else states
        if constant:
            state.count[CONSTANT] = 1
            state.constant[:] = state.y[: system.n]
        if self.delay.simulated_stages != (0, 0):
            self._start_chain(state, values, t, constant)
        if self.tangent:
            state.y[system.n_full :] = np.random.default_rng(TANGENT_SEED).standard_normal(system.n_full)
        began = mode or self.find_start_modes(values, state.y[None, : system.n], constant=constant, t=t)[0]
        number = self.number_mode(began)
        values, state = self.reached.fit(values, state)
        initialise(self.system, values, state, self.work, t, number)
        return state

    def number_mode(self, mode: str | None) -> int:
        """Return the number of a mode; -1 for none."""
        return -1 if mode is None else self.tables.add_mode(mode)

    def find_start_modes(
        self, values: ParameterValues, states: Array, *, constant: bool = False, t: float = 0.0
    ) -> list[str | None]:
        """Return the modes of motions that start with ``states`` (n, n_states): of the model, or of its equations.

        It is None where both fields point away from a surface on which one starts.
        """
        if self.numeric.model.derived is None:
            return [self.numeric.model.initial_mode] * len(states)
        if reads_generally(self.numeric.model):
            reads = [self._read_at_start(values.p, row, t, constant=constant) for row in states]
            xd = np.array(reads).reshape(len(states), -1)
            return read_start_modes(self.numeric, values.p, t, states, xd)
        delayed = self.numeric.model.delayed
        xd = np.empty((len(states), len(delayed)))
        for i, read in enumerate(delayed):
            past = states[:, read.state] if constant else self.evaluate_history(values.p, t - values.tau[read.delay])[0]
            xd[:, i] = past if constant else past[read.state]
        return read_start_modes(self.numeric, values.p, t, states, xd)

    def _read_at_start(self, p: Array, states: Array, t: float, *, constant: bool) -> Array:
        """Return what a motion that starts at ``t`` with ``states`` (n_states,) reads there, shape (n_reads,)."""
        if constant:
            past = make_constant_past(states)
        else:
            past = make_history_past(self.numeric, self.history or self.numeric.model.history, p)
        found = read_values(self.numeric, self.tables.plan, p, np.array([t]), states[:, None], past, np.array([t]))
        return found[:, 0]

    def change_parameters(
        self, state: IntegratorState, values: ParameterValues, p: Array, longest: float = 0.0
    ) -> tuple[IntegratorState, ParameterValues]:
        """Let parameters ``p`` hold from the present time on; return the state and the model's numbers.

        The past is kept for ``longest``, or the longest delay. Of a model given by its equations the mode is read anew:
        surfaces and what holds a motion on them change with the parameters.
        """
        after = self.values(p, longest)
        # Every jump in the past may come back once more.
        after, state = self.reached.fit(after, state)
        while len(state.breaking_time) <= (state.count[USED] + 2) * len(after.tau) * 2 + LEVELS:
            state = enlarge(state)
        before, _ = self.reached.fit(values, state)
        change_parameters(self.system, after, state, self.work, before)
        model = self.numeric.model
        if model.derived is not None and state.count[MODE] >= 0:
            states, delayed = state.y[: self.system.n], self.work.xd[: len(model.read_symbols)]
            was = list(self.tables.modes)[state.count[MODE]]
            mode = read_mode(self.numeric, after.p, float(state.clock[T]), states, delayed, was)
            state.count[MODE] = self.number_mode(mode)
            after, state = self.reached.fit(after, state)
        return state, after

    def evaluate_history(self, p: Array, t: float) -> list[Array]:
        """Return the history's states at ``t`` and their first three derivatives, each of shape (n_states,)."""
        exprs = self.history or self.numeric.model.history
        function = self.numeric.function([d for e in exprs for d in (e, *(e.diff(TIME, k) for k in (1, 2, 3)))])
        n, m = self.numeric.n_states, len(self.numeric.model.read_symbols)
        numbers = function.value(np.array([t]), np.zeros((n, 1)), np.zeros((m, 1)), np.asarray(p))[:, 0].reshape(n, 4)
        return list(numbers.T)

    def _start_chain(self, state: IntegratorState, values: ParameterValues, t: float, constant: bool) -> None:
        """Write the variables of the chain at ``t``: derivatives of the history times powers of the chain's step."""
        order, n = self.delay.simulated_stages
        w = state.y[self.numeric.n_states : self.system.n_full].reshape(-1, n, order)
        for i, read in enumerate(self.numeric.model.delayed):
            delta = values.tau[read.delay] / n
            for stage in range(n):
                if constant:
                    w[i, stage, 0] = state.constant[read.state]
                else:
                    past = self.evaluate_history(values.p, t - (stage + 1) * delta)
                    w[i, stage] = [past[d][read.state] * delta**d for d in range(order)]

    def advance(
        self,
        values: ParameterValues,
        state: IntegratorState,
        t_stop: float,
        log: Log | None = None,
        on_progress: Callable[[float], None] | None = None,
        on_log_full: Callable[[Log], None] | None = None,
    ) -> tuple[IntegratorState, Status]:
        """Integrate to ``t_stop`` or to the next return to the section; return the state and which of the two it was.

        The state is another one where it needed more capacity. ``on_progress`` is called with times reached,
        ``on_log_full`` with a full log, which it empties.

        Raises
        ------
        ConvergenceError
            If events accumulate and do not stick, if the solution grows without bound, or if no step is small enough.
        """
        nothing = log if log is not None else make_log(self.system.n, 0, 0)
        while True:
            values, state = self.reached.fit(values, state)
            status = run(self.system, values, state, nothing, self.work, t_stop, STEPS_AT_ONCE)
            if on_progress:
                on_progress(float(state.clock[T]))
            if status in (Status.REACHED, Status.SECTION):
                return state, Status(status)
            if status == Status.LOG_FULL and on_log_full is not None:
                on_log_full(nothing)
            elif status in (Status.CAPACITY, Status.NEW_WAY):
                state = self.make_room(values, state, Status(status))
            elif status != Status.PAUSED:
                raise ConvergenceError(describe_failure(self.diagnose(state, Status(status), values.p)))

    def make_room(self, values: ParameterValues, state: IntegratorState, status: Status) -> IntegratorState:
        """Return the state of an integration that came back for want of capacity, or of a mode, to be called again."""
        if status == Status.CAPACITY:
            return enlarge(state)
        self.reached.add_way(values)
        return self.reached.fit(values, state)[1]

    def diagnose(self, state: IntegratorState, status: Status, p: Array) -> MotionFailure:
        """Return why an integration at parameters ``p`` came to a halt."""
        read_last = np.array(self.work.xd[: len(self.numeric.model.read_symbols)])
        failure = diagnose_halt(self.numeric, self.tables, state, status, p, read_last)
        return replace(failure, is_stiff=self.method.stiff)


def _refuse_delay_method(model: Model, delay: DelayMethod) -> None:
    why = explain_direct_only(model)
    if why and (delay.simulated_stages != (0, 0) or delay.stages is not None):
        raise ConvergenceError(f"{why}: only the direct method reads such a past; give 'delay: {{method: direct}}'")


def _refuse_tangent(model: Model) -> None:
    """Refuse the tangent where jumps come back in ways that it does not follow."""
    rates = list_rates(model)
    if rates:
        raise ConvergenceError(
            f"Lyapunov exponents are not computed for models that read rates of the past ({rates[0]}): jumps of the "
            "rate never end there"
        )
    if model.integrals and not model.smooth:
        raise ConvergenceError(
            "Lyapunov exponents are not computed for models that have events and integrals over the past"
        )
