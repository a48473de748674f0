"""What has been worked out of an object and is asked for again, kept with it."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeVar

Found = TypeVar("Found")
# Stands for what has not been found.
_NOT_YET: Any = object()

if TYPE_CHECKING:
    from functools import cached_property as cached_property
else:

    class cached_property:
        """A property that is worked out once for each object, as :func:`functools.cached_property` of Python 3.12 is.

        That of Python 3.11 locks other threads out meanwhile, which takes longer than what many properties work out.
        """

        def __init__(self, func):
            self.func, self.attrname, self.__doc__ = func, func.__name__, func.__doc__

        def __get__(self, owner, kind=None):
            if owner is None:
                return self
            found = owner.__dict__[self.attrname] = self.func(owner)
            return found


@dataclass(frozen=True, eq=False)
class Memo:
    """An object that does not change, and remembers what was found of it."""

    _found: dict[Hashable, Any] = field(default_factory=dict, init=False, repr=False)

    def once(self, key: Hashable, find: Callable[[], Found]) -> Found:
        """Return what ``find`` finds, found once for this object."""
        found: Found = self._found.get(key, _NOT_YET)
        if found is _NOT_YET:
            found = self._found[key] = find()
        return found
