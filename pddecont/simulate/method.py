"""How to integrate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Method:
    """How to integrate.

    Attributes
    ----------
    rtol, atol
        The error allowed in a step, relative and absolute.
    stiff
        Radau IIA instead of DOP853.
    stick
        The mode that follows where an event accumulates, by the event's name.
    max_step
        The longest step.
    """

    rtol: float = 1e-9
    atol: float = 1e-11
    stiff: bool = False
    stick: Mapping[str, str] = field(default_factory=dict)
    max_step: float = np.inf
