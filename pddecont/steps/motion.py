"""How motions are computed and where they start: what a file says of it, and what that comes to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
import sympy
from pydantic import BeforeValidator, ConfigDict, Field, WithJsonSchema, model_validator
from pydantic_core import PydanticCustomError

from pddecont.errors import RunError, suggest
from pddecont.model import ExpressionError, Formula, Identifier, Model, Strict, explain_start_beyond_event
from pddecont.runfile import ParameterFormula, Path, StepInput
from pddecont.simulate import InitialState, Method


class Integration(Strict):
    """How trajectories are computed."""

    rtol: float = Field(1e-9, gt=0, lt=1, description="relative error allowed in a step")
    atol: float = Field(1e-11, gt=0, description="absolute error allowed in a step")
    method: Literal["explicit", "stiff"] = Field(
        "explicit", description="explicit: DOP853; stiff: Radau IIA of order 5"
    )
    max_step: Formula | None = Field(
        None, description="longest step, where an event function has features that longer ones would miss"
    )
    stick: dict[Identifier, Identifier] = Field(
        default_factory=dict, description="mode to go on in where an event accumulates, by event"
    )


def _check_history(value: Any) -> Any:
    words = ("model", "constant")
    if isinstance(value, dict) or value in words:
        return value
    raise PydanticCustomError(
        "history",
        "expected model, constant, or a mapping of states to expressions in t; found {value}",
        {"value": repr(value)},
    )


History = Annotated[
    Any,
    BeforeValidator(_check_history),
    WithJsonSchema(
        {
            "anyOf": [
                {"enum": ["model", "constant"]},
                {"type": "object", "additionalProperties": {"anyOf": [{"type": "number"}, {"type": "string"}]}},
            ]
        }
    ),
]


class Initial(Strict):
    """Where a trajectory starts: any states by name, the mode, the history before."""

    model_config = ConfigDict(extra="allow")
    mode: Identifier | None = Field(None, description="mode at the start")
    history: History = Field(
        "model", description="before the start: the model's, constant (the initial states), or expressions in t"
    )

    @property
    def states(self) -> dict[str, str | float]:
        """The states that are given, by name."""
        return dict(self.model_extra or {})

    @model_validator(mode="after")
    def _check_numbers(self) -> Initial:
        for name, value in self.states.items():
            if isinstance(value, bool) or not isinstance(value, (str, int, float)):
                raise PydanticCustomError("state", "'{name}' takes a number or an expression", {"name": name})
        return self


@dataclass(frozen=True, eq=False)
class Start:
    """Where a motion starts, as expressions in the parameters.

    Attributes
    ----------
    states
        States that are given, by name.
    mode
        The mode; None where it is read from the states.
    constant
        Whether the states are its history too.
    history
        Expressions in t before the start, one a state; None for the model's own.
    """

    model: Model
    states: Mapping[str, ParameterFormula]
    mode: str | None
    constant: bool
    history: tuple[sympy.Expr, ...] | None

    def evaluate(self, values: Mapping[str, float]) -> InitialState:
        """Return where the motion starts at parameters of these ``values``.

        States that are not given are those of the history at t = 0.

        Raises
        ------
        RunError
            If a formula has no value.
        ExpressionError
            If the history has none at t = 0.
        """
        past = zip(self.model.states, self.history or self.model.history, strict=True)
        states = [
            self.states[s].evaluate(values) if s in self.states else self.model.evaluate(e, values, 0.0)
            for s, e in past
        ]
        return InitialState(np.array(states), self.mode, self.constant)


def resolve_method(given: StepInput[Any], body: Integration) -> Method:
    """Return how a step integrates; note what is wrong with it."""
    model = given.model
    for event, mode in body.stick.items():
        if event not in model.events:
            hint = model.hint("events", event, model.events)
            given.add_error(("stick", event), f"'{event}' is not an event{hint}", key=True)
        if mode not in model.modes:
            known = f"{suggest(mode, model.modes)} (modes: {', '.join(model.modes)})"
            given.add_error(("stick", event), f"mode '{mode}' is not defined{known}")
    longest = np.inf if body.max_step is None else resolve_time(given, ("max_step",), body.max_step)
    if given.delay.method == "chebyshev":
        given.add_error(
            (),
            "trajectories are computed with the delay itself or the chain, not with a Chebyshev delay line; give this "
            "step 'delay: {method: direct}'",
            key=True,
        )
    return Method(body.rtol, body.atol, body.method == "stiff", dict(body.stick), longest)


def resolve_time(given: StepInput[Any], path: Path, text: str | float) -> float:
    """Return a time that must be positive."""
    time = given.evaluate(path, text)
    if time <= 0:
        given.add_error(path, f"{path[-1]} is {time:g}; expected a positive time")
    return time


def resolve_start(given: StepInput[Any], path: Path, initial: Initial) -> Start:
    """Return where a motion starts; note what is wrong with it."""
    model = given.model
    if initial.mode is not None and initial.mode not in model.modes:
        known = f"(modes: {', '.join(model.modes)})"
        given.add_error((*path, "mode"), f"mode '{initial.mode}' is not defined {known}")
    # A state that an effect took along may still be given: what it begins with means nothing then.
    states = [*model.states, *model.left_out.reasons.get("states", ())]
    formulas = {}
    for name, text in initial.states.items():
        if name not in states:
            given.add_error((*path, name), f"'{name}' is not a state{suggest(name, states)}", key=True)
            continue
        formulas[name] = given.parse_formula((*path, name), text)
        given.checker.evaluate_formula((*given.path, *path, name), formulas[name], given.values)
    history = _resolve_history(given, path, initial, states)
    mode = initial.mode or (model.initial_mode if model.derived is None else None)
    return Start(model, formulas, mode, initial.history == "constant", history)


def _resolve_history(
    given: StepInput[Any], path: Path, initial: Initial, states: list[str]
) -> tuple[sympy.Expr, ...] | None:
    if not isinstance(initial.history, Mapping):
        return None
    model, expressions = given.model, {}
    for name, text in initial.history.items():
        here = (*path, "history", name)
        if name not in states:
            given.add_error(here, f"'{name}' is not a state{suggest(name, states)}", key=True)
        expressions[name] = given.parse(here, text, model.history_scope())
    return tuple(expressions.get(s, e) for s, e in zip(model.states, model.history, strict=True))


def evaluate_start(given: StepInput[Any], path: Path, start: Start) -> InitialState:
    """Return where a motion starts at the step's own parameters; note where that has no value."""
    try:
        return start.evaluate(given.values)
    except ExpressionError as exc:
        given.add_error(path, f"the history at t = 0 {exc}")
    except RunError:
        pass  # what has no value was noted where it was parsed
    return InitialState(np.zeros(len(given.model.states)), start.mode, start.constant)


def warn_of_start(given: StepInput[Any], initial: Initial, start: InitialState) -> None:
    """Note where a motion starts beyond an event that ends its mode."""
    if isinstance(initial.history, Mapping) or start.mode is None or start.mode not in given.model.modes:
        return
    message = explain_start_beyond_event(given.model, start.mode, start.states.tolist(), given.values)
    if message:
        given.add_warning(("initial",) if initial.states else (), message)
