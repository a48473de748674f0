"""How far a branch has come, in words and as a share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray


@dataclass(eq=False)
class RangeCovered:
    """What a branch has covered of the ranges of its free parameters, ``ranges`` of shape (n_free, 2)."""

    names: Sequence[str]
    ranges: NDArray[np.float64]
    seen: list[NDArray[np.float64]] = field(default_factory=list)

    def describe(self, n_points: int, values: Sequence[float], kind: str) -> tuple[str, float]:
        """Return where a branch is, in words, and the share of its range that it has covered.

        Of two free parameters that one counts of which more is covered: a curve ends where the first leaves its range.
        """
        place = np.asarray(values, dtype=float)
        self.seen = [np.min([*self.seen[:1], place], axis=0), np.max([*self.seen[1:], place], axis=0)]
        widths = self.ranges[:, 1] - self.ranges[:, 0]
        share = float(np.max((self.seen[1] - self.seen[0]) / np.where(widths > 0.0, widths, np.inf)))
        shown = ", ".join(f"{name} = {value:.8g}" for name, value in zip(self.names, place, strict=True))
        return f"{n_points} points, {shown}{f' {kind}' if kind else ''}", min(1.0, share)
