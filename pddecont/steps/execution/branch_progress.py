"""How far a branch has come, in words and as a share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field


@dataclass(eq=False)
class RangeCovered:
    """What a branch has covered of the ``ranges`` (low, high) of its free parameters."""

    names: Sequence[str]
    ranges: Sequence[tuple[float, float]]
    seen: list[tuple[float, float]] = field(default_factory=list)

    def describe(self, n_points: int, values: Sequence[float], kind: str) -> tuple[str, float]:
        """Return where a branch is, in words, and the share of its range that it has covered.

        Of two free parameters that one counts of which more is covered: a curve ends where the first leaves its range.
        """
        place = [float(value) for value in values]
        before = self.seen or list(zip(place, place, strict=True))
        self.seen = [(min(low, v), max(high, v)) for (low, high), v in zip(before, place, strict=True)]
        share = max(
            (last - first) / (high - low) if high > low else 0.0
            for (first, last), (low, high) in zip(self.seen, self.ranges, strict=True)
        )
        shown = ", ".join(f"{name} = {value:.8g}" for name, value in zip(self.names, place, strict=True))
        return f"{n_points} points, {shown}{f' {kind}' if kind else ''}", min(1.0, share)
