"""The ``equilibrium`` step: states of one mode that stay, from a guess, a simulation, or all of those in a box."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator
from pydantic_core import PydanticCustomError

from pddecont.errors import suggest
from pddecont.model import Identifier, Strict
from pddecont.results import EQUILIBRIUM
from pddecont.runfile import Holding, ParameterFormula, Source, StepInput
from pddecont.steps.fields import Range
from pddecont.steps.kind import Sharing, StepKind

# Keys that say that ``from`` names a step.
SOURCE_KEYS = {"step", "file", "point", "index"}


def _as_start(value: Any) -> Any:
    """Return a source where a step is named, else states by name."""
    if isinstance(value, str):
        return Source.model_validate({"step": value})
    if isinstance(value, dict) and SOURCE_KEYS & set(value):
        return Source.model_validate(value)
    if not isinstance(value, dict) or any(
        isinstance(v, bool) or not isinstance(v, str | int | float) for v in value.values()
    ):
        raise PydanticCustomError(
            "start", "expected the name of a step, or states with their values: {x: 0}", {"x": "{x: 0}"}
        )
    return value


Start = Annotated[
    Any,
    BeforeValidator(_as_start),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "string"},
                {"type": "object", "additionalProperties": {"anyOf": [{"type": "number"}, {"type": "string"}]}},
            ]
        }
    ),
]


class Equilibrium(Strict):
    """Find an equilibrium near a guess or a simulation's end, or all of them in a box."""

    start: Start | None = Field(
        None, alias="from", description="states as a first guess (default: the model's initial ones), or a step"
    )
    mode: Identifier | None = Field(
        None, description="mode in which it stays (default: that of the guess; all of them in a search)"
    )
    search: dict[Identifier, Range] | None = Field(
        None, description="lowest and highest value of each state: every equilibrium in this box"
    )
    roots: int = Field(12, ge=1, le=1000, description="number of leading characteristic roots")

    @property
    def from_(self) -> Source | None:
        """The step that it starts from, if it does."""
        return self.start if isinstance(self.start, Source) else None

    @model_validator(mode="after")
    def _check_one(self) -> Equilibrium:
        if self.search is not None and self.start is not None:
            raise PydanticCustomError("search", "'from' and 'search' exclude each other", {})
        return self


@dataclass(frozen=True, eq=False)
class EquilibriumSettings:
    """What an equilibrium step does.

    Attributes
    ----------
    guess
        States to start from, by name; the model's initial ones for those that are not named.
    mode
        The mode (None: that of the guess, or all modes in a search).
    box
        Lowest and highest value of each state by name, where all equilibria are looked for; None otherwise.
    n_roots
        Number of characteristic roots that are recorded.
    """

    guess: Mapping[str, ParameterFormula]
    mode: str | None
    box: Mapping[str, tuple[float, float]] | None
    n_roots: int


def resolve_equilibrium(given: StepInput[Equilibrium]) -> EquilibriumSettings:
    """Return what an equilibrium step does; note what is wrong with it."""
    body, model = given.body, given.model
    if model.forced:
        given.add_error(
            (),
            "a forced model has no equilibria: its motions follow the forcing; look for its periodic orbit with "
            "'simulate' and 'orbit', or leave the forcing out as an effect",
            key=True,
        )
    if body.mode is not None and body.mode not in model.modes:
        hint = f"{suggest(body.mode, model.modes)} (modes: {', '.join(model.modes)})"
        given.add_error(("mode",), f"mode '{body.mode}' is not defined{hint}")
    if given.source is not None and given.source_holds not in (
        None,
        Holding.TRAJECTORY,
        Holding.EQUILIBRIA,
        Holding.BRANCH,
    ):
        given.add_error(("from",), f"'{given.source.step}' holds no equilibrium; start from a simulation or a guess")
    guess = {}
    for name, text in (body.start if isinstance(body.start, dict) else {}).items():
        here = ("from", name)
        if name not in model.states:
            given.add_error(here, f"'{name}' is not a state{suggest(name, model.states)}", key=True)
            continue
        guess[name] = given.parse_formula(here, text)
        given.checker.evaluate_formula((*given.path, *here), guess[name], given.values)
    return EquilibriumSettings(guess, body.mode, _resolve_box(given), body.roots)


def _resolve_box(given: StepInput[Equilibrium]) -> dict[str, tuple[float, float]] | None:
    if given.body.search is None:
        return None
    box = {}
    for name, limits in given.body.search.items():
        here = ("search", name)
        if name not in given.model.states:
            given.add_error(here, f"'{name}' is not a state{suggest(name, given.model.states)}", key=True)
            continue
        low, high = (given.evaluate((*here, k), text) for k, text in enumerate(limits))
        if not low < high:
            given.add_error(here, f"the range is empty: {low:g} is not below {high:g}")
        box[name] = (low, high)
    missing = [name for name in given.model.states if name not in box]
    if missing:
        given.add_error(("search",), f"the box has no range for {', '.join(missing)}; give each state one")
    return box


def list_equilibrium_modes(body: Equilibrium) -> Iterator[str]:
    """Return the mode that is named."""
    yield from [] if body.mode is None else [body.mode]


EQUILIBRIUM_STEP = StepKind(
    name="equilibrium",
    fields=Equilibrium,
    resolve=resolve_equilibrium,
    format=EQUILIBRIUM,
    run="pddecont.steps.execution.equilibrium:run_equilibrium",
    sharing=Sharing.EARLY,
    holds=Holding.EQUILIBRIA,
    list_modes=list_equilibrium_modes,
)
