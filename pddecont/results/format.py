"""What a results file looks like inside.

    format_version                                 root attribute
    /versions, /source                             what made the file (JSON), and from which file
    /model, /run                                   the texts as they were read
    /steps/<name>/kind, /steps/<name>/meta         kind of step; names and settings (JSON)
    /steps/<name>/finished                         number of finished rows
    /steps/<name>/termination                      how each direction ended, as a reason (JSON)
    /steps/<name>/points/<column>                  one row a point
    /steps/<name>/orbits/<column>                  rows of all points one after another ...
    /steps/<name>/orbits/<column>_end              ... and where each point's rows end
    /steps/<name>/special_points/{label, index}    written when the step is done

Rows beyond ``finished`` are room for points to come and hold nothing; a step that is closed has none. Versions 2 and 3
are still read (``results.upgrade``).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from numpy.typing import NDArray

FORMAT_VERSION = 4
OLDEST_VERSION = 2
# Bytes of one direction's ending, and directions.
TEXT_BYTES = 4000
N_TERMINATIONS = 4
# One of each name of a list in a step's meta, so many more than that, or a number.
Axis: TypeAlias = str | tuple[str, int] | int
Arrays: TypeAlias = Mapping[str, NDArray[Any]]


@dataclass(frozen=True)
class Column:
    """One array of a step: element type, and what each further axis of it has one of."""

    dtype: str
    axes: tuple[Axis, ...] = ()

    def shape(self, meta: Mapping[str, Any]) -> tuple[int, ...]:
        """Return the shape of one row in a step with these names."""
        return tuple(_length(axis, meta) for axis in self.axes)

    def is_known(self, meta: Mapping[str, Any]) -> bool:
        """Return whether a step's names say what shape a row has."""
        return all(isinstance(axis, int) or _name_of(axis) in meta for axis in self.axes)


def _name_of(axis: str | tuple[str, int]) -> str:
    return axis if isinstance(axis, str) else axis[0]


def _length(axis: Axis, meta: Mapping[str, Any]) -> int:
    if isinstance(axis, int):
        return axis
    return len(meta[axis]) if isinstance(axis, str) else len(meta[axis[0]]) + axis[1]


@dataclass(frozen=True)
class StepFormat:
    """What a kind of step keeps in a results file, declared once for those who write, check and read it.

    Attributes
    ----------
    kind
        Name of the kind.
    points
        Arrays with one row a point.
    orbits
        Arrays with any number of rows a point.
    together
        Groups of ``orbits`` with equally many rows for each point.
    name_lists
        Lists of names in the meta data that must be there, with how many names they hold at least and at most.
    has_branch
        Whether points lie along a branch, in order of arclength, with special points among them.
    check
        Raise ResultsError if meta data and arrays contradict one another.
    """

    kind: str
    points: Mapping[str, Column]
    orbits: Mapping[str, Column] = field(default_factory=dict)
    together: Sequence[tuple[str, ...]] = ()
    name_lists: Mapping[str, tuple[int, int]] = field(default_factory=dict)
    has_branch: bool = False
    check: Callable[[Mapping[str, Any], Arrays, Arrays], None] | None = None
