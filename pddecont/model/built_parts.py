"""Parts of a model that are made when something asks for them by name."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any, TypeVar

T = TypeVar("T")


class BuiltParts(Mapping[str, T]):
    """Parts of a model by name: each is made when it is asked for; those built so far are listed."""

    def __init__(self, built: Mapping[str, Any], find: Callable[[str], T | None]) -> None:
        self._built, self._find = built, find

    def __getitem__(self, name: str) -> T:
        """Return the part with a name; raise KeyError if there is none."""
        found = self._find(name)
        if found is None:
            raise KeyError(name)
        return found

    def __iter__(self) -> Iterator[str]:
        """Return the names of those built so far."""
        return iter(list(self._built))

    def __len__(self) -> int:
        """Return how many are built."""
        return len(self._built)
