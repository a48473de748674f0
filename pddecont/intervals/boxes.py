"""Boxes: one interval for each unknown."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from pddecont.intervals.arithmetic import Array, Bools

# So many boxes are told apart by where they lie.
MERGED = 1000


@dataclass(frozen=True, eq=False)
class Boxes:
    """Boxes from ``low`` to ``high``, shape (n_variables, n_boxes) each."""

    low: Array
    high: Array

    @property
    def center(self) -> Array:
        """Their midpoints."""
        return np.clip(0.5 * self.low + 0.5 * self.high, self.low, self.high)

    @property
    def widths(self) -> Array:
        """Their widths."""
        return self.high - self.low

    @property
    def is_empty(self) -> Bools:
        """Whether a box holds nothing: an end is on the wrong side of the other."""
        return np.asarray(np.any(self.low > self.high, axis=0))

    def __len__(self) -> int:
        return int(self.low.shape[1])

    def __getitem__(self, chosen: Any) -> Boxes:
        return Boxes(self.low[:, chosen], self.high[:, chosen])

    def lie_in(self, other: Boxes) -> Bools:
        """Return which of the boxes lie in one other."""
        return np.asarray(np.all((self.low >= other.low) & (self.high <= other.high), axis=0))

    def bisect(self, sizes: Array) -> Boxes:
        """Return both halves of each box, cut across its largest width relative to ``sizes`` (n_variables,)."""
        across = np.argmax(self.widths / sizes[:, None], axis=0)
        columns = np.arange(len(self))
        middle = self.center[across, columns]
        low, high = self.low.copy(), self.high.copy()
        low[across, columns] = middle
        high[across, columns] = middle
        return join_boxes([Boxes(self.low, high), Boxes(low, self.high)])


def make_box(low: Array, high: Array) -> Boxes:
    """Return one box."""
    return Boxes(np.asarray(low, dtype=float)[:, None], np.asarray(high, dtype=float)[:, None])


def join_boxes(parts: list[Boxes]) -> Boxes:
    """Return all boxes together."""
    return Boxes(np.concatenate([p.low for p in parts], axis=1), np.concatenate([p.high for p in parts], axis=1))


def merge_boxes(boxes: Boxes, sizes: Array) -> Boxes:
    """Return the hulls of boxes that lie close together: no farther than they are wide, relative to ``sizes``.

    Of more boxes than ``MERGED`` it is one.
    """
    if len(boxes) < 2:
        return boxes
    if len(boxes) > MERGED:
        return make_box(boxes.low.min(axis=1), boxes.high.max(axis=1))
    center, widths = boxes.center / sizes[:, None], boxes.widths / sizes[:, None]
    reach = 2.0 * float(np.max(widths))
    pairs = cKDTree(center.T).query_pairs(reach, p=np.inf, output_type="ndarray")
    links = sp.coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(boxes), len(boxes)))
    n, labels = connected_components(links, directed=False)
    groups = [boxes[labels == k] for k in range(n)]
    return join_boxes([make_box(g.low.min(axis=1), g.high.max(axis=1)) for g in groups])
