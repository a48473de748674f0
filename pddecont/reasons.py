"""Why something ended, failed or is special, as data: a code and what belongs to it.

Words are made of it where it is shown (``pddecont.tables``), never looked up in again.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

Scalar = str | int | float | bool
# The value of a point that could not be located better than to this part of a step.
WITHIN = "within_step"
# The value of an equilibrium at which terms that read rates of the past are so strong together; of what says no more.
NEUTRAL = "neutral_radius"


@dataclass(frozen=True)
class Reason:
    """A code with named values; the empty code stands for no reason."""

    code: str = ""
    values: Mapping[str, Scalar] = field(default_factory=dict)

    def __bool__(self) -> bool:
        return bool(self.code)

    def to_json(self) -> str:
        """Return the reason as one line of JSON; an empty text for none."""
        return json.dumps({"code": self.code, **self.values}) if self else ""


NO_REASON = Reason()


def make_reason(code: str, **values: Scalar) -> Reason:
    """Return the reason of a code with its values."""
    return Reason(code, values)


def reason_from_json(text: str) -> Reason:
    """Return the reason that :meth:`Reason.to_json` wrote.

    Raises
    ------
    ValueError
        If the text is none.
    """
    if not text:
        return NO_REASON
    data: Any = json.loads(text)
    if not isinstance(data, dict) or not isinstance(data.get("code"), str):
        raise ValueError("a reason is a mapping with a code")
    if not all(isinstance(value, str | int | float | bool) for value in data.values()):
        raise ValueError("a reason's values are texts and numbers")
    return Reason(data.pop("code"), data)
