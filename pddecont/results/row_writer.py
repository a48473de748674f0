"""What takes the rows of a step, into a results file or elsewhere."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Protocol, Self

from numpy.typing import NDArray

from pddecont.reasons import Reason


class RowWriter(Protocol):
    """Takes the rows of one step; a context manager that closes the step."""

    @property
    def meta(self) -> Mapping[str, Any]:
        """What the step says of itself."""
        ...

    @property
    def n(self) -> int:
        """Number of points."""
        ...

    def __enter__(self) -> Self: ...

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None: ...

    def append(
        self, points: Mapping[str, Any], orbits: Mapping[str, NDArray[Any]] | None = None, reason: Reason | None = None
    ) -> None:
        """Take one point."""
        ...

    def list_more(self, key: str, names: Iterable[str]) -> list[str]:
        """Return a list of names that columns belong to, with those of ``names`` that it lacked; they get columns."""
        ...

    def terminate(self, ending: Reason, place: int = 0) -> None:
        """Take how the step, or one of its directions, ended."""
        ...
