"""Arrays and texts as they stand in a results file; files come from strangers too.

An array is read only if it lies in the file itself, whole and plain, as the program writes it: no links to other files,
no virtual or external data, no filters, no room that is promised and not there. What is read is then never larger than
the file. A file holds some fifty arrays a step: they are opened by the plain calls of HDF5, as the objects that h5py
makes of them cost more than what is read.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from h5py import h5d, h5g, h5l, h5o, h5s, h5t
from numpy.typing import NDArray

from pddecont.errors import ResultsError

# Types that were met, by how HDF5 writes them.
_DTYPES: dict[bytes, np.dtype[Any]] = {}


@dataclass(frozen=True, slots=True)
class StoredArray:
    """An array of numbers or texts of fixed length that is wholly there; it is looked at, and not yet read."""

    name: str
    item: h5d.DatasetID
    kind: h5t.TypeID
    dtype: np.dtype[Any]
    shape: tuple[int, ...]

    def __len__(self) -> int:
        return self.shape[0]

    def read(self, room: list[int] | None = None, n: int | None = None) -> NDArray[Any]:
        """Return the first ``n`` rows (or all); ``room`` holds the bytes that may still be read and is lessened."""
        if not self.shape:
            raise ResultsError(f"'{self.name}' is not an array")
        n = len(self) if n is None else n
        if not 0 <= n <= len(self):
            raise ResultsError(f"'{self.name}' has {len(self)} rows; {n} are counted")
        return self._read((n, *self.shape[1:]), room)

    def read_text(self, room: list[int]) -> str:
        """Return a text that is stored as an array of its own."""
        if self.shape != () or self.dtype.kind != "S":
            raise ResultsError(f"'{self.name}' is not a text")
        result: bytes = self._read((), room).item()
        return result.decode()

    def _read(self, shape: tuple[int, ...], room: list[int] | None) -> NDArray[Any]:
        if room is not None:
            room[0] -= self.dtype.itemsize * math.prod(shape)
            if room[0] < 0:
                raise ResultsError(f"'{self.name}' claims more than the file holds")
        result = np.empty(shape, self.dtype)
        if shape == self.shape and result.size:
            self.item.read(h5s.ALL, h5s.ALL, result, self.kind)
        elif result.size:
            place = self.item.get_space()
            place.select_hyperslab((0,) * len(shape), shape)
            self.item.read(h5s.create_simple(shape), place, result, self.kind)
        return result


def open_group(parent: h5g.GroupID, name: str) -> h5g.GroupID:
    """Return a group that stands in the file itself."""
    item = h5o.open(parent, _find(parent, name))
    if not isinstance(item, h5g.GroupID):
        raise ResultsError(f"'{name}' is not stored as a group")
    return item


def open_array(parent: h5g.GroupID, name: str) -> StoredArray:
    """Return an array that stands in the file itself; its type and place are looked at before its contents."""
    place = _find(parent, name)
    try:
        item = h5d.open(parent, place)
    except KeyError as exc:
        raise ResultsError(f"'{name}' is not stored as a dataset") from exc
    kind, plist = item.get_type(), item.get_create_plist()
    if kind.get_class() not in (h5t.INTEGER, h5t.FLOAT, h5t.STRING) or kind.detect_class(h5t.VLEN):
        raise ResultsError(f"'{name}' is not an array of numbers or text")
    if isinstance(kind, h5t.TypeStringID) and kind.is_variable_str():
        raise ResultsError(f"'{name}' is a text of variable length; only those of fixed length are read")
    if plist.get_layout() != h5d.CONTIGUOUS or plist.get_external_count() or plist.get_nfilters():
        raise ResultsError(f"'{name}' is not stored as this program stores arrays")
    dtype, shape = _find_dtype(kind), item.shape
    if dtype.kind not in "fiuS" or dtype.itemsize * math.prod(shape) != item.get_storage_size():
        raise ResultsError(f"'{name}' is not an array of numbers or text that is wholly there")
    return StoredArray(name, item, kind, dtype, shape)


def list_names(group: h5g.GroupID) -> list[str]:
    """Return the names in a group, in the order that it keeps."""
    return [name.decode() for name in group]


def _find(parent: h5g.GroupID, name: str) -> bytes:
    """Return a name as HDF5 has it, if what it names stands in the file itself."""
    place = name.encode()
    if not parent.links.exists(place) or parent.links.get_info(place).type != h5l.TYPE_HARD:
        raise ResultsError(f"'{name}' is missing or leads elsewhere; only what stands in the file itself is read")
    return place


def _find_dtype(kind: h5t.TypeID) -> np.dtype[Any]:
    """Return the type of numpy for one of HDF5; a file holds the same few again and again."""
    key: bytes = kind.encode()
    if key not in _DTYPES:
        _DTYPES[key] = kind.dtype
    return _DTYPES[key]
