"""A model in the numbers that the compiled integrator works with."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.delay import DelayMethod
from pddecont.simulate.integrator import ParameterValues, System
from pddecont.simulate.method import Method
from pddecont.simulate.part_tables import DIRECTIONS, PartTables
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
    model, n = numeric.model, numeric.n_states
    order, length = delay.simulated_stages
    pairs = np.array([(d.state, d.delay) for d in model.delayed], dtype=np.int64).reshape(-1, 2)
    kept = np.unique(pairs[:, 0])
    place = np.full(n, -1)
    place[kept] = np.arange(len(kept))
    return System(
        **tables.make_tables(with_jacobians=tangent or method.stiff, tangent=tangent),
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
    )


def make_values(
    numeric: NumericModel, tables: PartTables, delay: DelayMethod, method: Method, p: Array, longest: float
) -> ParameterValues:
    """Return the model's numbers at parameters ``p``; the past is kept for ``longest``, or the longest delay.

    No step is longer than half the period of the forcing, nor than the shortest delay where delayed values come from
    the past.
    """
    model = numeric.model
    tau = np.asarray(numeric.delays.value(p), dtype=float)
    bounds = [method.max_step]
    if delay.simulated_stages == (0, 0):
        bounds += [x for x in tau if x > 0]
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
