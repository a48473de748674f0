"""A results file arranged in memory and put in place at once.

The structure of a file only ever changes by writing a new file beside it and renaming that onto the old one, which is
atomic. HDF5 arranges a file in memory; plain system calls put it on the disk. The library itself must not meet a full
disk: after a failed write it can neither close the file nor let the process end.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from h5py import h5d, h5o, h5p, h5s, h5t
from numpy.typing import NDArray

from pddecont.errors import ResultsError
from pddecont.reasons import Reason
from pddecont.results.format import FORMAT_VERSION, TEXT_BYTES, Column
from pddecont.results.lock import part_of

# Bytes by which a file grows in memory.
BLOCK = 1 << 20
TEXT = Column(f"S{TEXT_BYTES}")


def rewrite(path: Path, change: Callable[[h5py.File | None, h5py.File], None], *, fresh: bool = False) -> None:
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
            write_all(stream.fileno(), image, 0)
        os.replace(temporary, path)
    except OSError as exc:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)
        raise make_write_error(path, exc) from exc


def write_all(descriptor: int, data: bytes | bytearray, offset: int) -> None:
    """Write all of ``data`` at ``offset``; the system may take it in pieces."""
    done = os.pwrite(descriptor, data, offset)
    while done < len(data):
        done += os.pwrite(descriptor, memoryview(data)[done:], offset + done)


def make_write_error(path: Path, exc: OSError) -> ResultsError:
    """Return the error for a file that cannot be written."""
    return ResultsError(
        f"{path} cannot be written: {exc.strerror or exc}; what was finished is kept. Check the folder and the space "
        f"on "
        "the disk, then go on with --resume"
    )


def write_text(target: h5py.Group, name: str, text: str) -> None:
    """Write a text as an array of its own.

    Its length is fixed, as heaps of texts of any length are where damage ends a reader.
    """
    data = text.encode() or b" "
    kind = h5t.py_create(h5py.string_dtype("utf-8", len(data)), logical=True)
    array = h5d.create(target.id, name.encode(), kind, h5s.create(h5s.SCALAR), dcpl=_make_layout())
    array.write(h5s.ALL, h5s.ALL, np.array(data), kind)


def make_arrays(target: h5py.Group, arrays: Iterable[tuple[str, NDArray[Any]]]) -> dict[str, int]:
    """Write arrays, by their paths within a group, each at a fixed place in the file; return those places."""
    layout, groups, places = _make_layout(), {"": target.id}, {}
    for name, values in arrays:
        parent, _, leaf = name.rpartition("/")
        if parent not in groups:
            groups[parent] = target.create_group(parent).id
        kind = h5t.py_create(np.dtype(values.dtype.str), logical=True)
        dataset = h5d.create(groups[parent], leaf.encode(), kind, h5s.create_simple(values.shape), dcpl=layout)
        if values.size:
            dataset.write(h5s.ALL, h5s.ALL, np.ascontiguousarray(values), kind)
            places[name] = dataset.get_offset()
    return places


def _make_layout() -> h5p.PropDCID:
    """Return how arrays lie in a file: whole, at a place that is fixed at once, and without the time they were made."""
    layout = h5p.create(h5p.DATASET_CREATE)
    layout.set_layout(h5d.CONTIGUOUS)
    layout.set_alloc_time(h5d.ALLOC_TIME_EARLY)
    layout.set_obj_track_times(False)
    return layout


def copy_steps(old: h5py.File, new: h5py.File, anew: str | None = None) -> h5py.Group:
    """Take everything over but the step ``anew``, which gets an empty group; return that group.

    Without such a step, return the group of all steps.
    """
    steps = copy_root(old, new)
    for name in old["steps"]:
        if name == anew:
            steps.create_group(name)
        else:
            h5o.copy(old.id, f"steps/{name}".encode(), steps.id, name.encode())
    return steps if anew is None else steps.require_group(anew)


def copy_root(old: h5py.File, new: h5py.File) -> h5py.Group:
    """Take over what a file says of itself; return the group for its steps."""
    new.attrs["format_version"] = FORMAT_VERSION
    for key in ("versions", "source", "model", "run"):
        h5o.copy(old.id, key.encode(), new.id, key.encode())
    return new.create_group("steps", track_order=True)


def fit_reason(reason: Reason, most: int) -> str:
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
