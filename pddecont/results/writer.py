"""Appending to a results file so that a process killed at any instant leaves a file that opens.

Between changes of the file's structure every array has room for rows to come at a fixed place in the file, and a new
point is written there directly, its count last: no metadata of HDF5 is touched while a computation runs.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ResultsError
from pddecont.reasons import Reason
from pddecont.results.file_structure import (
    TEXT,
    copy_steps,
    fit_reason,
    make_arrays,
    make_write_error,
    rewrite,
    write_all,
    write_text,
)
from pddecont.results.format import N_TERMINATIONS, TEXT_BYTES, Column, StepFormat
from pddecont.results.reader import Step
from pddecont.results.stored_arrays import open_array
from pddecont.results.whole_file import compact_step

ROW_NUMBER = Column("i8")
# Rows that arrays have room for at first; each time that is used up they get twice as much.
CAPACITY = 64
# Bytes that a reason takes, as a rule: the first one comes after other arrays have got their room.
REASON_BYTES = 128
# Stands for all arrays with one row a point, which have the same room; no array is named so.
ONE_A_POINT = "points/"


@dataclass(frozen=True, slots=True)
class Place:
    """Where the rows of an array lie in the file: type and shape of a row, its bytes, where the first one begins."""

    dtype: np.dtype[Any]
    shape: tuple[int, ...]
    row_bytes: int
    offset: int


class StepWriter:
    """Rows of one step; a context manager that leaves the file without spare room when the step is done.

    The first ``kept`` rows of ``recorded``, what the file holds of the step, stay; the rest is written anew. Where its
    first point comes ``at_once`` the file gets the step with that, and has to be arranged once instead of twice.
    ``closed`` is told what the file holds once it is closed.
    """

    def __init__(
        self,
        path: Path,
        name: str,
        step_format: StepFormat,
        meta: Mapping[str, Any],
        *,
        capacity: int = CAPACITY,
        recorded: Step | None = None,
        kept: int = 0,
        at_once: bool = False,
        closed: Callable[[Step], None] = lambda step: None,
    ):
        self.path, self.name, self.format, self.meta = path, name, step_format, dict(meta)
        self.n, self._capacity, self._closed = kept, capacity, closed
        self.used = dict.fromkeys(step_format.orbits, 0)
        if recorded is not None and kept:
            self.used = {
                # Files of earlier versions lack some columns.
                name: int(recorded.orbits[f"{name}_end"][kept - 1]) if f"{name}_end" in recorded.orbits else 0
                for name in step_format.orbits
            }
        capacity = max(capacity, kept, *self.used.values())
        self.capacity = dict.fromkeys((ONE_A_POINT, *step_format.orbits), capacity)
        if "reason" in self.capacity:
            self.capacity["reason"] *= REASON_BYTES
        self._descriptor = -1
        self._places: dict[str, Place] = {}
        if not at_once:
            self._arrange()

    def __enter__(self) -> StepWriter:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        # What went wrong is what a person should hear of, not that the file cannot be closed for the same reason.
        with contextlib.suppress(*([] if kind is None else [ResultsError])):
            self.close()

    def append(
        self, points: Mapping[str, Any], orbits: Mapping[str, NDArray[Any]] | None = None, reason: Reason | None = None
    ) -> None:
        """Write one point; it counts as finished only when all of it is written.

        Arrays of orbits that are not given have no rows for it. ``reason`` goes to the array of that name.
        """
        rows = dict(orbits or {})
        if reason:
            rows["reason"] = np.frombuffer(reason.to_json().encode(), dtype=np.uint8)
        self._check_place()
        self._make_room(rows)
        for name in self.format.orbits:
            values = rows.get(name, ())
            if len(values):
                self._write(f"orbits/{name}", self.used[name], values)
                self.used[name] += len(values)
            self._write(f"orbits/{name}_end", self.n, (self.used[name],))
        for name in self.format.points:
            self._write(f"points/{name}", self.n, (points[name],))
        self.n += 1
        self._write("finished", 0, (self.n,))

    def list_more(self, key: str, names: Iterable[str]) -> list[str]:
        """Return a list of names that columns belong to, with those of ``names`` that it lacked; they get columns."""
        known: list[str] = list(self.meta[key])
        new = [name for name in names if name not in known]
        if new:
            self._check_place()
            self.meta[key] = known + new
            self._arrange()
        return known + new

    def terminate(self, ending: Reason, place: int = 0) -> None:
        """Record how the step, or one of its directions, ended."""
        self._write("termination", place, (fit_reason(ending, TEXT_BYTES).encode(),))

    def close(self) -> None:
        """Take the spare room out of the file."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1
            self._closed(compact_step(self.path, self.name))

    def _check_place(self) -> None:
        """Check that the file still stands where it was opened: what is written to a file that has no name is lost."""
        if self._descriptor < 0:
            return
        try:
            here = os.path.samestat(os.stat(self.path), os.fstat(self._descriptor))
        except OSError:
            here = False
        if not here:
            raise ResultsError(
                f"{self.path} was removed, moved or replaced while this run wrote to it; nothing more can be kept there"
            )

    def _make_room(self, rows: Mapping[str, NDArray[Any]]) -> None:
        """Make room where an array has none for a point with these rows, and in all arrays that will soon have none."""
        wanted = {ONE_A_POINT: (self.n, 1)} | {name: (self.used[name], len(values)) for name, values in rows.items()}
        if self._descriptor < 0 or any(used + n > self.capacity[name] for name, (used, n) in wanted.items()):
            self.capacity |= {
                name: max(2 * self.capacity[name], used + n * self._capacity)
                for name, (used, n) in wanted.items()
                if used + n * self._capacity > self.capacity[name]
            }
            self._arrange()

    def _arrange(self) -> None:
        """Rewrite the file with the present capacities and note where each array lies in it."""
        group = f"steps/{self.name}"

        def change(old: h5py.File | None, new: h5py.File) -> None:
            assert old is not None
            target = copy_steps(old, new, anew=self.name)
            write_text(target, "kind", self.format.kind)
            write_text(target, "meta", json.dumps(self.meta, sort_keys=True))
            had = old.get(group)
            offsets.update(make_arrays(target, self._take_over(had)))

        offsets: dict[str, int] = {}
        rewrite(self.path, change)
        if self._descriptor >= 0:
            os.close(self._descriptor)
        self._descriptor = os.open(self.path, os.O_RDWR)
        self._places = {
            name: self._describe(column, offsets.get(name, 0)) for name, column, _, _ in self._list_arrays()
        }

    def _list_arrays(self) -> Iterator[tuple[str, Column, int, int]]:
        """Yield the arrays of the step, how many rows each has room for, and how many of them are used."""
        yield "finished", ROW_NUMBER, 1, 0
        yield "termination", TEXT, N_TERMINATIONS, N_TERMINATIONS
        for name, column in self.format.points.items():
            yield f"points/{name}", column, self.capacity[ONE_A_POINT], self.n
        for name, column in self.format.orbits.items():
            yield f"orbits/{name}", column, self.capacity[name], self.used[name]
            yield f"orbits/{name}_end", ROW_NUMBER, self.capacity[ONE_A_POINT], self.n

    def _take_over(self, had: h5py.Group | None) -> Iterator[tuple[str, NDArray[Any]]]:
        """Yield the arrays of the step with room for rows to come, and the rows that ``had`` holds in their places."""
        for name, column, capacity, used in self._list_arrays():
            values = np.zeros((capacity, *column.shape(self.meta)), column.dtype)
            if had is not None and used and name.encode() in had.id:
                rows = open_array(had.id, name).read(n=used)
                # Columns may have been added since.
                values[(slice(used), *map(slice, rows.shape[1:]))] = rows
            yield name, values if name != "finished" else np.array([self.n])

    def _describe(self, column: Column, offset: int) -> Place:
        dtype, shape = np.dtype(column.dtype), column.shape(self.meta)
        return Place(dtype, shape, dtype.itemsize * math.prod(shape), offset)

    def _write(self, name: str, first: int, rows: Sequence[Any] | NDArray[Any]) -> None:
        place = self._places[name]
        data = np.asarray(rows, dtype=place.dtype)
        if data.shape[1:] != place.shape:
            raise ResultsError(f"column {name} takes rows of shape {place.shape}, not {data.shape[1:]}")
        if data.size:
            try:
                write_all(self._descriptor, data.tobytes(), place.offset + first * place.row_bytes)
            except OSError as exc:
                raise make_write_error(self.path, exc) from exc
