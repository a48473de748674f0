"""A model in the numbers that the compiled integrator works with."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.delay import DelayMethod
from pddecont.errors import ConvergenceError
from pddecont.model import reads_generally
from pddecont.simulate.integrator import ParameterValues, System
from pddecont.simulate.method import Method
from pddecont.simulate.part_tables import DIRECTIONS, PartTables, integers
from pddecont.simulate.past_plan import evaluate_limits, find_integrated, list_integrand_cases
from pddecont.simulate.returns import ReturnSection

Array = NDArray[np.float64]


def make_system(
    numeric: NumericModel,
    tables: PartTables,
    delay: DelayMethod,
    method: Method,
    section: ReturnSection,
    *,
    tangent: bool,
) -> System:
    """Return the model in numbers: addresses of its functions, and the modes, events and segments of its tables.

    A section that is an expression is one more event function, numbered after the model's own.
    """
    model, n, plan = numeric.model, numeric.n_states, tables.plan
    order, length = delay.simulated_stages
    reads = [(d.state, slot, d.derivative) for d, slot in zip(model.delayed, plan.slots, strict=True)]
    pairs = np.array(reads + [(-1, -1, 0)] * len(model.integrals), dtype=np.int64).reshape(-1, 3)
    integrated = [model.states.index(s.name) for i in model.integrals for s in find_integrated(model, i)]
    kept = np.unique([*(d.state for d in model.delayed), *integrated]).astype(np.int64)
    place = np.full(n, -1)
    place[kept] = np.arange(len(kept))
    is_rate = tables.find_rates()
    turns = np.array(plan.turns, dtype=np.int64).reshape(-1, 2)
    return System(
        **tables.make_tables(with_jacobians=tangent or method.stiff or any(is_rate), tangent=tangent),
        history=tables.functions.history,
        n=n,
        n_full=n + len(pairs) * order * length,
        tangent=int(tangent),
        pair_state=np.ascontiguousarray(pairs[:, 0]),
        pair_delay=np.ascontiguousarray(pairs[:, 1]),
        kept=kept,
        place=place,
        n_digits=len(tables.functions.digits),
        n_keys=tables.n_keys,
        chain_order=order,
        chain_n=length,
        section=-1 if section.expr is None else len(tables.events),
        section_direction=DIRECTIONS[section.direction],
        stop_event=-1 if section.event is None else tables.events[section.event],
        stiff=int(method.stiff),
        n_modes=len(tables.modes),
        is_general=int(reads_generally(model)),
        n_values=len(model.delayed),
        n_varying=len(plan.varying),
        n_integrals=len(model.integrals),
        n_turns=len(turns),
        n_first_turns=plan.n_first,
        pair_derivative=np.ascontiguousarray(pairs[:, 2]),
        is_rate=integers(is_rate),
        turn_kind=np.ascontiguousarray(turns[:, 0]),
        turn_number=np.ascontiguousarray(turns[:, 1]),
        low=integers(plan.low),
        high=integers(plan.high),
        gain=integers(plan.gains),
        lags=tables.functions.compile_cases([[lag] for lag in plan.varying]) if plan.varying else 0,
        integrands=tables.functions.compile_cases(list_integrand_cases(model)) if model.integrals else 0,
    )


def make_values(
    numeric: NumericModel, tables: PartTables, delay: DelayMethod, method: Method, p: Array, longest: float
) -> ParameterValues:
    """Return the model's numbers at parameters ``p``; the past is kept for ``longest``, or the longest delay.

    No step is longer than half the period of the forcing, nor than the shortest delay where delayed values come from
    the past.
    """
    model = numeric.model
    delays = np.asarray(numeric.delays.value(p), dtype=float)
    for read in model.delayed:
        if read.derivative and read.delay < len(delays) and delays[read.delay] == 0.0:
            raise ConvergenceError(
                f"the rate {model.states[read.state]}'(t - {model.find_delay(read)}) is read at a delay of zero, which "
                "is the rate itself: write the equation solved for it"
            )
    tau = np.concatenate([delays, evaluate_limits(numeric, tables.plan, p)])
    bounds = [method.max_step]
    if delay.simulated_stages == (0, 0):
        bounds += [x for x in delays if x > 0]
    if model.forced:
        bounds.append(float(numeric.period.value(p)[0]) / 2)
    return ParameterValues(
        p=np.array(p, dtype=float),
        tau=tau,
        event_delay=_list_event_delays(numeric, tables, p),
        max_step=float(min(bounds)),
        rtol=method.rtol,
        atol=method.atol,
        longest=max(longest, float(max(tau, default=0.0))),
    )


def fit_values(values: ParameterValues, numeric: NumericModel, tables: PartTables) -> ParameterValues:
    """Return the model's numbers with those of events that are new in its tables."""
    if len(values.event_delay) == len(tables.events) + (tables.section is not None):
        return values
    return values._replace(event_delay=_list_event_delays(numeric, tables, values.p))


def _list_event_delays(numeric: NumericModel, tables: PartTables, p: Array) -> Array:
    """Return the delays of events, 0 where they have none."""
    events = [numeric.model.events[name] for name in tables.events]
    delays = [0.0 if e.delay is None else float(numeric.event_delay(e.name).value(p)[0]) for e in events]
    return np.array(delays + [0.0] * (tables.section is not None))
