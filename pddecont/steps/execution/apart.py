"""One direction of a branch that is followed apart from the other: what it is told, what it finds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from numpy.typing import NDArray

from pddecont.errors import PddecontError
from pddecont.reasons import Reason
from pddecont.results import Results
from pddecont.runfile import Plan, PlannedStep


@dataclass(frozen=True, eq=False)
class Row:
    """What one point puts into the file."""

    points: Mapping[str, Any]
    orbits: Mapping[str, NDArray[Any]]
    reason: Reason


@dataclass(eq=False)
class RowsInMemory:
    """Where a direction that is followed apart writes its points; ``meta`` is the step's."""

    meta: Mapping[str, Any]
    rows: list[Row] = field(default_factory=list)

    @property
    def n(self) -> int:
        """Number of points."""
        return len(self.rows)

    def append(self, points: Mapping[str, Any], orbits: Mapping[str, NDArray[Any]], reason: Reason) -> None:
        """Keep one point."""
        self.rows.append(Row(points, orbits, reason))


@dataclass(frozen=True, eq=False)
class DirectionTask:
    """A direction to be followed: the run with what its file holds now, the step, what the file says of it, the way."""

    plan: Plan
    file: Results
    step: PlannedStep[Any]
    meta: Mapping[str, Any]
    way: int


@dataclass(frozen=True, eq=False)
class FollowedDirection:
    """A direction that was followed: its points and how it ended, or what went wrong after them."""

    rows: Sequence[Row]
    ending: Reason | None
    error: PddecontError | None = None
