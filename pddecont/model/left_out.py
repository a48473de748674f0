"""What a model lost with its effects, and why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class LeftOut:
    """The effects left out, and by kind (states, modes, ...) the names of what went with them, each with the reason."""

    effects: tuple[str, ...] = ()
    reasons: Mapping[str, Mapping[str, str]] = field(default_factory=dict)

    def hint(self, kind: str, name: str) -> str:
        """Return what to add to a message about a missing name: "; it is left out: ..." or an empty text."""
        reason = self.reasons.get(kind, {}).get(name)
        return f"; it is left out: {reason}" if reason else ""

    def as_data(self) -> dict[str, Any]:
        """Return the same as plain data, for files and ``info``."""
        return (
            {"effects": list(self.effects), **{kind: dict(names) for kind, names in self.reasons.items()}}
            if self.effects
            else {}
        )
