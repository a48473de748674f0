"""The ``simulate`` step: a trajectory from the model's initial state or history."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray
from pydantic import Field

from pddecont.model import Formula, Identifier, Strict
from pddecont.results import SIMULATE
from pddecont.runfile import Holding, StepInput, as_number
from pddecont.simulate import InitialState, Method
from pddecont.steps.kind import Sharing, StepKind
from pddecont.steps.motion import (
    Initial,
    Integration,
    evaluate_start,
    resolve_method,
    resolve_start,
    resolve_time,
    warn_of_start,
)

Array = NDArray[np.float64]
# What one step may hold at most.
MAX_SAMPLES = 100_000_000


class Record(Strict):
    """What is kept of a trajectory."""

    from_: Formula = Field(0.0, alias="from", description="time from which on it is kept")
    every: Formula | None = Field(None, description="time between the samples that are written (default: four a step)")
    signals: dict[Identifier, Formula] = Field(
        default_factory=dict, description="expressions recorded along it, delayed values too"
    )


class Simulate(Integration):
    """Integrate from an initial state or history."""

    t_end: Formula = Field(description="time at which to stop")
    initial: Initial = Field(default_factory=lambda: Initial.model_validate({}))
    at: dict[str, dict[Identifier, Formula]] = Field(
        default_factory=dict, description="parameters that change, by time"
    )
    record: Record = Field(default_factory=lambda: Record.model_validate({}))


@dataclass(frozen=True, eq=False)
class SimulateSettings:
    """What a simulate step does.

    Attributes
    ----------
    parameters
        Parameters at the start, shape (n_parameters,).
    history
        The expressions in t before the start that the step gives; None for the model's.
    past
        The history, whoever gives it, one expression in t a state.
    schedule
        The times at which parameters change, in order, with the parameters from then on.
    record_from, record_every
        The time from which on it is kept, and that between samples (None: four a step).
    signals
        Expressions recorded along it, by name.
    """

    parameters: Array
    method: Method
    start: InitialState
    history: tuple[sympy.Expr, ...] | None
    past: tuple[sympy.Expr, ...]
    t_end: float
    schedule: tuple[tuple[float, Array], ...]
    record_from: float
    record_every: float | None
    signals: Mapping[str, sympy.Expr]

    @property
    def stages(self) -> list[tuple[float, Array]]:
        """Times, the first minus infinity, with the parameters that hold from each on."""
        return [(-np.inf, self.parameters), *self.schedule]

    @property
    def last_parameters(self) -> Array:
        """Parameters at the end."""
        return self.stages[-1][1]


def resolve_simulate(given: StepInput[Simulate]) -> SimulateSettings:
    """Return what a simulate step does; note what is wrong with it."""
    body, model = given.body, given.model
    t_end = resolve_time(given, ("t_end",), body.t_end)
    start = resolve_start(given, ("initial",), body.initial)
    initial = evaluate_start(given, ("initial",), start)
    warn_of_start(given, body.initial, initial)
    method = resolve_method(given, body)
    schedule = _resolve_schedule(given, t_end)
    since = given.evaluate(("record", "from"), body.record.from_)
    if not 0 <= since < t_end and t_end > 0:
        given.add_error(("record", "from"), f"the time {since:g} does not lie between 0 and t_end, {t_end:g}")
    signals = _resolve_signals(given)
    every = None if body.record.every is None else resolve_time(given, ("record", "every"), body.record.every)
    if every is not None and (t_end - since) > MAX_SAMPLES * every:
        given.add_error(("record", "every"), f"more than {MAX_SAMPLES} samples; take longer times between them")
    past = start.history or model.history
    if start.constant:
        past = tuple(sympy.Float(x) for x in initial.states)
    return SimulateSettings(
        given.parameters, method, initial, start.history, past, t_end, schedule, since, every, signals
    )


def _resolve_schedule(given: StepInput[Simulate], t_end: float) -> tuple[tuple[float, Array], ...]:
    later, schedule = dict(given.values), []
    times = {text: given.evaluate(("at", text), as_number(text)) for text in given.body.at}
    for text, time in sorted(times.items(), key=lambda pair: pair[1]):
        here = ("at", text)
        if not 0 < time < t_end and t_end > 0:
            given.add_error(here, f"the time {time:g} does not lie between 0 and t_end, {t_end:g}", key=True)
        for name, value in given.body.at[text].items():
            if given.check_settable((*here, name), name):
                later[name] = given.evaluate((*here, name), value, later)
        given.check_durations(here, later)
        p = given.numeric.with_fixed(np.array([later[name] for name in given.model.parameters]))
        later = dict(zip(given.model.parameters, p.tolist(), strict=True))
        schedule.append((time, p))
    return tuple(schedule)


def _resolve_signals(given: StepInput[Simulate]) -> dict[str, sympy.Expr]:
    model, signals = given.model, {}
    scope = model.scope("a signal", delayed=model.delayed_value)
    for name, text in given.body.record.signals.items():
        here = ("record", "signals", name)
        if name in model.states:
            given.add_error(here, f"'{name}' is a state already; give the signal another name", key=True)
        signals[name] = given.parse(here, text, scope)
        if given.delay.method == "chain" and signals[name].free_symbols & set(model.delayed_symbols):
            given.add_error(
                here, "a chain has no delayed values of its own to record; give this step 'delay: {method: direct}'"
            )
    return signals


def list_simulate_names(body: Simulate) -> Iterator[Any]:
    """Return the texts of a simulate step whose names the model must have."""
    yield from body.record.signals.values()


def list_simulate_modes(body: Simulate) -> Iterator[str]:
    """Return the modes that the motion is put into."""
    yield from body.stick.values()
    yield from [] if body.initial.mode is None else [body.initial.mode]


def list_simulate_varied(body: Simulate) -> Iterator[str]:
    """Return the parameters that change along the motion."""
    for changes in body.at.values():
        yield from changes


SIMULATE_STEP = StepKind(
    name="simulate",
    fields=Simulate,
    resolve=resolve_simulate,
    format=SIMULATE,
    run="pddecont.steps.execution.simulate:run_simulate",
    sharing=Sharing.EARLY,
    holds=Holding.TRAJECTORY,
    list_names=list_simulate_names,
    list_modes=list_simulate_modes,
    list_sticks=lambda body: body.stick.items(),
    list_varied=list_simulate_varied,
)
