"""How much may be computed of what has no end of its own."""

from __future__ import annotations

import time
from dataclasses import dataclass, field


class OutOfTimeError(Exception):
    """The time is over amid a step; what the file holds of it goes on when it is resumed."""


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

    def check(self) -> None:
        """Raise :class:`OutOfTimeError` if the time is over: asked where a step can be left, and go on from there."""
        if self.is_over:
            raise OutOfTimeError
