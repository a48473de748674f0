"""Other names in what a step recorded and told: one that was done before its turn gets its name when the turn comes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any, cast

from pddecont.errors import PddecontError


def rename(value: Any, names: Mapping[str, str]) -> Any:
    """Return a log, or a part of one, with other ``names`` in all its texts; arrays are left as they are."""
    match value:
        case str():
            for old, new in names.items():
                value = value.replace(old, new)
            return value
        case Mapping():
            return {key: rename(one, names) for key, one in value.items()}
        case list() | tuple():
            return type(value)(rename(one, names) for one in value)
        case PddecontError():
            # As a copy is made: its kind, its texts, and what else it holds.
            kind, texts, *held = cast(tuple[Any, ...], value.__reduce__())
            renamed = kind(*rename(texts, names))
            for one in held:
                renamed.__dict__.update(one)
            return renamed
    if is_dataclass(value) and not isinstance(value, type):
        return replace(value, **{f.name: rename(getattr(value, f.name), names) for f in fields(value)})
    return value
