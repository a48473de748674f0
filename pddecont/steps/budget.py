"""How much may be computed of what has no end of its own."""

from __future__ import annotations

import time
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Budget:
    """What an exploration may spend: seconds from when the budget is made, and branches (None: as its step says).

    It is no part of a run: a file that was left when one was spent goes on with another.
    """

    seconds: float | None = None
    max_branches: int | None = None
    since: float = field(default_factory=time.monotonic)

    @property
    def is_over(self) -> bool:
        """Whether the time is over."""
        return self.seconds is not None and time.monotonic() - self.since > self.seconds
