"""Appending to a results file so that a process killed at any instant leaves a file that opens.

The file's structure only ever changes by writing a new file beside it and renaming that onto the old one, which is
atomic. Between such changes every array has room for rows to come at a fixed place in the file, and a new point is
written there directly, its count last: no metadata of HDF5 is touched while a computation runs.

HDF5 arranges a file in memory; plain system calls put it on the disk. The library itself must not meet a full disk:
after a failed write it can neither close the file nor let the process end.
"""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ResultsError
from pddecont.output import explain_other
from pddecont.reasons import Reason
from pddecont.results.format import FORMAT_VERSION, N_TERMINATIONS, TEXT_BYTES, Column, StepFormat
from pddecont.results.lock import check_unlocked, part_of
from pddecont.results.reader import Results, Step, is_results_file, read_results

# Rows that arrays have room for at first; each time that is used up they get twice as much.
CAPACITY = 64
# Bytes by which a file grows in memory.
BLOCK = 1 << 20
TEXT = Column(f"S{TEXT_BYTES}")


def create_results(
    path: Path, model_text: str, run_text: str, source: str, versions: str, *, overwrite: bool = False
) -> None:
    """Make a new results file.

    An existing one is refused unless ``overwrite``; a file of another kind always is.
    """
    if path.exists():
        if not overwrite:
            raise ResultsError(
                f"{path} exists already; give --resume to go on with it, --overwrite to replace it, or another -o"
            )
        check_unlocked(path)
        if path.stat().st_size and not is_results_file(path):
            raise explain_other(path, "a results file")

    def fill(_: h5py.File | None, new: h5py.File) -> None:
        new.attrs["format_version"] = FORMAT_VERSION
        for name, text in (("versions", versions), ("source", source), ("model", model_text), ("run", run_text)):
            _write_text(new, name, text)
        new.create_group("steps", track_order=True)

    _rewrite(path, fill, fresh=True)


def _rewrite(path: Path, change: Callable[[h5py.File | None, h5py.File], None], *, fresh: bool = False) -> None:
    """Write ``path`` anew through ``change(old, new)`` and put it in place of the old file at once."""
    temporary = part_of(path)
    try:
        with contextlib.ExitStack() as stack:
            old = None if fresh else stack.enter_context(h5py.File(path, "r"))
            new = stack.enter_context(h5py.File(temporary, "w", driver="core", backing_store=False, block_size=BLOCK))
            change(old, new)
            new.flush()
            image = new.id.get_file_image()
        temporary.unlink(missing_ok=True)
        with open(temporary, "xb", buffering=0) as stream:
            _write_all(stream.fileno(), image, 0)
        os.replace(temporary, path)
    except OSError as exc:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)
        raise _cannot_write(path, exc) from exc


def _write_all(descriptor: int, data: bytes, offset: int) -> None:
    """Write all of ``data`` at ``offset``; the system may take it in pieces."""
    view = memoryview(data)
    while view:
        done = os.pwrite(descriptor, view, offset)
        view, offset = view[done:], offset + done


def _cannot_write(path: Path, exc: OSError) -> ResultsError:
    return ResultsError(
        f"{path} cannot be written: {exc.strerror or exc}; what was finished is kept. Check the folder and the space "
        f"on "
        "the disk, then go on with --resume"
    )


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
        text = _fit(ending, TEXT_BYTES).encode()
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
            target = _copy(old, new, anew=self.name)
            _write_text(target, "kind", self.format.kind)
            _write_text(target, "meta", json.dumps(self.meta, sort_keys=True))
            had = old.get(group)
            _array(target, had, "finished", "i8", (), 1, 1)
            if self.n:
                target["finished"][0] = self.n
            _array(target, had, "termination", TEXT.dtype, (), N_TERMINATIONS, N_TERMINATIONS)
            for name, column in self.format.points.items():
                shape = column.shape(self.meta)
                _array(target, had, f"points/{name}", column.dtype, shape, self.capacity[name], self.n)
            n_points = max((self.capacity[name] for name in self.format.points), default=0)
            for name, column in self.format.orbits.items():
                shape = column.shape(self.meta)
                _array(target, had, f"orbits/{name}", column.dtype, shape, self.capacity[name], self.used[name])
                _array(target, had, f"orbits/{name}_end", "i8", (), n_points, self.n)

        _rewrite(self.path, change)
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
            _write_all(self._descriptor, data.tobytes(), self._offsets[name] + first * row_bytes)
        except OSError as exc:
            raise _cannot_write(self.path, exc) from exc


def _write_text(target: h5py.Group, name: str, text: str) -> None:
    """Write a text as an array of its own.

    Its length is fixed, as heaps of texts of any length are where damage ends a reader.
    """
    data = text.encode()
    target.create_dataset(name, data=data or b" ", dtype=h5py.string_dtype("utf-8", max(1, len(data))))


