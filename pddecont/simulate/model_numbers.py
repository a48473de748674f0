"""A model in the numbers that the compiled integrator works with."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import ModelFunctions, NumericModel
from pddecont.delay import DelayMethod
from pddecont.model import (
    Model,
    find_rest,
    list_alternatives,
    list_clocks,
    list_held,
    list_leaders,
    list_opposite,
    list_transitions,
)
from pddecont.simulate.integrator import ParameterValues, System
from pddecont.simulate.method import Method
from pddecont.simulate.returns import ReturnSection

Array = NDArray[np.float64]
DIRECTIONS = {"rising": 1, "falling": -1, "any": 0}


def make_system(
    numeric: NumericModel,
    functions: ModelFunctions,
    delay: DelayMethod,
    method: Method,
    section: ReturnSection,
    *,
    tangent: bool,
) -> System:
    """Return the model in numbers: addresses of its functions, and its modes, events and segments by number.

    A section that is an expression is one more event function, numbered after the model's own.
    """
    model, n = numeric.model, numeric.n_states
    order, length = delay.simulated_stages
    pairs = np.array([(d.state, d.delay) for d in model.delayed], dtype=np.int64).reshape(-1, 2)
    kept = np.unique(pairs[:, 0])
    place = np.full(n, -1)
    place[kept] = np.arange(len(kept))
    delayed, events = set(model.delayed_symbols), list(model.events)
    after = [
        next(number for number, other in enumerate(model.events.values()) if other.starts(e)) if e.after else -1
        for e in model.events.values()
    ]
    return System(
        field=functions.field,
        field_case=_integers(functions.cases.of_mode),
        event=functions.event,
        reset=functions.reset,
        guard=functions.guard,
        repulsion=functions.repulsion,
        history=functions.history,
        field_jacobian=functions.field_jacobian if tangent or method.stiff else 0,
        event_jacobian=functions.event_jacobian,
        reset_jacobian=functions.reset_jacobian if tangent else 0,
        n=n,
        n_full=n + len(pairs) * order * length,
        tangent=int(tangent),
        pair_state=np.ascontiguousarray(pairs[:, 0]),
        pair_delay=np.ascontiguousarray(pairs[:, 1]),
        kept=kept,
        place=place,
        segment_guard=_integers(functions.guard_numbers),
        segment_repulsion=_integers(functions.repulsion_numbers),
        **_number_parts(model),
        resting=_number_resting(model, method.stick),
        after=_integers([*after, *([] if section.expr is None else [-1])]),
        reads=_integers(bool(delayed & h.free_symbols) for h in functions.events),
        chain_order=order,
        chain_n=length,
        section=-1 if section.expr is None else len(events),
        section_direction=DIRECTIONS[section.direction],
        stop_event=-1 if section.event is None else events.index(section.event),
        stiff=int(method.stiff),
        n_modes=len(model.modes),
    )


def make_values(
    numeric: NumericModel, delay: DelayMethod, method: Method, section: ReturnSection, p: Array, longest: float
) -> ParameterValues:
    """Return the model's numbers at parameters ``p``; the past is kept for ``longest``, or the longest delay.

    No step is longer than half the period of the forcing, nor than the shortest delay where delayed values come from
    the past.
    """
    model = numeric.model
    tau = np.asarray(numeric.delays.value(p), dtype=float)
    event_delay = [
        float(numeric.event_delay(e.name).value(p)[0]) if e.delay is not None else 0.0 for e in model.events.values()
    ]
    event_delay += [0.0] * (section.expr is not None)
    bounds = [method.max_step]
    if delay.simulated_stages == (0, 0):
        bounds += [x for x in tau if x > 0]
    if model.forced:
        bounds.append(float(numeric.period.value(p)[0]) / 2)
    return ParameterValues(
        p=np.array(p, dtype=float),
        tau=tau,
        event_delay=np.array(event_delay),
        max_step=float(min(bounds)),
        rtol=method.rtol,
        atol=method.atol,
        longest=max(longest, float(max(tau, default=0.0))),
    )


def _number_parts(model: Model) -> dict[str, NDArray[np.int64]]:
    """Return the tables of a model's modes, events and segments, by their names in :class:`System`."""
    modes, events, resets, names = map(_number, (model.modes, model.events, model.resets, model.segments))
    segments, ending = model.segments.values(), [list_transitions(model, mode) for mode in modes]
    groups = {
        "crossing_first crossing_segment": [[names[s.name] for s in list_leaders(e.crossings)] for e in ending],
        "ending_first ending_segment": [[names[s.name] for s in list_leaders(e.segments)] for e in ending],
        "held_first held_event": [[events[e] for e in list_held(model, mode)] for mode in modes],
        "clock_first clock_event": [[events[e] for e in list_clocks(model, event)] for event in events],
    }
    tables = {
        "segment_mode": _integers(modes[s.mode] for s in segments),
        "segment_event": _integers(events[s.event] for s in segments),
        "segment_direction": _integers(DIRECTIONS[s.direction] for s in segments),
        "segment_reset": _integers(resets[s.reset] for s in segments),
        "segment_to": _integers(modes[s.to] for s in segments),
        "alternatives": _count_alternatives(model),
        "segment_opposite": _integers(-1 if other is None else names[other] for other in list_opposite(model)),
    }
    for both, lists in groups.items():
        tables |= dict(zip(both.split(), _group(lists), strict=True))
    return tables


def _count_alternatives(model: Model) -> NDArray[np.int64]:
    leaders = {s.name: len(list_alternatives(model, s)) for s in list_leaders(model.segments.values())}
    return _integers(leaders.get(name, 0) for name in model.segments)


def _number_resting(model: Model, stick: Mapping[str, str]) -> NDArray[np.int64]:
    """Return the number of what each segment is where the motion rests; at events in ``stick`` in that mode."""
    numbers = _number(model.segments)
    found = (find_rest(model, s, stick.get(s.event)) for s in model.segments.values())
    return _integers(-1 if rest is None else numbers[rest.name] for rest in found)


def _number(names: Iterable[str]) -> dict[str, int]:
    return {name: number for number, name in enumerate(names)}


def _group(lists: Iterable[Sequence[int]]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return lists one after the other, and where each begins and the last one ends."""
    all_lists = list(lists)
    return _integers([0, *np.cumsum([len(a) for a in all_lists])]), _integers(n for a in all_lists for n in a)


def _integers(numbers: Iterable[int]) -> NDArray[np.int64]:
    return np.array(list(numbers), dtype=np.int64)
