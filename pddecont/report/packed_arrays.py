"""Arrays of numbers as text that a page holds and its script reads: a header and one block, compressed."""

from __future__ import annotations

import base64
import json
import zlib
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

# The element types that a page's script reads, in the order of their bytes in memory.
TYPES = ("<f8", "<f4", "<u4", "<i4", "<u2")
# A block begins with the length of its header in so many bytes.
LENGTH_BYTES = 4

# Where an array lies in the block: first byte, number of elements, type.
Place = list[Any]


class ArrayPacker:
    """Collects arrays; :meth:`pack` returns them with a header as text.

    Of each array the first bytes of all elements stand together, then the second ones, and so on: neighbours are alike,
    and compress to less.
    """

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._size = 0

    def add(self, values: ArrayLike, dtype: str) -> Place:
        """Add an array and return its place, which belongs into the header."""
        data = np.ascontiguousarray(values, dtype=dtype).ravel()
        shuffled = data.view(np.uint8).reshape(-1, data.itemsize).T.tobytes()
        place = [self._size, len(data), dtype[1:]]
        self._parts.append(shuffled)
        self._size += len(shuffled)
        return place

    def pack(self, header: Any) -> str:
        """Return header and arrays as letters that need no escaping in a page (base64 of a deflated block)."""
        text = json.dumps(header, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode()
        block = b"".join([len(text).to_bytes(LENGTH_BYTES, "little"), text, *self._parts])
        return base64.b64encode(zlib.compress(block, 7)).decode()
