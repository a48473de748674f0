"""A step as reading it from a results file would give it, made of the rows that are written there."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.reasons import NO_REASON, Reason, reason_from_json
from pddecont.results.file_structure import fit_reason
from pddecont.results.format import TEXT_BYTES, Column
from pddecont.results.reader import Fields, Step
from pddecont.results.step_formats import find_format


@dataclass(frozen=True, eq=False)
class Row:
    """What one point puts into the file."""

    points: Mapping[str, Any]
    orbits: Mapping[str, NDArray[Any]]
    reason: Reason = NO_REASON

    @property
    def arrays(self) -> dict[str, NDArray[Any]]:
        """All arrays of the point, that of its reason among them."""
        text = np.frombuffer(self.reason.to_json().encode(), dtype=np.uint8)
        return {**self.orbits, **({"reason": text} if self.reason else {})}


def make_step(
    name: str, kind: str, meta: Mapping[str, Any], rows: Sequence[Row], endings: Mapping[int, Reason]
) -> Step:
    """Return a step with these rows; ``endings`` says how its directions ended, by their places in the file."""
    step_format, meta = find_format(kind), json.loads(json.dumps(meta))
    points = {
        key: _stack([np.asarray(row.points[key])[None] for row in rows], column, meta)
        for key, column in step_format.points.items()
    }
    held = [row.arrays for row in rows]
    orbits: dict[str, NDArray[Any]] = {}
    for key, column in step_format.orbits.items():
        parts = [np.asarray(arrays[key]) for arrays in held if key in arrays and len(arrays[key])]
        orbits[key] = _stack(parts, column, meta)
        orbits[f"{key}_end"] = np.cumsum([len(arrays.get(key, ())) for arrays in held], dtype="i8")
    recorded = tuple(reason_from_json(fit_reason(endings[place], TEXT_BYTES)) for place in sorted(endings))
    done = len(recorded) >= meta.get("directions", 1)
    return Step(name, kind, Fields(name, meta), Fields(name, points), Fields(name, orbits), recorded, done)


def _stack(parts: Iterable[NDArray[Any]], column: Column, meta: Mapping[str, Any]) -> NDArray[Any]:
    """Return the rows of all parts; columns that were added later are zero in earlier ones."""
    parts = list(parts)
    stacked = np.zeros((sum(map(len, parts)), *column.shape(meta)), dtype=column.dtype)
    first = 0
    for part in parts:
        stacked[(slice(first, first + len(part)), *map(slice, part.shape[1:]))] = part
        first += len(part)
    return stacked
