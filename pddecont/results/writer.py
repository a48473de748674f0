"""Appending to a results file so that a process killed at any instant leaves a file that opens.

Between changes of the file's structure every array has room for rows to come at a fixed place in the file, and a new
point is written there directly, its count last: no metadata of HDF5 is touched while a computation runs. Most arrays
with one row a point lie side by side; those parts of the file are kept in memory too, and written as a whole while they
are small: what they held before is written once more, and a few writes do for dozens.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ResultsError
from pddecont.reasons import Reason, reason_from_json
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
from pddecont.results.parts import Part, Place, find_parts
from pddecont.results.reader import Step, make_step
from pddecont.results.stored_arrays import open_array
from pddecont.results.whole_file import write_compact

ROW_NUMBER = Column("i8")
# Rows that arrays have room for at first; each time that is used up they get twice as much.
CAPACITY = 64
# Bytes that a reason takes, as a rule: the first one comes after other arrays have got their room.
REASON_BYTES = 128
# Bytes of the arrays with one row a point, beyond which their rows are written one by one.
LARGEST_PART = 1 << 18
# Stands for all arrays with one row a point, which have the same room; no array is named so.
ONE_A_POINT = "points/"


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
        self._parts: list[Part] | None = None
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
        for name, values in rows.items():
            if len(values):
                self._write(f"orbits/{name}", self.used[name], values)
                self.used[name] += len(values)
        self._write_row(
            {f"orbits/{name}_end": self.used[name] for name in self.format.orbits}
            | {f"points/{name}": points[name] for name in self.format.points}
        )
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
            self._check_place()
            step = self._read_back()
            os.close(self._descriptor)
            self._descriptor = -1
            self._closed(write_compact(self.path, step))

    def _read_back(self) -> Step:
        """Return the step as it stands in the file and as others read it, arrays in order of their names."""
        points = {name: self._read(f"points/{name}", self.n) for name in sorted(self.format.points)}
        orbits: dict[str, NDArray[Any]] = {}
        for end, name in sorted((f"{name}_end", name) for name in self.format.orbits):
            orbits[end] = self._read(f"orbits/{end}", self.n)
            orbits[name] = self._read(f"orbits/{name}", self.used[name])
        lines = self._read("termination", N_TERMINATIONS).tolist()
        endings = tuple(reason_from_json(line.decode()) for line in lines if line)
        return make_step(self.name, self.format.kind, json.loads(json.dumps(self.meta)), points, orbits, endings)

    def _read(self, name: str, n: int) -> NDArray[Any]:
        """Return the first ``n`` rows of an array."""
        place = self._places[name]
        result = np.empty((n, *place.shape), place.dtype)
        left, offset = result.reshape(-1).view(np.uint8).data, place.offset
        # The system may give it in pieces.
        while len(left):
            found = os.preadv(self._descriptor, [left], offset)
            if not found:
                raise ResultsError(f"{self.path} has become shorter while this run wrote to it")
            left, offset = left[found:], offset + found
        return result

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
        self._parts = self._keep_parts()

    def _keep_parts(self) -> list[Part] | None:
        """Return the parts of the file in which arrays with one row a point lie; None where those are large."""
        n_rows, ends = self.capacity[ONE_A_POINT], [f"orbits/{name}_end" for name in self.format.orbits]
        names = {*ends, *(f"points/{name}" for name in self.format.points)}
        if n_rows * sum(self._places[name].row_bytes for name in names) > LARGEST_PART:
            return None
        return [Part(self._descriptor, places, n_rows) for places in find_parts(self._places, n_rows, names)]

    def _list_arrays(self) -> Iterator[tuple[str, Column, int, int]]:
        """Yield the arrays of the step, how many rows each has room for, and how many of them are used."""
        yield "finished", ROW_NUMBER, 1, 0
        yield "termination", TEXT, N_TERMINATIONS, N_TERMINATIONS
        for name, column in self.format.points.items():
            yield f"points/{name}", column, self.capacity[ONE_A_POINT], self.n
        for name in self.format.orbits:
            yield f"orbits/{name}_end", ROW_NUMBER, self.capacity[ONE_A_POINT], self.n
        for name, column in self.format.orbits.items():
            yield f"orbits/{name}", column, self.capacity[name], self.used[name]

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

    def _write_row(self, values: Mapping[str, Any]) -> None:
        """Write a row of each array with one row a point."""
        for name, value in values.items():
            place = self._places[name]
            if (place.shape or not np.isscalar(value)) and np.shape(value) != place.shape:
                raise ResultsError(f"column {name} takes rows of shape {place.shape}, not {np.shape(value)}")
            if self._parts is None:
                self._write(name, self.n, (value,))
        for part in self._parts or ():
            for name, rows in part.rows.items():
                rows[self.n] = values[name]
            self._put(part.image, part.offset)

    def _write(self, name: str, first: int, rows: Sequence[Any] | NDArray[Any]) -> None:
        place = self._places[name]
        data = np.asarray(rows, dtype=place.dtype)
        if data.shape[1:] != place.shape:
            raise ResultsError(f"column {name} takes rows of shape {place.shape}, not {data.shape[1:]}")
        if data.size:
            self._put(data.tobytes(), place.offset + first * place.row_bytes)

    def _put(self, data: bytes | bytearray, offset: int) -> None:
        try:
            write_all(self._descriptor, data, offset)
        except OSError as exc:
            raise make_write_error(self.path, exc) from exc
