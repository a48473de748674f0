"""What has been worked out of an object and is asked for again, kept with it."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from typing import Any, TypeVar

Found = TypeVar("Found")


@dataclass(frozen=True, eq=False)
class Memo:
    """An object that does not change, and remembers what was found of it."""

    _found: dict[Hashable, Any] = field(default_factory=dict, init=False, repr=False)

    def once(self, key: Hashable, find: Callable[[], Found]) -> Found:
        """Return what ``find`` finds, found once for this object."""
        if key not in self._found:
            self._found[key] = find()
        found: Found = self._found[key]
        return found
