"""Appending to a results file so that a process killed at any instant leaves a file that opens.

Between changes of the file's structure every array has room for rows to come at a fixed place in the file, and a new
point is written there directly, its count last: no metadata of HDF5 is touched while a computation runs.
"""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Callable, Iterable, Mapping
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
    make_array,
    make_write_error,
    rewrite,
    write_all,
    write_text,
)
from pddecont.results.format import N_TERMINATIONS, TEXT_BYTES, Column, StepFormat
from pddecont.results.reader import Step
from pddecont.results.whole_file import compact_step

# Rows that arrays have room for at first; each time that is used up they get twice as much.
CAPACITY = 64


class StepWriter:
    """Rows of one step; a context manager that leaves the file without spare room when the step is done.

    The first ``kept`` rows of ``recorded``, what the file holds of the step, stay; the rest is written anew. ``closed``
    is told what the file holds once it is closed.
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
        self.capacity = dict.fromkeys((*step_format.points, *step_format.orbits), capacity)
        self._descriptor = -1
        self._offsets: dict[str, int] = {}
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
        wanted = dict.fromkeys(self.format.points, (self.n, 1))
        self._make_room({**wanted, **{name: (self.used[name], len(values)) for name, values in rows.items()}})
        for name, column in self.format.orbits.items():
            values = rows.get(name, np.zeros(0))
            if len(values):
                self._write(f"orbits/{name}", column, self.used[name], values)
                self.used[name] += len(values)
            self._write(f"orbits/{name}_end", Column("i8"), self.n, np.array([self.used[name]]))
        for name, column in self.format.points.items():
            self._write(f"points/{name}", column, self.n, np.asarray(points[name])[None])
        self.n += 1
        self._write("finished", Column("i8"), 0, np.array([self.n]))

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
        text = fit_reason(ending, TEXT_BYTES).encode()
        self._write("termination", TEXT, place, np.array([text], dtype=TEXT.dtype))

    def close(self) -> None:
        """Take the spare room out of the file."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1
            self._closed(compact_step(self.path, self.name))

    def _check_place(self) -> None:
        """Check that the file still stands where it was opened: what is written to a file that has no name is lost."""
        try:
            here = os.path.samestat(os.stat(self.path), os.fstat(self._descriptor))
        except OSError:
            here = False
        if not here:
            raise ResultsError(
                f"{self.path} was removed, moved or replaced while this run wrote to it; nothing more can be kept there"
            )

    def _make_room(self, wanted: Mapping[str, tuple[int, int]]) -> None:
        """Make room where an array has none for more rows, and in all arrays that will soon have none.

        ``wanted`` holds the rows used and the rows to come.
        """
        if any(used + n > self.capacity[name] for name, (used, n) in wanted.items()):
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
            make_array(target, had, "finished", "i8", (), 1, 1)
            if self.n:
                target["finished"][0] = self.n
            make_array(target, had, "termination", TEXT.dtype, (), N_TERMINATIONS, N_TERMINATIONS)
            for name, column in self.format.points.items():
                shape = column.shape(self.meta)
                make_array(target, had, f"points/{name}", column.dtype, shape, self.capacity[name], self.n)
            n_points = max((self.capacity[name] for name in self.format.points), default=0)
            for name, column in self.format.orbits.items():
                shape = column.shape(self.meta)
                make_array(target, had, f"orbits/{name}", column.dtype, shape, self.capacity[name], self.used[name])
                make_array(target, had, f"orbits/{name}_end", "i8", (), n_points, self.n)

        rewrite(self.path, change)
        if self._descriptor >= 0:
            os.close(self._descriptor)
        self._descriptor = os.open(self.path, os.O_RDWR)
        with h5py.File(self.path, "r") as file:
            arrays: dict[str, Any] = {}
            file[group].visititems(
                lambda name, item: arrays.update({name: item}) if isinstance(item, h5py.Dataset) else None
            )
            self._offsets = {
                name: item.id.get_offset() for name, item in arrays.items() if item.id.get_offset() is not None
            }

    def _write(self, name: str, column: Column, first: int, rows: np.ndarray) -> None:
        data = np.ascontiguousarray(rows, dtype=column.dtype)
        if data.shape[1:] != column.shape(self.meta):
            raise ResultsError(f"column {name} takes rows of shape {column.shape(self.meta)}, not {data.shape[1:]}")
        if not data.nbytes:
            return
        row_bytes = data.nbytes // len(data)
        try:
            write_all(self._descriptor, data.tobytes(), self._offsets[name] + first * row_bytes)
        except OSError as exc:
            raise make_write_error(self.path, exc) from exc
