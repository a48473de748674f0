"""Texts of variable length lie in heaps of an HDF5 file; a damaged one sends the library round for ever.

A heap begins with ``GCOL``, its version (1) and its size, and holds objects one after another: a number, a count, 4 bytes of nothing, a
size and so many bytes, filled up to a multiple of 8. Number 0 is the room that is left, its own head included.
"""

from __future__ import annotations

import mmap
import struct
from pathlib import Path

from pddecont.errors import ResultsError

MARK = b"GCOL\x01\x00\x00\x00"
HEAD = 16


def check_heaps(path: Path) -> None:
    """Raise :class:`ResultsError` if a heap of the file does not hold what it says."""
    if not path.stat().st_size:
        return
    with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
        at = data.find(MARK)
        while at >= 0:
            _check(data, at)
            at = data.find(MARK, at + 1)


def _check(data: mmap.mmap, at: int) -> None:
    if at + HEAD > len(data):
        raise ResultsError("a text in it is cut off")
    end = at + struct.unpack_from("<Q", data, at + 8)[0]
    if end > len(data):
        raise ResultsError("a text in it is cut off")
    at += HEAD
    while at + HEAD <= end:
        number, _, _, size = struct.unpack_from("<HHIQ", data, at)
        step = HEAD + -(-size // 8) * 8 if number else size
        if step < HEAD or at + step > end:
            raise ResultsError("a text in it does not end where it should")
        at += step
