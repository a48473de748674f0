"""User functions (UF): an expression over monitors that is zero."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.orbit.curve import Curve
from pddecont.orbit.monitors import Monitor

Array = NDArray[np.float64]
KIND = "UF"


@dataclass(frozen=True, eq=False)
class UserFunction:
    """The condition that a monitor is zero."""

    monitor: Monitor
    kind: str = KIND

    def value(self, curve: Curve, x: Array) -> float:
        """Return the monitor at the orbit ``x``."""
        return self.monitor.value(curve.problem, x)

    def framed(self, curve: Curve, x: Array) -> UserFunction:
        """Return the same condition."""
        return self