def _array(
    target: h5py.Group,
    had: Mapping[str, Any] | None,
    name: str,
    dtype: str,
    shape: tuple[int, ...],
    capacity: int,
    used: int,
) -> None:
    """Make one array with room for ``capacity`` rows at a fixed place in the file and take over the rows it had."""
    plist = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    plist.set_layout(h5py.h5d.CONTIGUOUS)
    plist.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    plist.set_obj_track_times(False)
    space = h5py.h5s.create_simple((capacity, *shape))
    parent, _, leaf = name.rpartition("/")
    group = target.require_group(parent) if parent else target
    kind = h5py.h5t.py_create(np.dtype(dtype), logical=True)
    dataset = h5py.Dataset(h5py.h5d.create(group.id, leaf.encode(), kind, space, dcpl=plist))
    if had is not None and name in had and used:
        rows = had[name][:used]
        # Columns may have been added since.
        dataset[(slice(used), *map(slice, rows.shape[1:]))] = rows


def _copy(old: h5py.File, new: h5py.File, anew: str | None = None) -> h5py.Group:
    """Take everything over but the step ``anew``, which gets an empty group; return that group.

    Without such a step, return the group of all steps.
    """
    steps = _copy_root(old, new)
    for name in old["steps"]:
        if name == anew:
            steps.create_group(name)
        else:
            old.copy(f"steps/{name}", steps, name=name)
    return steps if anew is None else steps.require_group(anew)


def _copy_root(old: h5py.File, new: h5py.File) -> h5py.Group:
    """Take over what a file says of itself; return the group for its steps."""
    new.attrs["format_version"] = FORMAT_VERSION
    for key in ("versions", "source", "model", "run"):
        old.copy(key, new)
    return new.create_group("steps", track_order=True)


def compact_step(path: Path, name: str) -> Step:
    """Take the spare room out of a step's arrays; return the step.

    Where the step is a branch that is done, write its table of special points.
    """
    step = read_results(path, name).step(name)
    if step.compact:
        return step

    def change(old: h5py.File | None, new: h5py.File) -> None:
        assert old is not None
        had, target = old[f"steps/{name}"], _copy(old, new, anew=name)
        for key in ("kind", "meta"):
            old.copy(had[key], target)
        lengths = {"finished": 1, "termination": N_TERMINATIONS} | {
            f"points/{key}": len(rows) for key, rows in step.points.items()
        }
        lengths |= {f"orbits/{key}": len(rows) for key, rows in step.orbits.items()}
        for key, n in lengths.items():
            _array(target, had, key, had[key].dtype.str, had[key].shape[1:], n, n)
        _write_special_points(target, step)

    _rewrite(path, change)
    return replace(step, compact=True)


def _write_special_points(target: h5py.Group, step: Step) -> None:
    """Write the table of special points of a branch that is done."""
    if step.done and step.format.has_branch:
        special = [(label, i) for i, label in enumerate(step.labels) if label]
        group = target.create_group("special_points")
        group["label"] = np.array([label.encode() for label, _ in special], dtype="S8")
        group["index"] = np.array([i for _, i in special], dtype="i8")


def upgrade_results(results: Results) -> None:
    """Write a file of an older format, as it was read, as this one's, so that it can be continued."""
    if results.version == FORMAT_VERSION:
        return

    def change(old: h5py.File | None, new: h5py.File) -> None:
        assert old is not None
        steps = _copy_root(old, new)
        for name, step in results.steps.items():
            target, n = steps.create_group(name), len(step)
            for key in ("kind", "meta"):
                old.copy(f"steps/{name}/{key}", target, name=key)
            endings = np.zeros(N_TERMINATIONS, dtype=TEXT.dtype)
            endings[: len(step.endings)] = [_fit(ending, TEXT_BYTES).encode() for ending in step.endings]
            arrays = {"finished": np.array([n]), "termination": endings}
            arrays |= {f"points/{key}": values for key, values in step.points.items()}
            arrays |= {f"orbits/{key}": values for key, values in step.orbits.items()}
            columns = {f"points/{key}": column for key, column in step.format.points.items()}
            columns |= {f"orbits/{key}": column for key, column in step.format.orbits.items()}
            for key, values in arrays.items():
                dtype = columns[key].dtype if key in columns else values.dtype.str
                _array(target, arrays, key, dtype, values.shape[1:], len(values), len(values))
            _write_special_points(target, step)

    _rewrite(results.path, change)


def drop_steps(path: Path, names: Sequence[str]) -> None:
    """Remove steps, finished or not, so that they can be computed anew."""

    def change(old: h5py.File | None, new: h5py.File) -> None:
        assert old is not None
        steps = _copy(old, new)
        for name in names:
            if name in steps:
                del steps[name]

    _rewrite(path, change)


def _fit(reason: Reason, most: int) -> str:
    """Return a reason as JSON of at most so many bytes; the longest text in it is cut where need be."""
    text = reason.to_json()
    while len(text.encode()) > most:
        longest = max(
            (k for k, v in reason.values.items() if isinstance(v, str)), key=lambda k: len(str(reason.values[k]))
        )
        cut = str(reason.values[longest])[: max(0, len(str(reason.values[longest])) - (len(text.encode()) - most))]
        reason = Reason(reason.code, {**reason.values, longest: cut})
        text = reason.to_json()
    return text
