"""Pydantic's findings, mapped back to the place in the file and worded for the person who wrote it."""

from __future__ import annotations

import re
import types
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic import BaseModel, BeforeValidator, ConfigDict, Tag, ValidationError, WithJsonSchema
from pydantic_core import PydanticCustomError

from pddecont.errors import Problem, suggest
from pddecont.model.document import MAX_SHOWN, Document, KeyPath, describe_kind
from pddecont.model.expression import FUNCTIONS, IDENTIFIER, PI_NAME
from pddecont.model.mistakes import is_infinite, suggest_point

# Findings that are worked out with all that belongs to a message.
MAX_FOUND = 1000
RESERVED = {"t", PI_NAME, "mode", *FUNCTIONS}
# Between the name of a segment that may lead to several modes and the one that it leads to.
ALTERNATIVE = ">"
# How tags of unions begin, as no key of a file does.
UNION_TAG = "\0"


class Strict(BaseModel):
    """A mapping of the file format: unknown keys are errors, values are never converted."""

    model_config = ConfigDict(defer_build=True, extra="forbid", strict=True, frozen=True, arbitrary_types_allowed=True)


def _identifier(value: Any) -> str:
    if not isinstance(value, str):
        raise PydanticCustomError("name", "expected a name, found {found}", {"found": describe_kind(value)})
    if not IDENTIFIER.match(value):
        raise PydanticCustomError(
            "name", "'{name}' is not a name: letters, digits and _, not starting with a digit", {"name": value}
        )
    return value


def _segment_name(value: Any) -> str:
    if isinstance(value, str) and ALTERNATIVE in value:
        return ALTERNATIVE.join(map(_identifier, value.split(ALTERNATIVE, 1)))
    return _identifier(value)


def _new_name(value: Any) -> str:
    name = _identifier(value)
    if name in RESERVED:
        raise PydanticCustomError(
            "name", "'{name}' has a meaning of its own in expressions; choose another name", {"name": name}
        )
    return name


def _formula(value: Any) -> str | float:
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        raise PydanticCustomError(
            "formula", "expected a number or a formula, found {found}", {"found": describe_kind(value)}
        )
    return value


_FORMULA_SCHEMA = {"anyOf": [{"type": "number"}, {"type": "string"}]}
Identifier = Annotated[str, BeforeValidator(_identifier)]
SegmentName = Annotated[str, BeforeValidator(_segment_name)]
NewName = Annotated[str, BeforeValidator(_new_name)]
Formula = Annotated[str | float, BeforeValidator(_formula), WithJsonSchema(_FORMULA_SCHEMA)]


def validate(document: Document, cls: type[BaseModel], base: KeyPath = ()) -> tuple[Any, list[Problem]]:
    """Return the ``cls`` object in ``document`` under ``base`` (or None) and the problems found in it."""
    data = document.data
    for part in base:
        data = data[part]
    if not isinstance(data, dict):
        return None, [document.problem(base, f"expected a mapping, found {describe_kind(data)}")]
    try:
        return cls.model_validate(data), []
    except ValidationError as exc:
        found = {}
        for error in exc.errors(include_url=False)[:MAX_FOUND]:
            problem = _problem(document, cls, base, error)
            found[(problem.line, problem.column)] = problem
        return None, list(found.values())


def _problem(document: Document, cls: type[BaseModel], base: KeyPath, error: Any) -> Problem:
    loc, at_key = _clean(error["loc"])
    path = (*base, *loc)
    kind, context = error["type"], error.get("ctx") or {}
    if kind == "extra_forbidden":
        known = _fields_at(cls, error["loc"][:-1])
        hint = suggest(str(loc[-1]), known)
        return document.problem(path, f"unknown key '{loc[-1]}'{hint} (keys here: {', '.join(known)})", key=True)
    if kind == "missing":
        return document.problem(path[:-1], f"key '{loc[-1]}' is missing here; add it")
    found = describe_kind(error["input"])
    if isinstance(error["input"], str) and kind in ("float_type", "int_type"):
        found = f"text '{error['input'][:MAX_SHOWN]}'{suggest_point(error['input'])}"
        if is_infinite(error["input"]):
            return document.problem(path, f"expected a finite number, found '{error['input']}'", key=at_key)
    expected = {
        "string_type": "text",
        "dict_type": "a mapping",
        "model_type": "a mapping",
        "list_type": "a list",
        "tuple_type": "a list",
        "int_type": "a whole number",
        "float_type": "a number",
        "bool_type": "true or false",
        "int_from_float": "a whole number",
    }.get(kind)
    if expected:
        return document.problem(path, f"expected {expected}, found {found}", key=at_key)
    if kind == "literal_error":
        hint = suggest(str(error["input"]), re.findall(r"'(\w+)'", context.get("expected", "")))
        return document.problem(path, f"expected {context['expected']}, found '{error['input']}'{hint}")
    message = error["msg"]
    return document.problem(path, message[0].lower() + message[1:], key=at_key)


def _clean(loc: tuple[Any, ...]) -> tuple[KeyPath, bool]:
    """Return the file path of a pydantic location and whether it speaks of a key (pydantic marks those ``[key]``)."""
    at_key = bool(loc) and loc[-1] == "[key]"
    return tuple(part for part in loc if part != "[key]" and not _is_tag(part)), at_key


def _is_tag(part: str | int) -> bool:
    return isinstance(part, str) and part.startswith(UNION_TAG)


def _fields_at(cls: Any, loc: KeyPath) -> list[str]:
    """Return the keys that the format allows at ``loc``, a pydantic location, below the mapping ``cls``."""
    for part in loc:
        if _is_tag(part):
            union = get_args(cls)[0] if get_origin(cls) is Annotated else cls
            cls = next(member for member in get_args(union) if Tag(str(part)) in get_args(member)[1:])
            continue
        cls = _bare(cls)
        if isinstance(cls, type) and issubclass(cls, BaseModel):
            by_key = {info.alias or name: info.annotation for name, info in cls.model_fields.items()}
            cls = by_key.get(str(part))
        else:
            cls = get_args(cls)[-1] if get_args(cls) else None
    cls = _bare(cls)
    if isinstance(cls, type) and issubclass(cls, BaseModel):
        return [info.alias or name for name, info in cls.model_fields.items()]
    return []


def _bare(annotation: Any) -> Any:
    """Return the annotation without Annotated, Optional and unions with plain values."""
    while True:
        if get_origin(annotation) is Annotated:
            annotation = get_args(annotation)[0]
        elif get_origin(annotation) in (Union, types.UnionType):
            parts = [a for a in get_args(annotation) if a is not type(None)]
            annotation = next(
                (a for a in parts if isinstance(_bare(a), type) and issubclass(_bare(a), BaseModel)), parts[0]
            )
        else:
            return annotation
