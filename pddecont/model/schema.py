"""The shape of a model file: which keys, which kinds of values."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, TypeAdapter, model_validator
from pydantic_core import PydanticCustomError

from pddecont.model.validation import Formula, Identifier, NewName, Strict


class Forcing(Strict):
    """Present when ``t`` appears in the model: the period after which the model repeats itself."""

    period: Formula = Field(description="period of everything that depends on t")


class DelayedEvent(Strict):
    """An event that happens a fixed time after another."""

    after: Identifier = Field(description="event that starts the clock")
    delay: Formula = Field(description="time from that event to this one")


class DelayCondition(Strict):
    """A delay that a condition defines."""

    where: str = Field(description="equation that the delay meets, as in 'integral(x(t - s), s, 0, tau) = 1'")


class Alternative(Strict):
    """One of the modes that a segment may lead to."""

    when: Formula | None = Field(None, description="condition on the states after the reset; without it: always")
    mode: Identifier = Field(description="mode that follows then")


Alternatives = Annotated[list[Alternative], Field(min_length=1)]


def _target(value: Any) -> Any:
    return TypeAdapter(Alternatives).validate_python(value) if isinstance(value, list) else value


Target = Annotated[Identifier | Alternatives, BeforeValidator(_target)]


class Segment(Strict):
    """A smooth arc: where it runs, what ends it, what happens then, where it leads."""

    mode: Identifier = Field(description="mode whose vector field holds")
    event: Identifier = Field(description="event that ends the segment")
    direction: Literal["rising", "falling", "any"] = Field("any", description="how the event function passes zero")
    reset: Identifier = Field("identity", description="reset applied at the event")
    to: Target = Field(description="mode that follows; or a list of {when: condition, mode}, of which the first holds")
    rest: Identifier | None = Field(None, description="mode in which the motion rests where such impacts accumulate")


class Jump(Strict):
    """An event that changes states, in a model given by its equations."""

    at: Formula | None = Field(None, description="function whose zero the event is")
    direction: Literal["rising", "falling", "any"] = Field("any", description="how that passes zero")
    after: Identifier | None = Field(None, description="jump or switch that starts the clock")
    delay: Formula | None = Field(None, description="time from that event to this one")
    every: Formula | None = Field(None, description="time between two of them; in forced models, at multiples of it")
    reset: dict[Identifier, Formula] = Field(min_length=1, description="states after the event")
    only: dict[Identifier, Literal["+", "-", "0"]] = Field(
        default_factory=dict, alias="in", description="signs of switches with which it happens (0: sliding)"
    )
    when: Formula | None = Field(None, description="condition under which it happens")
    rest: bool = Field(False, description="after impacts that accumulate the motion rests at the zero of 'at'")

    @model_validator(mode="after")
    def _says_when(self) -> Jump:
        ways = [self.at is not None, self.after is not None, self.every is not None]
        if sum(ways) != 1:
            raise PydanticCustomError(
                "jump", "a jump has one of 'at' (function), 'after' (event) and 'every' (time)", {}
            )
        if (self.after is None) != (self.delay is None):
            raise PydanticCustomError("jump", "'after' and 'delay' belong together", {})
        if self.direction != "any" and self.at is None:
            raise PydanticCustomError("jump", "'direction' belongs to 'at'", {})
        return self


class Effect(Strict):
    """A part of the model that a run may leave out, and what leaving it out means."""

    set: dict[Identifier, Formula] = Field(default_factory=dict, description="parameter values without the effect")
    drop: list[Identifier] = Field(default_factory=list, description="events that never happen without the effect")

    @model_validator(mode="after")
    def _says_something(self) -> Effect:
        if not self.set and not self.drop:
            raise PydanticCustomError("effect", "an effect needs 'set' (parameter values) or 'drop' (events)", {})
        return self


def _event(value: Any) -> Any:
    return DelayedEvent.model_validate(value) if isinstance(value, dict) else value


Event = Annotated[Formula | DelayedEvent, BeforeValidator(_event)]


def _delay(value: Any) -> Any:
    return DelayCondition.model_validate(value) if isinstance(value, dict) else value


Delay = Annotated[Formula | DelayCondition, BeforeValidator(_delay)]


class ModelFile(Strict):
    """A piecewise-smooth delay differential equation."""

    name: str = Field(description="name of the model")
    reference: str | None = Field(None, description="where the model comes from")
    states: list[NewName] = Field(min_length=1, description="names of the states")
    parameters: dict[NewName, float] = Field(default_factory=dict, description="parameters and their values")
    units: dict[Identifier, str] = Field(
        default_factory=dict, description="units of states, parameters, definitions and t, for pictures"
    )
    definitions: dict[NewName, Formula] = Field(default_factory=dict, description="named parts of expressions")
    delays: dict[NewName, Delay] = Field(
        default_factory=dict, description="named delays: expressions, or conditions that define them"
    )
    forcing: Forcing | None = None
    equations: dict[str, Formula] = Field(
        default_factory=dict,
        description="the vector field {x': expression}, nonsmooth functions allowed; then no modes",
    )
    switches: dict[NewName, Formula] = Field(
        default_factory=dict, description="names for arguments of nonsmooth functions in 'equations'"
    )
    jumps: dict[NewName, Jump] = Field(default_factory=dict, description="with 'equations': events that change states")
    modes: dict[Identifier, dict[str, Formula]] = Field(
        default_factory=dict, description="vector fields: {x': expression}"
    )
    events: dict[Identifier, Event] = Field(
        default_factory=dict, description="event functions; the event is their zero"
    )
    resets: dict[Identifier, dict[Identifier, Formula]] = Field(
        default_factory=dict, description="states after the event"
    )
    segments: dict[Identifier, Segment] = Field(default_factory=dict, description="arcs that a signature is made of")
    effects: dict[Identifier, Effect] = Field(default_factory=dict, description="parts that a run may leave out")
    initial: dict[str, Formula] = Field(default_factory=dict, description="mode and history for t <= 0")
    run: dict[str, Any] | None = Field(None, description="the run that 'pddecont run' does on this file")
