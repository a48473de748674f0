"""The shape of a run file: which keys, which kinds of values. A step is told by the key that names its kind."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache, reduce
from operator import or_
from typing import Annotated, Any, ClassVar, Generic, Protocol, TypeVar

from pydantic import Discriminator, Field, Tag, create_model, model_validator
from pydantic.json_schema import SkipJsonSchema
from pydantic_core import PydanticCustomError

from pddecont.model import UNION_TAG, Formula, Identifier, Strict
from pddecont.runfile.fields import Delay, Effects, Mesh, Source


class StepSyntax(Protocol):
    """What a run file must know of a kind of step: its key, and what may be written under it."""

    @property
    def name(self) -> str:
        """The key."""
        ...

    @property
    def fields(self) -> type[Strict]:
        """What is under it."""
        ...


class StepFields(Strict):
    """What any step may say."""

    name: Identifier = Field(description="name of the step in the results")
    set: dict[Identifier, Formula] = Field(default_factory=dict, description="parameter values for this step")
    delay: Delay | None = None
    mesh: Mesh | None = None


class StepBlock(StepFields):
    """A step of a known kind; ``body`` is what the file says under the kind's name."""

    kind: ClassVar[str] = ""
    body: Any

    @property
    def source(self) -> Source | None:
        """Where the step starts."""
        source: Source | None = getattr(self.body, "from_", None)
        return source


S = TypeVar("S")


class RunBlock(Strict, Generic[S]):
    """A run without its model: what is under ``run`` in a model file."""

    set: dict[Identifier, Formula] = Field(default_factory=dict, description="parameter values")
    effects: Effects = Field(default_factory=lambda: Effects.model_validate({}))
    accuracy: float | None = Field(
        None,
        ge=1e-11,
        lt=1,
        description=(
            "error allowed on orbits, relative to their sizes; method, degree and mesh are chosen for it, instead of "
            "'delay' and 'mesh'"
        ),
    )
    delay: Delay = Field(default_factory=lambda: Delay.model_validate({}))
    mesh: Mesh = Field(default_factory=lambda: Mesh.model_validate({}))
    monitors: dict[Identifier, Formula] = Field(default_factory=dict, description="numbers recorded at every point")
    steps: list[S] = Field(min_length=1, description="what to do, in order")

    @model_validator(mode="after")
    def _one_rule(self) -> RunBlock[S]:
        for key in ("delay", "mesh"):
            if self.accuracy is not None and key in self.model_fields_set:
                raise PydanticCustomError(
                    "accuracy",
                    "'accuracy' chooses the method and the mesh; leave '{key}' out, or give it to a step",
                    {"key": key},
                )
        return self


class RunFile(RunBlock[S], Generic[S]):
    """A run file."""

    model: str = Field(description="model file, relative to this file, or the name of a shipped model")


def make_step_type(kinds: Sequence[StepSyntax]) -> Any:
    """Return the type of a step of one of the ``kinds``, for pydantic; it is made once."""
    return _make_step_type(tuple(kinds))


@lru_cache(maxsize=8)
def _make_step_type(kinds: tuple[StepSyntax, ...]) -> Any:
    # Types made while the program runs are no types to a checker.
    annotated: Any = Annotated
    hidden: Any = SkipJsonSchema
    names = [kind.name for kind in kinds]
    members = [annotated[_make_block(kind, names), Tag(_tag(kind.name))] for kind in kinds]
    unknown = annotated[_make_unknown(kinds), hidden(), Tag(_tag(""))]

    def find_tag(value: Any) -> str:
        given = [name for name in names if value.get(name) is not None] if isinstance(value, dict) else []
        return _tag(given[0] if len(given) == 1 else "")

    return annotated[reduce(or_, [*members, unknown]), Discriminator(find_tag)]


def make_run_types(kinds: Sequence[StepSyntax]) -> tuple[type[RunBlock[Any]], type[RunFile[Any]]]:
    """Return the types of a model's run block and of a run file with steps of the ``kinds``; they are made once."""
    return _make_run_types(tuple(kinds))


@lru_cache(maxsize=8)
def _make_run_types(kinds: tuple[StepSyntax, ...]) -> tuple[type[RunBlock[Any]], type[RunFile[Any]]]:
    step = _make_step_type(kinds)
    block: Any = RunBlock
    file: Any = RunFile
    return block[step], file[step]


def _tag(name: str) -> str:
    return f"{UNION_TAG}{name}"


def _make_block(kind: StepSyntax, names: Sequence[str]) -> Any:
    def drop_nulls(value: Any) -> Any:
        """Return what is given without the keys of other kinds that are null."""
        if not isinstance(value, dict):
            return value
        return {key: v for key, v in value.items() if v is not None or key not in names}

    body: Any = (kind.fields, Field(alias=kind.name))
    validators: Any = {"drop_nulls": model_validator(mode="before")(drop_nulls)}
    name = f"{kind.name.title().replace('_', '')}Step"
    block = create_model(name, __base__=StepBlock, __validators__=validators, body=body)
    block.kind = kind.name
    block.__doc__ = f"A step of kind {kind.name}."
    return block


def _make_unknown(kinds: Sequence[StepSyntax]) -> Any:
    """Return the type of a step without a kind, or with several: it fits nothing, and says why."""
    names = [kind.name for kind in kinds]

    def refuse(value: Any) -> Any:
        given = [name for name in names if getattr(value, f"kind_{name}") is not None]
        raise PydanticCustomError(
            "kind",
            "a step has exactly one of {kinds}; found {given}",
            {"kinds": ", ".join(names), "given": ", ".join(given) or "none"},
        )

    keys: dict[str, Any] = {f"kind_{name}": (Any, Field(None, alias=name)) for name in names}
    validators: dict[str, Any] = {"refuse": model_validator(mode="after")(refuse)}
    return create_model("UnknownStep", __base__=StepFields, __validators__=validators, **keys)
