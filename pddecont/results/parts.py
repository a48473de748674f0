"""Parts of a results file in memory: arrays of a few rows that lie side by side are written together."""

from __future__ import annotations

import math
import os
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

# Bytes of headers between two arrays of one part.
GAP = 1 << 13


@dataclass(frozen=True, slots=True)
class Place:
    """Where the rows of an array lie in the file: type and shape of a row, its bytes, where the first one begins."""

    dtype: np.dtype[Any]
    shape: tuple[int, ...]
    row_bytes: int
    offset: int


class Part:
    """A part of a file in memory, from ``offset`` on; ``rows`` are the arrays that lie there, by name."""

    def __init__(self, descriptor: int, places: Mapping[str, Place], n_rows: int):
        self.offset = min(place.offset for place in places.values())
        end = max(place.offset + n_rows * place.row_bytes for place in places.values())
        self.image = bytearray(os.pread(descriptor, end - self.offset, self.offset))
        self.rows = {
            name: np.frombuffer(
                self.image, place.dtype, n_rows * math.prod(place.shape), place.offset - self.offset
            ).reshape(n_rows, *place.shape)
            for name, place in places.items()
        }


def find_parts(places: Mapping[str, Place], n_rows: int, names: Collection[str]) -> list[dict[str, Place]]:
    """Return those of the arrays ``names`` (n_rows,) that lie side by side, nothing between them but what HDF5 says."""
    parts: list[dict[str, Place]] = []
    end = -math.inf
    for name, place in sorted(places.items(), key=lambda item: item[1].offset):
        if not place.row_bytes:
            continue
        if name not in names:
            end = -math.inf
            continue
        if place.offset - end > GAP:
            parts.append({})
        parts[-1][name] = place
        end = place.offset + n_rows * place.row_bytes
    return parts
